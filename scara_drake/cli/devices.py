"""The command `scara-drake devices`: list what is there, show one live, write a profile of one."""

from __future__ import annotations

import argparse
import time
from functools import partial
from pathlib import Path
from typing import Any

from rich.console import Console, Group
from rich.live import Live
from rich.table import Table
from rich.text import Text

from scara_drake.common import checks
from scara_drake.common.files import write_whole
from scara_drake.operator.devices import NoDeviceError, PygameDevice, Sample
from scara_drake.operator.devices.calibration import TICK, Calibration, text_of
from scara_drake.operator.devices.pygame_device import fitting_profile
from scara_drake.operator.devices.sdl import Sdl, has_screen, sdl
from scara_drake.operator.devices.spacemouse import names as spacemouse_names
from scara_drake.vectors import (
    BUTTON_NAMES,
    ORIENTATION_NAMES,
    STICK_NAMES,
    operator_buttons_of,
)

WATCH_PERIOD = 0.05  # [s], from picture to picture
UNFELT = 2e-4  # of a motor; SDL takes a level of 0 for any joystick
BAR = 10  # characters from the middle of an axis to its end


def run(options: argparse.Namespace, console: Console) -> None:
    """List the devices, watch one, or write a profile of one.

    Raises:
        ValueError: no such device, or a file that exists already.
        OSError: the file cannot be written.
    """
    if options.calibrate is not None:
        _calibrate(options, console)
    elif options.watch is not None:
        _watch(options, console)
    else:
        _list(console)


def _list(console: Console) -> None:
    table = Table()
    for column in ("index", "name", "device", "profile", "rumble", "GUID"):
        table.add_column(column, overflow="fold", no_wrap=column not in ("name", "GUID"))
    try:
        system = sdl()
        system.poll()
        for index in range(len(system.joysticks())):
            plugged = system.plugged(index)
            joystick = plugged.joystick
            table.add_row(
                str(index),
                joystick.get_name(),
                "joystick",
                fitting_profile(plugged).name,
                "yes" if _has_motors(joystick) else "no",
                joystick.get_guid(),
            )
    except NoDeviceError as error:
        _say(console, f"No joysticks: {error}")
    try:
        for index, name in enumerate(spacemouse_names()):
            table.add_row(str(index), name, "spacemouse", "spacemouse", "no", "")
    except NoDeviceError as error:
        _say(console, f"No SpaceMouse: {error}")
    if has_screen():
        table.add_row("", "keyboard, in a window of its own", "keyboard", "keyboard", "no", "")
    else:
        _say(console, "No keyboard: there is no display for its window")
    if table.row_count:
        console.print(table)
    else:
        _say(console, "No device is there: operator.device auto plays the recorded operator")


def _has_motors(joystick: Any) -> bool:
    """Return whether a joystick takes a pulse, of which nobody feels anything."""
    feels = bool(joystick.rumble(UNFELT, UNFELT, 1))
    joystick.stop_rumble()
    return feels


def _watch(options: argparse.Namespace, console: Console) -> None:
    seconds = options.seconds
    if seconds is not None:
        checks.number("--seconds", seconds, 0.0, 86400.0)
    device = PygameDevice(options.watch, None, options.profile)
    until = None if seconds is None else time.monotonic() + seconds
    try:
        with Live(_picture(device.name, device.sample()), console=console) as live:
            while until is None or time.monotonic() < until:
                time.sleep(WATCH_PERIOD)
                live.update(_picture(device.name, device.sample()))
    except KeyboardInterrupt:
        pass  # how one ends it
    finally:
        device.close()


def _picture(name: str, sample: Sample) -> Group:
    title = Text(name if sample.connected else f"{name}: unplugged")
    table = Table()
    for column in ("axis", "", "value"):
        table.add_column(column)
    for axis, value in zip(
        (*STICK_NAMES, *ORIENTATION_NAMES), (*sample.axes, *sample.orientation), strict=True
    ):
        table.add_row(axis, _bar(value), f"{value:+.2f}")
    down = operator_buttons_of(sample.buttons)._asdict()
    pressed = [button for button in BUTTON_NAMES if down[button]]
    table.add_row("buttons", ", ".join(pressed) or "-", "")
    return Group(title, table)


def _bar(value: float) -> str:
    """Return an axis as a bar from its middle."""
    length = round(abs(value) * BAR) if abs(value) <= 1.0 else BAR
    left, right = ("#" * length, "") if value < 0.0 else ("", "#" * length)
    return f"{left:>{BAR}}|{right:<{BAR}}"


def _calibrate(options: argparse.Namespace, console: Console) -> None:
    path: Path | None = options.output
    if path is None:
        raise ValueError("--calibrate: no file, allowed with --output FILE.yaml")
    if path.exists():
        raise ValueError(f"--output: '{path}' is there already, allowed a new file")
    checks.number("--patience", options.patience, 0.1, 600.0)
    device = PygameDevice(options.calibrate)  # says which there are, if this one is not
    system = sdl()
    joystick = system.plugged(options.calibrate).joystick
    calibration = Calibration(
        partial(_read_all, system, options.calibrate),
        partial(time.sleep, TICK),
        partial(_say, console),
        options.patience,
    )
    try:
        text = text_of(calibration.profile(joystick.get_guid()), joystick.get_name())
    finally:
        device.close()
    write_whole(path, text)
    _say(console, f"Profile: {path}; use it with --set operator.profile={path}")


def _read_all(system: Sdl, index: int) -> dict[str, float]:
    """Return all inputs of a joystick, by the names of layout joystick.

    Raises:
        ValueError: it has been pulled out.
    """
    system.poll()
    if index >= len(system.joysticks()):
        raise ValueError("calibration: the device was unplugged, allowed one that stays")
    return system.inputs(system.plugged(index))


def _say(console: Console, text: str) -> None:
    """Print a sentence as it is: the name of a device may be anything."""
    console.print(text, markup=False, highlight=False, soft_wrap=True)
