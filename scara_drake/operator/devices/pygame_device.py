"""The joystick that pygame (SDL) reads."""

import os
import sys
import time
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scara_drake.common import checks
from scara_drake.common.fields import check
from scara_drake.operator.devices.sample import Sample
from scara_drake.vectors import JOYSTICK_AXES, OPERATOR_BUTTONS

Array = NDArray[np.float64]

MAX_INDEX = 63  # of an axis or a hat: more than any joystick has


@dataclass
class AxisMap:
    """Which axis of the joystick is which; None or an axis that it has not reads 0.

    The defaults fit a flight stick: right, back and twist right are positive, and so is hat up.

    Attributes:
        x: axis of the stick.
        y: axis of the stick.
        z: axis of the stick.
        mast_axis: axis that moves the mast.
        mast_hat: a hat, of which the vertical direction moves the mast.
    """

    x: int | None = 0
    y: int | None = 1
    z: int | None = 2
    mast_axis: int | None = None
    mast_hat: int | None = 0

    def check_together(self, name: str) -> None:
        """Check the indices.

        Raises:
            ValueError: an index is not a whole number between 0 and 63.
        """
        for field, index in vars(self).items():
            if index is not None:
                if not isinstance(index, int):
                    raise ValueError(f"{name}.{field}: {index}, allowed a whole number or none")
                checks.number(f"{name}.{field}", index, 0, MAX_INDEX)


class _Sdl:
    """SDL's joysticks, and which have come and gone; it never gives an instance id twice."""

    def __init__(self) -> None:
        os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
        os.environ.setdefault("SDL_JOYSTICK_ALLOW_BACKGROUND_EVENTS", "1")
        screen = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
        if sys.platform.startswith("linux") and not screen:
            os.environ.setdefault("SDL_VIDEODRIVER", "dummy")
        import pygame

        self.pygame = pygame
        self.gone: set[int] = set()
        self.taken: set[int] = set()  # by a PygameDevice, now or before
        self.arrivals = 0

    def poll(self) -> None:
        """Let SDL read the hardware, and note who came and went.

        Only joystick events are taken off the queue: those of the keyboard stay for others.
        """
        pygame = self.pygame
        pygame.display.init()  # SDL's event pump needs it; both return at once if already done
        pygame.joystick.init()
        for event in pygame.event.get(
            (
                pygame.JOYDEVICEADDED,
                pygame.JOYDEVICEREMOVED,
                pygame.JOYAXISMOTION,
                pygame.JOYBALLMOTION,
                pygame.JOYHATMOTION,
                pygame.JOYBUTTONDOWN,
                pygame.JOYBUTTONUP,
            )
        ):
            if event.type == pygame.JOYDEVICEREMOVED:
                self.gone.add(event.instance_id)
            elif event.type == pygame.JOYDEVICEADDED:
                self.arrivals += 1

    def joysticks(self) -> list[Any]:
        """Open and return the joysticks that are plugged in, in SDL's order."""
        joystick = self.pygame.joystick
        return [joystick.Joystick(index) for index in range(joystick.get_count())]


@cache
def _sdl() -> _Sdl:
    return _Sdl()


class PygameDevice:
    """A joystick read by SDL through pygame.

    Unplugged, it holds the last axes: SDL centres a lost stick, and a centred stick is a command.
    At least one `sample` says that it is not connected. Plugged in again it goes on by itself: SDL
    then gives it a new instance id, so it is known by its model, and one of the same model that was
    already there before the loss is another one.

    Raises:
        ValueError: no joystick of this index; lists those there are.
    """

    def __init__(self, index: int = 0, axes: AxisMap | None = None) -> None:
        self._axes = axes or AxisMap()
        check(self._axes, "axes")
        self._sdl = _sdl()
        self._sdl.poll()
        joysticks = self._sdl.joysticks()
        if not 0 <= index < len(joysticks):
            there = ", ".join(f"{i} ({j.get_name()})" for i, j in enumerate(joysticks))
            if not there:
                raise ValueError("operator.device: joystick, allowed trace: no joystick is there")
            raise ValueError(f"operator.index: {index}, allowed {there}")
        self._lost = False
        self._open(joysticks[index])
        self._last = Sample(True, time.monotonic(), np.zeros(JOYSTICK_AXES.size))

    def _open(self, joystick: Any) -> None:
        self._joystick: Any = joystick
        self._instance: int = joystick.get_instance_id()
        self._guid: str = joystick.get_guid()
        self._name: str = joystick.get_name()
        self._sdl.taken.add(self._instance)
        self._note_others()

    def _note_others(self) -> None:
        """Keep which joysticks are there beside ours: a later one can be ours, come back."""
        self._arrivals = self._sdl.arrivals
        self._others = {other.get_instance_id() for other in self._sdl.joysticks()}

    @property
    def name(self) -> str:
        """What the device calls itself."""
        return self._name

    @property
    def _connected(self) -> bool:
        """Whether it was plugged in at the last `sample`, and is not closed."""
        present = not self._lost and self._instance not in self._sdl.gone
        return self._joystick is not None and present

    def sample(self) -> Sample:
        """Return what it says now; what it said last while it is unplugged or closed."""
        if self._joystick is None:
            return self._last._replace(connected=False)
        self._sdl.poll()
        if self._lost:
            self._look_for_return()
        else:
            self._lost = self._instance in self._sdl.gone
        if not self._lost:
            self._last = Sample(
                True, time.monotonic(), self._axes_now(), buttons=self._buttons_now()
            )
            if self._arrivals != self._sdl.arrivals:
                self._note_others()
        return self._last._replace(connected=not self._lost)

    def _look_for_return(self) -> None:
        if self._arrivals == self._sdl.arrivals:
            return
        self._arrivals = self._sdl.arrivals
        for joystick in self._sdl.joysticks():
            free = joystick.get_instance_id() not in self._sdl.taken | self._others
            if free and joystick.get_guid() == self._guid:
                self._open(joystick)
                self._lost = False
                return

    def _axes_now(self) -> Array:
        joystick, axes = self._joystick, self._axes
        count = joystick.get_numaxes()
        values = [
            joystick.get_axis(index) if index is not None and index < count else 0.0
            for index in (axes.x, axes.y, axes.z, axes.mast_axis)
        ]
        hat = axes.mast_hat
        has_hat = hat is not None and hat < joystick.get_numhats()
        values.append(joystick.get_hat(hat)[1] if has_hat else 0.0)
        return np.clip(np.array(values, dtype=np.float64), -1.0, 1.0)

    def _buttons_now(self) -> Array:
        count = self._joystick.get_numbuttons()
        return np.array(
            [
                float(index < count and self._joystick.get_button(index))
                for index in range(OPERATOR_BUTTONS.size)
            ]
        )

    def rumble(self, low: float, high: float, milliseconds: int) -> bool:
        """Shake the motors (0..1); False if it is unplugged, closed or has none.

        SDL ends the pulse when it is next polled after that time, so keep reading, or close.
        """
        if not self._connected:
            return False
        low, high = (min(max(float(level), 0.0), 1.0) for level in (low, high))
        return bool(self._joystick.rumble(low, high, int(milliseconds)))

    def close(self) -> None:
        """Stop the motors and let go of the joystick; a second call does nothing."""
        if self._connected:
            self._joystick.stop_rumble()
        self._joystick = None


def find_joystick(axes: AxisMap | None = None) -> PygameDevice | None:
    """Open the first joystick that is plugged in, or return None."""
    sdl = _sdl()
    sdl.poll()
    return PygameDevice(0, axes) if sdl.pygame.joystick.get_count() else None
