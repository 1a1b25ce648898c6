"""The SpaceMouse, on reports that a real one sends, through pyspacemouse's own decoder if there."""

from __future__ import annotations

import time
from collections import deque
from enum import Enum
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from scara_drake.operator.devices import NoDeviceError
from scara_drake.operator.devices.spacemouse import (
    SpaceMouseDevice,
    find_spacemouse,
    names,
)


class Convention(Enum):
    HID_Z_UP = "hid_z_up"


class FakeMouse:
    """pyspacemouse's device: each `read` takes one report, a change of some entries, if any."""

    name = "SpaceNavigator"

    def __init__(self, serial: str = "1") -> None:
        self.serial_number, self.closed, self.gone = serial, False, False
        self.reports: deque[dict[str, Any]] = deque()
        self.state = SimpleNamespace(
            t=-1.0, x=0.0, y=0.0, z=0.0, roll=0.0, pitch=0.0, yaw=0.0, buttons=[0, 0]
        )
        self.reads = 0

    def read(self) -> SimpleNamespace:
        self.reads += 1
        if self.gone:
            raise OSError("Failed to read from HID device: -1")
        if self.reports:
            vars(self.state).update(self.reports.popleft(), t=float(self.reads))
        return self.state

    def close(self) -> None:
        self.closed = True


class FakeLibrary:
    """pyspacemouse, and what is plugged in."""

    AxisConvention = Convention

    def __init__(self, *mice: FakeMouse) -> None:
        self.mice = list(mice)

    def get_connected_devices(self) -> list[str]:
        return [mouse.name for mouse in self.mice]

    def open(self, device: str, device_index: int, **options: Any) -> FakeMouse:
        assert options == {"nonblocking": True, "axis_convention": Convention.HID_Z_UP}
        return [mouse for mouse in self.mice if mouse.name == device][device_index]


def test_axes_and_buttons_arrive_from_reports_of_their_own() -> None:
    mouse = FakeMouse()
    device = SpaceMouseDevice(library=FakeLibrary(mouse))
    assert device.name == "SpaceNavigator (spacemouse)"
    assert not device.sample().axes.any()
    mouse.reports += [{"x": 1.0, "y": 0.53, "z": -1.2}, {"yaw": 0.55, "roll": 0.05}]
    mouse.reports.append({"buttons": [1, 0]})
    sample = device.sample()  # all of what waits, at once
    np.testing.assert_allclose(sample.axes, [1.0, -0.5, -1.0, 0.0, 0.0])
    np.testing.assert_allclose(sample.orientation, [0.0, 0.0, 0.5])
    np.testing.assert_array_equal(sample.buttons, [1, 0, 0, 0, 0, 0])
    np.testing.assert_array_equal(device.sample().axes, sample.axes)  # silent: nothing changed


def test_a_flood_of_reports_does_not_hold_up_the_loop() -> None:
    mouse = FakeMouse()
    device = SpaceMouseDevice(library=FakeLibrary(mouse))
    mouse.reports += [{"x": 0.5}] * 1000
    device.sample()
    assert mouse.reads <= 16


def test_what_is_no_number_is_passed_on_and_what_is_beyond_the_end_is_the_end() -> None:
    mouse = FakeMouse()
    device = SpaceMouseDevice(library=FakeLibrary(mouse))
    mouse.reports.append({"x": float("nan"), "z": 1.5})
    sample = device.sample()
    assert np.isnan(sample.axes[0])
    assert sample.axes[2] == 1.0


def test_unplugged_it_holds_and_only_the_same_one_comes_back(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("scara_drake.operator.devices.spacemouse.SEARCH", 0.01)
    mouse, twin = FakeMouse(), FakeMouse("2")
    library = FakeLibrary(mouse)
    device = SpaceMouseDevice(library=library)
    mouse.reports.append({"x": 1.0})
    held = device.sample().axes
    mouse.gone, library.mice = True, [twin]
    lost = device.sample()
    assert not lost.connected
    np.testing.assert_array_equal(lost.axes, held)
    assert mouse.closed
    time.sleep(0.1)
    assert not device.sample().connected
    library.mice = [FakeMouse()]
    for _ in range(500):
        if device.sample().connected:
            break
        time.sleep(0.01)
    assert device.sample().connected
    device.close()
    assert not device.sample().connected


def test_what_is_not_there_is_said() -> None:
    with pytest.raises(ValueError, match="spacemouse, allowed trace: none is plugged in"):
        SpaceMouseDevice(library=FakeLibrary())
    with pytest.raises(ValueError, match=r"operator\.index: 1, allowed 0 \(SpaceNavigator\)"):
        SpaceMouseDevice(1, library=FakeLibrary(FakeMouse()))
    with pytest.raises(ValueError, match="'xbox' of layout game_controller, allowed spacemouse"):
        SpaceMouseDevice(0, "xbox", FakeLibrary(FakeMouse()))


def test_without_its_library(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "pyspacemouse", None)
    with pytest.raises(NoDeviceError, match=r"pip install 'scara-drake\[spacemouse\]'"):
        names()
    assert find_spacemouse() is None


def test_pyspacemouse_decodes_a_report_as_the_profile_expects() -> None:
    """Report 1 of a SpaceNavigator: three 16 bit numbers, full scale 350; see its devices.toml."""
    library = pytest.importorskip("pyspacemouse")
    from pyspacemouse.loader import get_device_specs

    class Hid:
        def __init__(self) -> None:
            self.reports = deque([bytes([1, 175, 0, 81, 255, 0, 0])])

        def read(self, size: int) -> bytes:
            return self.reports.popleft() if self.reports else b""

    spec = library.apply_axis_convention(
        get_device_specs()["SpaceNavigator"], library.AxisConvention.HID_Z_UP
    )
    mouse = library.SpaceMouseDevice(info=spec, device=Hid())
    fake = SimpleNamespace(
        AxisConvention=library.AxisConvention,
        get_connected_devices=lambda: ["SpaceNavigator"],
        open=lambda **options: mouse,
    )
    axes = SpaceMouseDevice(library=fake).sample().axes
    half = (0.5 - 0.06) / 0.94
    np.testing.assert_allclose(axes, [half, -half, 0.0, 0.0, 0.0], atol=1e-9)
