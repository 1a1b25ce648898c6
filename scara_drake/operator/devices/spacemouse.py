"""A 3Dconnexion SpaceMouse, read by pyspacemouse."""

from __future__ import annotations

import contextlib
import io
import queue
import threading
import time
from typing import Any, Final

from scara_drake.operator.devices.profiles import DEFAULT_PROFILES, load_profile
from scara_drake.operator.devices.sample import NoDeviceError, Sample, at_rest

AXES: Final = ("x", "y", "z", "roll", "pitch", "yaw")
REPORTS = 16  # taken at one sample at most: it sends two or three each 8 ms
SEARCH = 1.0  # [s] between two looks for one that was lost


class SpaceMouseDevice:
    """A SpaceMouse; it has six axes, all of which rest at 0, and no motors.

    A report is read only if it is there, so nothing waits; it sends none while nobody touches it.
    One that is lost is looked for by a thread of its own, as to list devices takes a while, and is
    the same if its name and serial number are.

    Args:
        index: of those that are plugged in.
        profile: of layout spacemouse: a name, a YAML file, or "" for the shipped one.
        library: pyspacemouse, or what stands in for it.

    Raises:
        NoDeviceError: pyspacemouse, or the library hidapi that it needs, cannot be loaded.
        ValueError: none is there, or a profile of another layout.
    """

    def __init__(self, index: int = 0, profile: str = "", library: Any = None) -> None:
        self._profile = load_profile(profile or DEFAULT_PROFILES["spacemouse"])
        if self._profile.layout != "spacemouse":
            layout = self._profile.layout
            raise ValueError(
                f"operator.profile: '{profile}' of layout {layout}, allowed spacemouse"
            )
        self._library, self._index = library or _load(), index
        with contextlib.redirect_stdout(io.StringIO()):  # it prints what it has found
            self._mouse: Any = _open(self._library, index)
        self._name, self._serial = str(self._mouse.name), str(self._mouse.serial_number)
        self._found: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._closed = threading.Event()
        self._last = at_rest(time.monotonic())

    @property
    def name(self) -> str:
        """What the device calls itself, and its profile."""
        return f"{self._name} ({self._profile.name})"

    def sample(self) -> Sample:
        """Return what it says now; what it said last while it is unplugged or closed."""
        if self._mouse is None and not self._found.empty():
            self._mouse = self._found.get()
        if self._mouse is None:
            return self._last._replace(connected=False)
        try:
            state = self._newest()
        except Exception:  # whatever a driver raises means the same: it is gone
            self._lose()
            return self._last._replace(connected=False)
        inputs = {name: _within(float(getattr(state, name))) for name in AXES}
        inputs |= {f"button{k}": float(down) for k, down in enumerate(state.buttons)}
        self._last = self._profile.sample(time.monotonic(), inputs)
        return self._last

    def _newest(self) -> Any:
        """Take the reports that wait, each of some of the axes, and return the state after them."""
        state = self._mouse.read()
        for _ in range(REPORTS - 1):
            before = state.t
            state = self._mouse.read()
            if state.t == before:
                break
        return state

    def _lose(self) -> None:
        lost, self._mouse = self._mouse, None
        with contextlib.suppress(Exception):  # the driver of what is gone may raise anything
            lost.close()
        threading.Thread(target=self._search, daemon=True).start()

    def _search(self) -> None:
        while not self._closed.wait(SEARCH):
            try:
                mouse = _open(self._library, self._index)
            except ValueError:
                continue
            if (str(mouse.name), str(mouse.serial_number)) == (self._name, self._serial):
                self._found.put(mouse)
                return
            mouse.close()

    def rumble(self, low: float, high: float, milliseconds: int) -> bool:
        """Return False: it has no motors."""
        return False

    def close(self) -> None:
        """Let go of it; a second call does nothing."""
        self._closed.set()
        if self._mouse is not None:
            self._mouse.close()
            self._mouse = None


def _within(value: float) -> float:
    """Return an axis within [-1, 1]: a cap goes beyond its nominal end. What is none stays so."""
    return value if value != value else min(max(value, -1.0), 1.0)


def _load() -> Any:
    try:
        import pyspacemouse
    except ImportError:
        raise NoDeviceError(
            "pyspacemouse is not installed: pip install 'scara-drake[spacemouse]'"
        ) from None
    return pyspacemouse


def names(library: Any = None) -> list[str]:
    """Return the names of those that are plugged in.

    Raises:
        NoDeviceError: see `SpaceMouseDevice`.
    """
    library = library or _load()
    try:
        return list(library.get_connected_devices())
    except (RuntimeError, AttributeError, OSError):
        raise NoDeviceError(
            "the system's library hidapi cannot be loaded (Debian: libhidapi-hidraw0)"
        ) from None


def _open(library: Any, index: int) -> Any:
    there = names(library)
    if not there:
        raise ValueError("operator.device: spacemouse, allowed trace: none is plugged in")
    if not 0 <= index < len(there):
        listed = ", ".join(f"{k} ({name})" for k, name in enumerate(there))
        raise ValueError(f"operator.index: {index}, allowed {listed}")
    convention = library.AxisConvention.HID_Z_UP
    before = there[:index].count(there[index])  # equal ones have an index among themselves
    try:
        return library.open(
            device=there[index],
            device_index=before,
            nonblocking=True,
            axis_convention=convention,
        )
    except (RuntimeError, OSError) as error:
        raise ValueError(
            f"operator.device: spacemouse, but {there[index]} does not open ({error}): "
            "may you read /dev/hidraw*?"
        ) from None


def find_spacemouse(profile: str = "") -> SpaceMouseDevice | None:
    """Open the first that is plugged in; None if there is none, or no library for it."""
    try:
        there = names()
    except NoDeviceError:
        return None
    return SpaceMouseDevice(0, profile) if there else None
