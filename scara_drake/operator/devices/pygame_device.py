"""A joystick or gamepad that pygame (SDL) reads."""

from __future__ import annotations

import time
from collections.abc import Callable

from scara_drake.common.fields import check
from scara_drake.operator.devices.profiles import (
    AxisMap,
    Profile,
    choose_profile,
    load_profile,
)
from scara_drake.operator.devices.sample import Sample, at_rest
from scara_drake.operator.devices.sdl import Plugged, sdl


class PygameDevice:
    """A joystick read by SDL through pygame.

    Unplugged, it holds the last axes: SDL centres a lost stick, and a centred stick is a command.
    At least one `sample` says that it is not connected. Plugged in again it goes on by itself: SDL
    then gives it a new instance id, so it is known by its model, and one of the same model that was
    already there before the loss is another one.

    Args:
        index: of those that are plugged in.
        axes: what the scenario says of them, in place of the profile.
        profile: what its inputs do: a name, a YAML file, or "" for what its model is known for.

    Raises:
        ValueError: no joystick of this index, and lists those there are; a profile that is not
            there or not for such a device; no pygame.
    """

    def __init__(self, index: int = 0, axes: AxisMap | None = None, profile: str = "") -> None:
        check(axes or AxisMap(), "axes")
        self._sdl = sdl()
        self._sdl.poll()
        joysticks = self._sdl.joysticks()
        if not 0 <= index < len(joysticks):
            there = ", ".join(f"{i} ({j.get_name()})" for i, j in enumerate(joysticks))
            if not there:
                raise ValueError("operator.device: joystick, allowed trace: no joystick is there")
            raise ValueError(f"operator.index: {index}, allowed {there}")
        self._lost = self._closed = False
        self._profile = fitting_profile(self._sdl.plugged(index), profile)
        self._profile = self._profile.changed(axes or AxisMap())
        self._open(index)
        self._untouched: set[str] | None = None  # until the first sample
        self._last = at_rest(time.monotonic())

    def _open(self, index: int) -> None:
        self._plugged = self._sdl.plugged(index)
        joystick = self._plugged.joystick
        self._instance: int = joystick.get_instance_id()
        self._guid: str = joystick.get_guid()
        self._name: str = joystick.get_name()
        readers = {name: self._sdl.reader(self._plugged, name) for name in self._profile.inputs()}
        self._readers: dict[str, Callable[[], float]] = {
            name: read for name, read in readers.items() if read is not None
        }
        self._sdl.taken.add(self._instance)
        self._note_others()

    def _note_others(self) -> None:
        """Keep which joysticks are there beside ours: a later one can be ours, come back."""
        self._arrivals = self._sdl.arrivals
        self._others = {other.get_instance_id() for other in self._sdl.joysticks()}

    @property
    def name(self) -> str:
        """What the device calls itself, and its profile."""
        return f"{self._name} ({self._profile.name})"

    @property
    def _connected(self) -> bool:
        """Whether it was plugged in at the last `sample`, and is not closed."""
        present = not self._lost and self._instance not in self._sdl.gone
        return not self._closed and present

    def inputs(self) -> dict[str, float]:
        """Return what the inputs of the profile that it has read now.

        Of an axis that several move, one that was away from rest at the start is left out until it
        has been there; for axes of one input the block sees to that.
        """
        values = self._read()
        away = self._profile.away(values)
        self._untouched = away if self._untouched is None else self._untouched & away
        return {name: value for name, value in values.items() if name not in self._untouched}

    def _read(self) -> dict[str, float]:
        return {name: read() for name, read in self._readers.items()}

    def sample(self) -> Sample:
        """Return what it says now; what it said last while it is unplugged or closed."""
        if self._closed:
            return self._last._replace(connected=False)
        self._sdl.poll()
        if self._lost:
            self._look_for_return()
        else:
            self._lost = self._instance in self._sdl.gone
        if not self._lost:
            self._last = self._profile.sample(time.monotonic(), self.inputs())
            if self._arrivals != self._sdl.arrivals:
                self._note_others()
        return self._last._replace(connected=not self._lost)

    def _look_for_return(self) -> None:
        if self._arrivals == self._sdl.arrivals:
            return
        self._arrivals = self._sdl.arrivals
        for index, joystick in enumerate(self._sdl.joysticks()):
            free = joystick.get_instance_id() not in self._sdl.taken | self._others
            if free and joystick.get_guid() == self._guid:
                self._open(index)
                self._lost = False
                return

    def rumble(self, low: float, high: float, milliseconds: int) -> bool:
        """Shake the motors (0..1); False if it is unplugged, closed or has none.

        SDL ends the pulse when it is next polled after that time, so keep sampling, or close.
        """
        if not self._connected:
            return False
        low, high = (min(max(float(level), 0.0), 1.0) for level in (low, high))
        return bool(self._plugged.joystick.rumble(low, high, int(milliseconds)))

    def close(self) -> None:
        """Stop the motors and let go of the joystick; a second call does nothing."""
        if self._connected:
            self._plugged.joystick.stop_rumble()
        self._closed = True


def fitting_profile(plugged: Plugged, name: str = "") -> Profile:
    """Return the profile of a joystick: the one asked for, or the one that its model has.

    Raises:
        ValueError: there is none of that name, or its layout is not one of the joystick's.
    """
    joystick = plugged.joystick
    if not name:
        return choose_profile(joystick.get_name(), joystick.get_guid(), plugged.layouts)
    profile = load_profile(name)
    if profile.layout not in plugged.layouts:
        raise ValueError(
            f"operator.profile: '{name}' of layout {profile.layout}, allowed "
            f"{' or '.join(plugged.layouts)} for {joystick.get_name()}"
        )
    return profile


def find_joystick(axes: AxisMap | None = None, profile: str = "") -> PygameDevice | None:
    """Open the first joystick that is plugged in, or return None.

    Raises:
        ValueError: no pygame, or a profile that is not there.
    """
    found = sdl()
    found.poll()
    return PygameDevice(0, axes, profile) if found.pygame.joystick.get_count() else None
