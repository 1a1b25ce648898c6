"""What the simulation and the server of the station leave each other in shared memory."""

from __future__ import annotations

from typing import Any, BinaryIO, Final, NamedTuple

import numpy as np

from scara_drake.station.mailbox import Mailbox, make_memory, map_memory, size_of
from scara_drake.vectors import (
    DEVICE_STATUS,
    JOYSTICK_AXES,
    LIVE_SETTINGS,
    NEUTRAL_SETTINGS,
    OPERATOR_BUTTONS,
    ORIENTATION_AXES,
    POSE,
    STATE,
    SUPERVISOR_STATUS,
)

MAX_SURFACES: Final = 16  # that are shown in motion
MAX_TASK: Final = 200  # [bytes] of its line

# The signals of the Diagram that the station shows, those that there are, and their sizes.
SIGNALS: Final[dict[str, int]] = {
    "state": STATE.size,
    "X_WE_desired": POSE.size,
    "f_env_on_tool_W": 3,
    "f_haptic": 3,
    "actuation": 6,
    "delay_up": 1,
    "delay_down": 1,
    "device_status": DEVICE_STATUS.size,
    "live_settings": LIVE_SETTINGS.size,
    "operator_status": SUPERVISOR_STATUS.size,
    "robot_status": SUPERVISOR_STATUS.size,
}

FRAME: Final = np.dtype(
    [
        ("t", "f8"),  # simulated [s]
        ("wall", "f8"),  # of the monotonic clock [s]
        ("lateness", "f8"),  # behind the clock [s]
        ("late_ticks", "i8"),
        ("p99", "f8"),  # of the lateness [s]
        ("surfaces", "f8", (MAX_SURFACES, 3)),  # how far each is from rest [m]
        ("task", f"S{MAX_TASK}"),  # UTF-8
        *((name, "f8", (size,)) for name, size in SIGNALS.items()),
    ]
)
INPUT: Final = np.dtype(
    [
        ("clients", "i8"),  # that watch or command
        ("hand", "i8"),  # counts who has held control; another hand is another device
        ("connected", "?"),
        ("stamp", "f8"),  # when the page last spoke, of the monotonic clock [s]
        ("axes", "f8", (JOYSTICK_AXES.size,)),
        ("orientation", "f8", (ORIENTATION_AXES.size,)),
        ("buttons", "f8", (OPERATOR_BUTTONS.size,)),
        ("settings", "f8", (LIVE_SETTINGS.size,)),
    ]
)
RUMBLE: Final = np.dtype([("low", "f8"), ("high", "f8"), ("until", "f8")])
SIZE: Final = size_of(FRAME) + size_of(INPUT) + size_of(RUMBLE)


class Mailboxes(NamedTuple):
    """The places in the shared memory.

    Attributes:
        frame: what is shown, from the simulation.
        input: what the operator does, from the server.
        rumble: how the device is to shake, from the simulation.
    """

    frame: Mailbox
    input: Mailbox
    rumble: Mailbox


def make_mailboxes() -> tuple[BinaryIO, Mailboxes]:
    """Return new shared memory as a file, for a child to inherit, and the places in it."""
    file = make_memory(SIZE)
    return file, map_mailboxes(file.fileno())


def map_mailboxes(descriptor: int) -> Mailboxes:
    """Return the places in the memory of a file of `make_mailboxes`."""
    memory, offset, places = map_memory(descriptor, SIZE), 0, []
    for dtype in (FRAME, INPUT, RUMBLE):
        places.append(Mailbox(memory, offset, dtype))
        offset += size_of(dtype)
    return Mailboxes(*places)


def empty_frame() -> Any:
    """Return a frame () in which nothing is known."""
    frame = np.zeros((), FRAME)
    for name in ("lateness", "p99", *SIGNALS):
        frame[name] = np.nan
    return frame


def no_input() -> Any:
    """Return the input () of nobody."""
    record = np.zeros((), INPUT)
    record["settings"] = NEUTRAL_SETTINGS
    return record
