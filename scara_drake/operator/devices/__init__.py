"""The devices that an operator can hold: each a file, and a line in `OPENERS`.

A device is not simulation state: it is read and shaken in events only, from one thread.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final, Protocol

from scara_drake.operator.devices.clock import WallClock
from scara_drake.operator.devices.profiles import AxisMap
from scara_drake.operator.devices.pygame_device import PygameDevice, find_joystick
from scara_drake.operator.devices.sample import NoDeviceError, Sample, at_rest
from scara_drake.operator.devices.scripted import ScriptedDevice


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


@dataclass(frozen=True)
class Wanted:
    """What a scenario says of its device.

    Attributes:
        index: where there are several.
        profile: a name, a file, or "" for what the device is known for.
        axes: in place of the profile's.
    """

    index: int = 0
    profile: str = ""
    axes: AxisMap = field(default_factory=AxisMap)


def _open_joystick(wanted: Wanted) -> Device:
    return PygameDevice(wanted.index, wanted.axes, wanted.profile)


def _open_keyboard(wanted: Wanted) -> Device:
    from scara_drake.operator.devices.keyboard import open_keyboard

    return open_keyboard(wanted.profile)


def _open_spacemouse(wanted: Wanted) -> Device:
    from scara_drake.operator.devices.spacemouse import SpaceMouseDevice

    return SpaceMouseDevice(wanted.index, wanted.profile)


def _find_joystick(wanted: Wanted) -> Device | None:
    return find_joystick(wanted.axes, wanted.profile)


def _find_spacemouse(wanted: Wanted) -> Device | None:
    from scara_drake.operator.devices.spacemouse import find_spacemouse

    return find_spacemouse(wanted.profile)


# By `operator.device`: what opens it, or raises a ValueError of one line that says why not;
# a `NoDeviceError` where this machine cannot have one, and the recorded operator plays instead.
OPENERS: Final[dict[str, Callable[[Wanted], Device]]] = {
    "joystick": _open_joystick,
    "keyboard": _open_keyboard,
    "spacemouse": _open_spacemouse,
}
# Of "auto": each opens the first device of its kind that is plugged in, or returns None.
FINDERS: Final[tuple[Callable[[Wanted], Device | None], ...]] = (
    _find_joystick,
    _find_spacemouse,
)


def find_device(wanted: Wanted | None = None) -> Device | None:
    """Open the first device that is plugged in, of the first kind that has one, or return None.

    Raises:
        ValueError: a profile that is not there or does not fit.
        NoDeviceError: no pygame, and nothing else is plugged in.
    """
    missing: NoDeviceError | None = None
    for find in FINDERS:
        try:
            device = find(wanted or Wanted())
        except NoDeviceError as error:
            missing = missing or error
            continue
        if device is not None:
            return device
    if missing is not None:
        raise missing
    return None


__all__ = [
    "FINDERS",
    "OPENERS",
    "AxisMap",
    "Device",
    "NoDeviceError",
    "PygameDevice",
    "Sample",
    "ScriptedDevice",
    "WallClock",
    "Wanted",
    "at_rest",
    "find_device",
]
