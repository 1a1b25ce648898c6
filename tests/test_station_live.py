"""A browser at a run in real time: its keys move the arm, and closing its tab stops it."""

from __future__ import annotations

import threading
from typing import Any

import numpy as np
import pytest
from browser import CHROMIUM, needs_chromium
from station_rig import serving

from scara_drake.kinematics import forward_kinematics
from scara_drake.recordings.samples import Samples
from scara_drake.safety import Reason, State
from scara_drake.scenario import load_scenario
from scara_drake.simulation.run import Live, run_into

pytestmark = [needs_chromium, pytest.mark.slow]
DURATION = 15.0  # [s]
DRIVEN = 0.03  # [m]
AT_REST = 5e-3  # [m/s]
SHOWS = "state => document.getElementById('state').textContent === state"


def sit_at(address: str, opened: threading.Event) -> None:
    """Open the page without drawing, take control, hold Space and a key, close the tab."""
    from playwright.sync_api import sync_playwright

    arguments = ["--no-sandbox", "--disable-3d-apis"]
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=arguments)
        page = browser.new_page()
        page.goto(address)
        page.wait_for_selector("body[data-online=true]")
        page.click("#take")
        page.wait_for_selector("body[data-mine=true]")
        opened.set()
        page.wait_for_function(SHOWS, arg="IDLE")
        page.wait_for_timeout(500)  # the first report of the robot
        pushed = 0
        while pushed < 15:  # in tenths of a second; a busy machine lets go: then anew
            if page.locator("#state").text_content() == "ACTIVE":
                page.keyboard.down("KeyD")
                pushed += 1
            else:
                pushed = 0
                page.keyboard.up("KeyD")
                page.keyboard.up("Space")
                page.wait_for_timeout(200)
                page.keyboard.down("Space")
                page.wait_for_timeout(300)
            page.wait_for_timeout(100)
        page.close()
        browser.close()


def test_the_keys_of_a_browser_move_the_arm_and_its_closing_stops_it() -> None:
    samples, opened = Samples(), threading.Event()
    with serving(scenario="free_motion") as station:
        scenario = load_scenario("free_motion", {"duration": DURATION})
        operator: Any = scenario.operator
        operator.lend(station.device)
        thread = threading.Thread(target=sit_at, args=(station.address, opened))
        thread.start()
        assert opened.wait(60.0)
        run_into(samples, scenario, Live(1.0, station=station))
        thread.join()
    run = samples.recording()
    followed = np.maximum.accumulate(run.operator_state.values == State.ACTIVE)
    lost = followed & (run.operator_reason.values == Reason.DEVICE_LOST)
    assert lost[-1], "the page did not get so far in time"
    at = int(np.flatnonzero(~lost)[-1]) + 1
    tool = forward_kinematics(run.q_measured.values)[:, :3, 3]
    assert np.linalg.norm(tool[at] - tool[0]) > DRIVEN
    assert run.operator_state[at] == State.HOLD
    speed = np.linalg.norm(np.gradient(tool, 1e-3, axis=0), axis=1)
    assert at + 800 < speed.size, "the page did not get so far in time"
    assert speed[at + 800 :].max() < AT_REST
