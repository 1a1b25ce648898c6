"""A live run, with a fault in it, plays again to the same bits from what it has recorded."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Iterator

import numpy as np
import pytest

os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
if not os.environ.get("DISPLAY"):
    os.environ.setdefault("SDL_VIDEODRIVER", "dummy")

import pygame
import xarray as xr
from engines import FREE, gaps
from virtual_pad import VirtualPad, load_sdl

import scara_drake as sd
from scara_drake.cli.main import main
from scara_drake.operator.devices.sample import Sample
from scara_drake.operator.devices.scripted import ScriptedDevice
from scara_drake.safety import State
from scara_drake.scenario import Scenario
from scara_drake.simulation.run import simulate
from scara_drake.vectors import LIVE_SETTINGS, NEUTRAL_SETTINGS, OPERATOR_BUTTONS

ENGAGE = 0  # button of a flight stick
CHANGES = {"duration": 2.0, "channel.up": "!ConstantDelay {delay: 0.02}"}


def played_again(recording: xr.Dataset, tmp_path, engine: str) -> xr.Dataset:
    """The run of the recording's own scenario with the trace that is exported of it."""
    live = tmp_path / "live.nc"
    sd.save_recording(recording, live)
    trace = tmp_path / "again.csv"
    assert main(["export", str(live), "--to", "trace", "--output", str(trace)]) == 0
    text = tmp_path / "again.yaml"
    text.write_text(recording.attrs["scenario"])
    changes = {"operator.device": "trace", "operator.trace": str(trace)}
    return simulate(sd.load_scenario(text, changes), engine=engine)


def assert_plays_again(recording: xr.Dataset, tmp_path, compiled: bool) -> None:
    again = played_again(recording, tmp_path, "drake")
    assert list(again.data_vars) == list(recording.data_vars)
    for name in recording.data_vars:
        np.testing.assert_array_equal(again[name].values, recording[name].values, err_msg=str(name))
    if compiled:
        other = played_again(recording, tmp_path, "compiled")
        assert other.attrs["engine"] == "compiled"
        assert max(gaps(other, again).values()) < FREE


def stopped_after_it_moved(recording: xr.Dataset) -> bool:
    """Whether the arm was engaged and moved, and stood at the end."""
    states = recording.robot_state.values
    return bool(
        (states == State.ACTIVE).any()
        and states[-1] != State.ACTIVE
        and abs(recording.v_measured).max() > 1e-2
        and abs(recording.v_measured[-1]).max() < 1e-3
    )


@pytest.mark.parametrize("compiled", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_a_script_in_real_time_plays_again(compiled: bool, tmp_path) -> None:
    """Every axis, button and setting changes, and the device is lost while the arm moves."""

    def said(t: float) -> Sample:
        return Sample(
            connected=t < 1.2,
            stamp=0.0,
            axes=np.array([0.6 * np.sin(5.0 * t), 0.3 * np.sin(7.0 * t), 0.2 * t, 0.0, 0.0]),
            orientation=np.array([0.0, 0.0, 0.3 * np.sin(4.0 * t)]),
            buttons=OPERATOR_BUTTONS.pack(
                engage=float(t > 0.4), clutch=float(0.7 < t < 0.8), hold=0.0, reset=0.0,
                estop=0.0, mast=0.0,
            ),
            settings=LIVE_SETTINGS.pack(
                **NEUTRAL_SETTINGS._replace(
                    delay_up=0.05 if t > 0.3 else 0.0,
                    delay_down=0.03 if t > 0.4 else 0.0,
                    gain_scale=0.8 if t > 0.5 else 1.0,
                    motion_scale=0.7 if t > 0.8 else 1.0,
                )._asdict()
            ),
        )  # fmt: skip

    scenario: Scenario = sd.load_scenario("teleoperation", {**CHANGES, "supervision": "{}"})
    scenario.operator.lend(ScriptedDevice(said))  # type: ignore[union-attr]  # it is a Joystick
    recording = simulate(scenario, realtime_rate=1.0)
    assert recording.attrs["ticks"] == 2000
    assert float(recording.live_delay_up.max()) == pytest.approx(0.05)
    assert float(recording.delay_up.max()) > 0.06
    assert stopped_after_it_moved(recording)
    assert_plays_again(recording, tmp_path, compiled)


@pytest.fixture
def pad() -> Iterator[VirtualPad]:
    made = VirtualPad()
    yield made
    made.unplug()
    pygame.event.get()


@pytest.mark.device
@pytest.mark.skipif(load_sdl() is None, reason="pygame's SDL library was not found")
def test_a_pad_that_is_pulled_out_in_real_time_plays_again(pad: VirtualPad, tmp_path) -> None:
    def play() -> None:
        start = time.monotonic()
        while (t := time.monotonic() - start) < 60.0 and not done.is_set():
            if t > 1.4:
                pad.unplug()
                return
            pad.button(ENGAGE, t > 0.3)
            pad.axis(0, 0.6 * np.sin(3.0 * max(t - 0.3, 0.0)))
            time.sleep(0.01)

    changes = {**CHANGES, "operator.device": "joystick", "supervision": "{}"}
    scenario = sd.load_scenario("teleoperation", changes)
    simulate(sd.load_scenario("teleoperation", {**changes, "duration": 0.01}), realtime_rate=1.0)
    done = threading.Event()
    player = threading.Thread(target=play)
    player.start()
    try:
        recording = simulate(scenario, realtime_rate=1.0)
    finally:
        done.set()
        player.join()
    assert float(recording.device_connected.min()) == 0.0
    assert_plays_again(recording, tmp_path, compiled=False)
