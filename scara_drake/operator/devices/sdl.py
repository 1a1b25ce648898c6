"""SDL through pygame: what is plugged in, who came and went, and what an input of one reads."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any, Final, NamedTuple

from scara_drake.operator.devices.inputs import CONTROLLER_AXES
from scara_drake.operator.devices.sample import NoDeviceError

FULL = 32767  # of an axis of SDL's game controllers

# From the names of a profile to those of pygame's constants.
_CONSTANTS: Final[Mapping[str, str]] = {
    "lefttrigger": "TRIGGERLEFT",
    "righttrigger": "TRIGGERRIGHT",
    "dpup": "DPAD_UP",
    "dpdown": "DPAD_DOWN",
    "dpleft": "DPAD_LEFT",
    "dpright": "DPAD_RIGHT",
}

_HAPPENS: Final = (
    *("DEVICEADDED", "DEVICEREMOVED", "DEVICEREMAPPED"),
    *("AXISMOTION", "BALLMOTION", "HATMOTION", "BUTTONDOWN", "BUTTONUP"),
)


class Plugged(NamedTuple):
    """A joystick that is plugged in.

    Attributes:
        joystick: pygame's, open.
        controller: pygame's, open, where SDL knows what its inputs are; else None.
    """

    joystick: Any
    controller: Any

    @property
    def layouts(self) -> tuple[str, ...]:
        """The layouts of a profile that fit, the best first."""
        return ("game_controller", "joystick") if self.controller is not None else ("joystick",)


class Sdl:
    """SDL's joysticks, and which have come and gone; it never gives an instance id twice.

    Raises:
        NoDeviceError: pygame cannot be loaded.
    """

    def __init__(self) -> None:
        os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
        os.environ.setdefault("SDL_JOYSTICK_ALLOW_BACKGROUND_EVENTS", "1")
        if not has_screen():
            os.environ.setdefault("SDL_VIDEODRIVER", "dummy")
        try:
            import pygame
            from pygame._sdl2 import controller
        except ImportError as error:
            raise NoDeviceError(f"pygame cannot be loaded ({error})") from None
        self.pygame, self._controllers = pygame, controller
        self.gone: set[int] = set()
        self.taken: set[int] = set()  # by a PygameDevice, now or before
        self.arrivals = 0
        # Of joysticks, and of the game controllers that SDL makes of them.
        kinds = ("JOY", "CONTROLLER")
        names = (f"{kind}{what}" for kind in kinds for what in _HAPPENS)
        self.events = tuple(getattr(pygame, name) for name in names if hasattr(pygame, name))

    def poll(self) -> None:
        """Let SDL read the hardware, and note who came and went.

        Only events of joysticks are taken off the queue: those of the keyboard stay for others.
        """
        pygame = self.pygame
        pygame.display.init()  # SDL's event pump needs it; these return at once if already done
        pygame.joystick.init()
        self._controllers.init()
        for event in pygame.event.get(self.events):
            if event.type == pygame.JOYDEVICEREMOVED:
                self.gone.add(event.instance_id)
            elif event.type == pygame.JOYDEVICEADDED:
                self.arrivals += 1

    def joysticks(self) -> list[Any]:
        """Open and return the joysticks that are plugged in, in SDL's order."""
        joystick = self.pygame.joystick
        return [joystick.Joystick(index) for index in range(joystick.get_count())]

    def plugged(self, index: int) -> Plugged:
        """Open and return a joystick that is plugged in."""
        known = self._controllers.is_controller(index)
        return Plugged(
            self.pygame.joystick.Joystick(index),
            self._controllers.Controller(index) if known else None,
        )

    def reader(self, one: Plugged, name: str) -> Callable[[], float] | None:
        """Return what reads an input of a profile, -1 to 1; None where the joystick has it not."""
        kind, index, way = split(name)
        if kind in ("axis", "button", "hat"):
            count = getattr(one.joystick, f"get_num{kind.replace('axis', 'axe')}s")()
            if index >= count:
                return None
            read = getattr(one.joystick, f"get_{kind}")
            if kind == "hat":
                return lambda: float(read(index)["xy".index(way)])
            return lambda: float(read(index))
        if one.controller is None:
            return None
        return self._controller_reader(one.controller, name)

    def inputs(self, one: Plugged) -> dict[str, float]:
        """Return what all inputs of a joystick read, by the names of layout joystick."""
        joystick = one.joystick
        axes = {f"axis{k}": joystick.get_axis(k) for k in range(joystick.get_numaxes())}
        buttons = {f"button{k}": joystick.get_button(k) for k in range(joystick.get_numbuttons())}
        hats = {
            f"hat{k}_{way}": value
            for k in range(joystick.get_numhats())
            for way, value in zip("xy", joystick.get_hat(k), strict=True)
        }
        return {name: float(value) for name, value in (axes | buttons | hats).items()}

    def _controller_reader(self, controller: Any, name: str) -> Callable[[], float] | None:
        if name not in controller.get_mapping():
            return None
        kind = "AXIS" if name in CONTROLLER_AXES else "BUTTON"
        constant = f"CONTROLLER_{kind}_{_CONSTANTS.get(name, name.upper())}"
        number = getattr(self.pygame, constant)
        if kind == "AXIS":
            return lambda: max(controller.get_axis(number) / FULL, -1.0)
        return lambda: float(controller.get_button(number))


def split(name: str) -> tuple[str, int, str]:
    """Return an input such as axis3 or hat0_y as its kind, index and direction."""
    found = re.fullmatch(r"(axis|button|hat)(\d+)(?:_([xy]))?", name)
    return (found[1], int(found[2]), found[3] or "") if found else (name, 0, "")


def has_screen() -> bool:
    """Return whether a window could be seen."""
    if not sys.platform.startswith("linux"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


@cache
def sdl() -> Sdl:
    """Return SDL, loaded at the first call.

    Raises:
        NoDeviceError: pygame cannot be loaded.
    """
    return Sdl()
