"""A joystick made by SDL itself, for tests on machines without one: ctypes on pygame's own SDL."""

from __future__ import annotations

import ctypes
from functools import cache
from pathlib import Path

import pygame

_RUMBLE = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_uint16, ctypes.c_uint16)
# SDL_JOYSTICK_TYPE_GAMECONTROLLER: SDL then knows which input is which; and _FLIGHT_STICK.
_GAMEPAD, _FLIGHT_STICK = 1, 4
_HATS = {0: 0, 1: 1, -1: 4}  # vertical direction to SDL_HAT_CENTERED, _UP, _DOWN


class _Description(ctypes.Structure):
    """SDL_VirtualJoystickDesc, version 1."""

    _fields_ = (
        ("version", ctypes.c_uint16),
        ("type", ctypes.c_uint16),
        ("naxes", ctypes.c_uint16),
        ("nbuttons", ctypes.c_uint16),
        ("nhats", ctypes.c_uint16),
        ("vendor_id", ctypes.c_uint16),
        ("product_id", ctypes.c_uint16),
        ("padding", ctypes.c_uint16),
        ("button_mask", ctypes.c_uint32),
        ("axis_mask", ctypes.c_uint32),
        ("name", ctypes.c_char_p),
        ("userdata", ctypes.c_void_p),
        ("update", ctypes.c_void_p),
        ("set_player_index", ctypes.c_void_p),
        ("rumble", _RUMBLE),
        ("rumble_triggers", ctypes.c_void_p),
        ("set_led", ctypes.c_void_p),
        ("send_effect", ctypes.c_void_p),
    )


@cache
def load_sdl() -> ctypes.CDLL | None:
    """Load the very SDL that pygame has loaded; None where its wheel keeps it elsewhere."""
    site = Path(pygame.__file__).resolve().parent.parent
    files = sorted(site.glob("pygame*.libs/libSDL2-2*"))
    if not files:
        return None
    sdl = ctypes.CDLL(str(files[0]))
    if not hasattr(sdl, "SDL_JoystickAttachVirtualEx"):
        return None
    sdl.SDL_JoystickOpen.restype = ctypes.c_void_p
    sdl.SDL_JoystickInstanceID.argtypes = [ctypes.c_void_p]
    sdl.SDL_JoystickClose.argtypes = [ctypes.c_void_p]
    sdl.SDL_JoystickClose.restype = None
    sdl.SDL_JoystickSetVirtualAxis.argtypes = [ctypes.c_void_p, ctypes.c_int, ctypes.c_int16]
    sdl.SDL_JoystickSetVirtualHat.argtypes = [ctypes.c_void_p, ctypes.c_int, ctypes.c_uint8]
    sdl.SDL_JoystickSetVirtualButton.argtypes = [ctypes.c_void_p, ctypes.c_int, ctypes.c_uint8]
    return sdl


class VirtualPad:
    """A plugged in joystick whose axes and hat the test sets; `rumbles` is what reached it."""

    def __init__(
        self,
        name: str = "Virtual Pad",
        axes: int = 4,
        hats: int = 1,
        motors: bool = True,
        buttons: int = 6,
        gamepad: bool = False,
    ) -> None:
        sdl = load_sdl()
        assert sdl is not None
        pygame.display.init()
        pygame.joystick.init()
        self._sdl = sdl
        self.rumbles: list[tuple[int, int]] = []
        self._callback = _RUMBLE(self._on_rumble) if motors else _RUMBLE()
        self._description = _Description(
            version=1,
            type=_GAMEPAD if gamepad else _FLIGHT_STICK,
            naxes=axes,
            nbuttons=buttons,
            nhats=hats,
            name=name.encode(),
            rumble=self._callback,
        )
        self.plug()

    def _on_rumble(self, _data: int, low: int, high: int) -> int:
        self.rumbles.append((low, high))
        return 0

    def plug(self) -> None:
        """Plug it in; SDL takes it for a new one of the same model."""
        index = self._sdl.SDL_JoystickAttachVirtualEx(ctypes.byref(self._description))
        assert index >= 0
        self._handle = self._sdl.SDL_JoystickOpen(index)
        self._instance = self._sdl.SDL_JoystickInstanceID(self._handle)

    def unplug(self) -> None:
        """Pull it out; a second call does nothing."""
        if self._handle is None:
            return
        for index in range(self._sdl.SDL_NumJoysticks()):
            if self._sdl.SDL_JoystickGetDeviceInstanceID(index) == self._instance:
                assert self._sdl.SDL_JoystickDetachVirtual(index) == 0
                break
        self._sdl.SDL_JoystickClose(self._handle)
        self._handle = None

    def axis(self, index: int, value: float) -> None:
        """Move an axis, -1..1; seen by SDL at its next poll."""
        raw = max(-32768, min(32767, round(value * 32767)))
        assert self._sdl.SDL_JoystickSetVirtualAxis(self._handle, index, raw) == 0

    def hat(self, index: int, vertical: int) -> None:
        """Press a hat up (1), down (-1) or let it go (0)."""
        assert self._sdl.SDL_JoystickSetVirtualHat(self._handle, index, _HATS[vertical]) == 0

    def button(self, index: int, down: bool) -> None:
        """Press a button or let it go."""
        assert self._sdl.SDL_JoystickSetVirtualButton(self._handle, index, int(down)) == 0
