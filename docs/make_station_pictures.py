"""Makes the pictures of docs/station.md: its page at rest, in contact and in a fault (chromium).

python docs/make_station_pictures.py

A scripted operator presses on the wall, and then too hard. The run is simulated first and then
played to the page at its own pace, so the pictures do not depend on how fast this machine is.
"""

from __future__ import annotations

import tempfile
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
from make_pictures import CHROMIUM_ARGUMENTS
from PIL import Image
from playwright.sync_api import Page, sync_playwright
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from scara_drake.diagram import make_diagram
from scara_drake.operator.joystick import Joystick
from scara_drake.scenario import Scenario, load_scenario
from scara_drake.station.feed import StationFeed
from scara_drake.station.place import Place
from scara_drake.station.station import Station
from scara_drake.supervision.config import Supervision
from scara_drake.wiring import Signals, connect_by_name

FOLDER = Path(__file__).parent
END = 18.0  # [s]
ENGAGED = 3.5  # [s]
# Time [s] and the stick, forward is negative. The wall is 0.58 of its travel away.
SCRIPT = [(0.0, 0.0), (4.0, 0.0), (6.0, -0.6), (12.0, -0.62), (12.7, -0.8), (END, -0.8)]
# What is on them lasts for some seconds more: a busy machine may be late. [s]
PICTURES = {"rest": 1.2, "contact": 8.5, "fault": 14.5}
SIZE = (1280, 800)


class Frames:
    """Stands for a station at a run, and keeps all that it would show."""

    def __init__(self) -> None:
        self.frames: list[Any] = []

    def write(self, frame: Any) -> None:
        """Keep a frame, as a `Mailbox` would."""
        self.frames.append(frame.copy())

    def add(self, builder: DiagramBuilder, scenario: Scenario, signals: Signals) -> None:
        """Add to a Diagram what leaves the frames."""
        feed = StationFeed(self, scenario.environment.surfaces)  # type: ignore[arg-type]  # it has `write`
        connect_by_name(builder, builder.AddNamedSystem("station", feed), signals)


def pressing(folder: Path) -> Scenario:
    """Return the scenario: a supervised operator of the script."""
    rows = ["time,x,y,z,mast_axis,mast_hat,engage"]
    times, sticks = zip(*SCRIPT, strict=True)
    for t in np.arange(0.0, END, 0.01):
        rows.append(f"{t:.2f},0,{np.interp(t, times, sticks):.4f},0,0,0,{int(t >= ENGAGED)}")
    trace = folder / "press.csv"
    trace.write_text("\n".join(rows) + "\n")
    scenario = load_scenario("teleoperation")
    scenario.operator = Joystick(trace=str(trace))
    scenario.supervision = Supervision()
    scenario.duration = END
    return scenario


def play(frames: list[Any], station: Station, clock: threading.Event, start: float) -> None:
    """Leave the frames for the server at their own times."""
    for frame in frames:
        while time.monotonic() - start < float(frame["t"]):
            time.sleep(0.002)
        frame["wall"] = time.monotonic()
        frame["late_ticks"] = 0
        station._mailboxes.frame.write(frame)
        if clock.is_set():
            return


def photograph(page: Page, name: str) -> Path:
    """Store what is on the screen, in 256 colours."""
    path = FOLDER / f"station_{name}.png"
    page.screenshot(path=path)
    with Image.open(path) as picture:
        small = picture.convert("RGB").quantize(256, dither=Image.Dither.NONE)
    small.save(path, optimize=True)
    return path


def main() -> None:
    """Simulate, play, photograph."""
    frames = Frames()
    with tempfile.TemporaryDirectory() as folder:
        scenario = pressing(Path(folder))
        Simulator(make_diagram(scenario, station=frames)).AdvanceTo(END)
        station, done = Station(scenario, Place()), threading.Event()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path="/usr/bin/chromium", args=CHROMIUM_ARGUMENTS
        )
        page = browser.new_page(viewport={"width": SIZE[0], "height": SIZE[1]})
        page.goto(station.address)
        page.click("#take")
        page.wait_for_selector("body[data-mine=true]")
        play(frames.frames[:1], station, done, time.monotonic())
        page.wait_for_selector('#lag:text-matches("[0-9]")')  # the first picture is drawn
        start = time.monotonic() + 0.5
        player = threading.Thread(target=play, args=(frames.frames, station, done, start))
        player.start()
        for name, t in PICTURES.items():
            page.wait_for_timeout(1e3 * max(0.0, start + t - 1.0 - time.monotonic()))
            if name == "contact":
                page.keyboard.down("Space")
                page.keyboard.down("KeyW")
            page.wait_for_timeout(1e3 * max(0.0, start + t - time.monotonic()))
            print(photograph(page, name))  # noqa: T201  # a script
        done.set()
        player.join()
        browser.close()
    station.close()


if __name__ == "__main__":
    main()
