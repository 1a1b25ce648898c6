"""The devices that an operator can hold: each a file, and a line in `FINDERS`.

A device is not simulation state: it is read and shaken in events only, from one thread.
"""

from collections.abc import Callable
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from scara_drake.operator.devices.pygame_device import AxisMap, PygameDevice, find_joystick

Array = NDArray[np.float64]


class Device(Protocol):
    """What `JoystickSource` reads and `HapticOutput` shakes."""

    @property
    def name(self) -> str:
        """What the device calls itself."""

    def read(self) -> Array:
        """Return the axes now, a new array (5,) in the order of STICK_NAMES, each in [-1, 1]."""

    @property
    def connected(self) -> bool:
        """Whether it was there at the last `read`; if not, what that returned does not count."""

    @property
    def pressed(self) -> bool:
        """Whether any of its buttons was down at the last `read`."""

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


__all__ = ["FINDERS", "AxisMap", "Device", "PygameDevice", "find_device"]
