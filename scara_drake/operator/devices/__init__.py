"""The devices that an operator can hold: each a file, and a line in `FINDERS`.

A device is not simulation state: it is read and shaken in events only, from one thread.
"""

from collections.abc import Callable
from typing import Final, Protocol

from scara_drake.operator.devices.clock import WallClock
from scara_drake.operator.devices.pygame_device import AxisMap, PygameDevice, find_joystick
from scara_drake.operator.devices.sample import Sample, at_rest


class Device(Protocol):
    """What `JoystickSource` reads and `HapticOutput` shakes."""

    @property
    def name(self) -> str:
        """What the device calls itself."""

    def sample(self) -> Sample:
        """Return what it says now, in arrays of its own; it never waits, and never raises.

        What is no number or out of range is passed on as it is: the block drops and counts it.
        """

    def rumble(self, low: float, high: float, milliseconds: int) -> bool:
        """Shake the low and high frequency motors (0..1) for a while; False if it cannot."""

    def close(self) -> None:
        """Stop the motors and let go of the device; a second call does nothing."""


# Each opens the first device of its kind that is plugged in, or returns None.
FINDERS: Final[tuple[Callable[[AxisMap], Device | None], ...]] = (find_joystick,)


def find_device(axes: AxisMap | None = None) -> Device | None:
    """Open the first device that is plugged in, of the first kind that has one, or return None."""
    found = (find(axes or AxisMap()) for find in FINDERS)
    return next((device for device in found if device is not None), None)


__all__ = [
    "FINDERS",
    "AxisMap",
    "Device",
    "PygameDevice",
    "Sample",
    "WallClock",
    "at_rest",
    "find_device",
]
