"""The keyboard of a window of its own, as a device."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, Final

from scara_drake.common import checks
from scara_drake.operator.devices.profiles import DEFAULT_PROFILES, Profile, load_profile
from scara_drake.operator.devices.sample import NoDeviceError, Sample, at_rest
from scara_drake.operator.devices.sdl import has_screen, sdl

RAMP = 0.25  # [s], from rest to the end of an axis: a key is no step
LONGEST_STEP = 0.1  # [s] of the ramp, after however long a pause
SIZE: Final = (520, 90)  # [px] of the window


class KeyboardDevice:
    """The keys of a small window, which has to have the focus.

    It keeps which keys are down by itself, from their events. An axis runs to where its keys want
    it in `RAMP`. A window that loses the focus hears of no key any more, so all of them are let go;
    one that is closed is a device that is lost.

    Args:
        profile: of layout keyboard: a name, a YAML file, or "" for the shipped one.
        now: the clock [s].

    Raises:
        ValueError: a profile of another layout, or a key that does not exist.
        NoDeviceError: pygame cannot be loaded, or opens no window.
    """

    def __init__(self, profile: str = "", now: Callable[[], float] = time.monotonic) -> None:
        self._profile = load_profile(profile or DEFAULT_PROFILES["keyboard"])
        if self._profile.layout != "keyboard":
            raise ValueError(
                f"operator.profile: '{profile}' of layout {self._profile.layout}, allowed keyboard"
            )
        self._pygame = sdl().pygame
        self._keys = _keys(self._pygame, self._profile)
        self._now, self._time = now, now()
        self._held: set[str] = set()
        self._axes = dict.fromkeys(self._profile.axis_inputs(), 0.0)
        self._open = True
        try:
            self._pygame.display.init()
            self._pygame.display.set_mode(SIZE)
            self._pygame.display.set_caption(
                "scara_drake: the keyboard commands while this has focus"
            )
        except self._pygame.error as error:
            raise NoDeviceError(f"no window for its keys opens ({error})") from None
        self._last = at_rest(self._time)

    @property
    def name(self) -> str:
        """What it is, and its profile."""
        return f"Keyboard ({self._profile.name})"

    def sample(self) -> Sample:
        """Return what the keys say now; what they said last, once the window is closed."""
        if self._open:
            self._listen()
        if not self._open:
            return self._last._replace(connected=False)
        now = self._now()
        step = min(max(now - self._time, 0.0), LONGEST_STEP) / RAMP
        self._time = now
        for key, value in self._axes.items():
            wanted = float(key in self._held)
            self._axes[key] = value + min(max(wanted - value, -step), step)
        self._last = self._profile.sample(now, dict.fromkeys(self._held, 1.0) | self._axes)
        return self._last

    def _listen(self) -> None:
        pygame = self._pygame
        for event in pygame.event.get(exclude=sdl().events):
            if event.type == pygame.KEYDOWN and event.key in self._keys:
                self._held.add(self._keys[event.key])
            elif event.type == pygame.KEYUP and event.key in self._keys:
                self._held.discard(self._keys[event.key])
            elif event.type == pygame.WINDOWFOCUSLOST:
                self._held.clear()
            elif event.type in (pygame.QUIT, pygame.WINDOWCLOSE):
                self._open = False

    def rumble(self, low: float, high: float, milliseconds: int) -> bool:
        """Return False: keys do not shake."""
        return False

    def close(self) -> None:
        """Close the window; a second call does nothing."""
        if self._open:
            self._open = False
            self._pygame.display.quit()


def _keys(pygame: Any, profile: Profile) -> dict[int, str]:
    """Return the names of the profile's keys by pygame's codes."""
    codes = {}
    for name in sorted(profile.inputs()):
        constant = f"K_{name}" if len(name) == 1 else f"K_{name.upper()}"
        if not hasattr(pygame, constant):
            raise ValueError(
                f"{profile.name}: {checks.shown(name)}, allowed a key of pygame, such as a, space, "
                "left, kp8"
            )
        codes[getattr(pygame, constant)] = name
    return codes


def open_keyboard(profile: str = "") -> KeyboardDevice:
    """Open the keyboard of this machine.

    Raises:
        NoDeviceError: there is no display, so no key could arrive.
        ValueError: see `KeyboardDevice`.
    """
    if not has_screen():
        raise NoDeviceError(
            "there is no display for its window (the page of `scara-drake station` has keys too)"
        )
    return KeyboardDevice(profile)
