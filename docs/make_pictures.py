"""Makes the pictures of the README from a run that presses on the wall (needs chromium).

python docs/make_pictures.py
"""

from __future__ import annotations

import base64
import shutil
import tempfile
from pathlib import Path
from typing import cast

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from playwright.sync_api import sync_playwright
from pydrake.geometry import Meshcat

import scara_drake as sd
from scara_drake import plotting
from scara_drake.common.motion import minimum_jerk
from scara_drake.operator.joystick import Joystick
from scara_drake.operator.mapping import JoystickMapping
from scara_drake.operator.shipped_trace import stick_for
from scara_drake.operator.trace import COLUMNS

FOLDER = Path(__file__).parent
TURN = 4.6  # [s] of a loop along the wall
END = 7.0  # [s]
SIZE = (1280, 720)
CHROMIUM_ARGUMENTS = [
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
]


def looping_trace(mapping: JoystickMapping) -> str:
    """Return a trace (CSV) that presses on the wall of `teleoperation` and loops along it."""
    lines = [",".join(COLUMNS)]
    for time in np.arange(0.0, END, 0.01):
        x = min(time / 2.0, 1.0)
        angle = 2.0 * np.pi * max(time - 2.0, 0.0) / TURN
        offsets = (
            0.3 * np.sin(angle),
            -0.305 * minimum_jerk(x),
            0.2 * (1 - np.cos(angle)),
        )
        sticks = [stick_for(offset, mapping) for offset in offsets]
        lines.append(f"{time:.2f}," + ",".join(f"{stick:.5f}" for stick in [*sticks, 0.0, 0.0]))
    return "\n".join(lines) + "\n"


def save_scene(meshcat: Meshcat, path: Path) -> None:
    """Save what a Meshcat shows as a PNG."""
    width, height = SIZE
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=CHROMIUM_ARGUMENTS
        )
        page = browser.new_page(viewport={"width": width, "height": height})
        page.goto(meshcat.web_url())
        page.wait_for_function("typeof viewer !== 'undefined'")
        page.wait_for_timeout(3000)  # the scene comes in over a socket
        url = page.evaluate(f"viewer.capture_image({width}, {height})")
        browser.close()
    path.write_bytes(base64.b64decode(url.split(",", 1)[1]))


def save_plots(recording: xr.Dataset, path: Path) -> None:
    """Save the tool path, the contact and the haptics of a run as a PNG."""
    figure = Figure(figsize=(13, 4), layout="constrained")
    left, middle, right = figure.subplots(1, 3)
    plotting.tool_path(recording, left)
    plotting.contact_force(recording.sel(time=slice(17.5, 19.25)), middle)
    plotting.haptic(recording.sel(time=slice(17.5, 19.25)), right)
    for axes, title in (
        (left, "The tool, seen from above"),
        (middle, "Contact"),
        (right, "What the operator feels"),
    ):
        axes.set_title(title)
    figure.savefig(path, dpi=100)


def main() -> None:
    """Make docs/scene.png and docs/press.png."""
    scenario = sd.load_scenario("teleoperation")
    operator = cast(Joystick, scenario.operator)
    save_plots(sd.simulate(scenario), FOLDER / "press.png")
    with tempfile.TemporaryDirectory() as folder:
        trace = Path(folder) / "loop.csv"
        trace.write_text(looping_trace(operator.mapping))
        operator.trace = str(trace)
        meshcat = Meshcat()
        sd.simulate(scenario, END, meshcat=meshcat)
    meshcat.SetCameraPose(np.array([3.9, 1.3, 4.7]), np.array([0.5, -0.62, 3.1]))
    save_scene(meshcat, FOLDER / "scene.png")


if __name__ == "__main__":
    main()
