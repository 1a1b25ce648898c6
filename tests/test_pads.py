"""Pads of three profiles, through SDL's own virtual device, the block and the haptics."""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np
import pygame
import pytest
from pydrake.systems.analysis import Simulator
from virtual_pad import VirtualPad, load_sdl

from scara_drake.operator.devices import AxisMap, PygameDevice, ScriptedDevice, at_rest
from scara_drake.operator.joystick import JoystickSource
from scara_drake.vectors import BUTTON_NAMES, ORIENTATION_NAMES, STICK_NAMES

pytestmark = [
    pytest.mark.device,
    pytest.mark.skipif(
        load_sdl() is None, reason="pygame's SDL library with virtual joysticks was not found"
    ),
]
# Of SDL's virtual gamepad: axes 0 to 3 the sticks, 4 and 5 the triggers, buttons in SDL's order.
LEFT_TRIGGER, RIGHT_TRIGGER = 4, 5
A, B, X, BACK, START, LEFT_SHOULDER, RIGHT_SHOULDER, UP = 0, 1, 2, 4, 6, 9, 10, 11
SHOWN = 0.7  # of the travel


def gamepad(name: str) -> VirtualPad:
    pad = VirtualPad(name, axes=6, hats=0, buttons=15, gamepad=True)
    pad.axis(LEFT_TRIGGER, -1.0)
    pad.axis(RIGHT_TRIGGER, -1.0)
    return pad


@pytest.fixture
def pads() -> Iterator[list[VirtualPad]]:
    made: list[VirtualPad] = []
    yield made
    for pad in made:
        pad.unplug()
    pygame.event.get()


def shaped(value: float, dead_zone: float, expo: float = 0.3) -> float:
    share = (abs(value) - dead_zone) / (1 - dead_zone)
    return float(np.sign(value) * ((1 - expo) * share + expo * share**3))


class Run:
    """The block of a pad, tick by tick."""

    def __init__(self, device: PygameDevice) -> None:
        self.source = JoystickSource(device, 0.01)
        self.simulator = Simulator(self.source)
        self.ticks = 0

    def tick(self) -> dict[str, float]:
        self.ticks += 1
        self.simulator.AdvanceTo((self.ticks - 0.5) * 0.01)
        context = self.simulator.get_context()
        values: dict[str, float] = {}
        for port, names in (
            ("joystick_axes", STICK_NAMES),
            ("orientation_axes", ORIENTATION_NAMES),
            ("operator_buttons", [f"{name} button" for name in BUTTON_NAMES]),
        ):
            entries = self.source.GetOutputPort(port).Eval(context)
            values |= dict(zip(names, entries.tolist(), strict=True))
        return values


Move = tuple[str, int, float, str, float]  # what is moved, and the one thing that it moves


def pad_moves(stick: float, right: float, trigger: float) -> list[Move]:
    return [
        ("axis", 0, SHOWN, "x", shaped(SHOWN, stick)),
        ("axis", 1, -SHOWN, "y", shaped(-SHOWN, stick)),
        ("axis", 2, -SHOWN, "yaw", shaped(-SHOWN, right)),
        ("axis", 3, -SHOWN, "z", shaped(SHOWN, right)),
        ("axis", RIGHT_TRIGGER, 1.0, "roll", 1.0),
        ("axis", LEFT_TRIGGER, 0.0, "roll", -shaped(0.5, trigger, 0.0)),
        ("button", UP, 1, "mast_hat", 1.0),
        ("button", LEFT_SHOULDER, 1, "engage button", 1.0),
        ("button", RIGHT_SHOULDER, 1, "clutch button", 1.0),
        ("button", B, 1, "hold button", 1.0),
        ("button", START, 1, "reset button", 1.0),
        ("button", BACK, 1, "estop button", 1.0),
        ("button", X, 1, "mast button", 1.0),
        ("button", A, 1, "", 0.0),
    ]


STICK_MOVES: list[Move] = [
    ("axis", 0, SHOWN, "x", SHOWN),
    ("axis", 1, SHOWN, "y", SHOWN),
    ("axis", 2, -SHOWN, "z", -SHOWN),
    ("axis", 3, SHOWN, "", 0.0),
    ("hat", 0, -1, "mast_hat", -1.0),
    *[("button", k, 1, f"{name} button", 1.0) for k, name in enumerate(BUTTON_NAMES)],
]
MODELS = {
    "flight_stick": ("Some Stick", STICK_MOVES),
    "game_controller": ("Some Pad", pad_moves(0.1, 0.1, 0.05)),
    "xbox": ("Xbox Series X Controller", pad_moves(0.24, 0.265, 0.12)),
    "playstation": ("DualSense Wireless Controller", pad_moves(0.06, 0.06, 0.03)),
}


@pytest.mark.parametrize("profile", MODELS)
def test_axes_and_buttons_of_each_profile_arrive(profile: str, pads: list[VirtualPad]) -> None:
    name, moves = MODELS[profile]
    pads.append(VirtualPad(name) if profile == "flight_stick" else gamepad(name))
    device = PygameDevice()
    assert device.name == f"{name} ({profile})"
    run = Run(device)
    assert not any(run.tick().values())
    for kind, index, value, moved, expected in moves:
        rest = -1.0 if (kind, index) in (("axis", 4), ("axis", 5)) else 0
        getattr(pads[0], kind)(index, value)
        found = {port: entry for port, entry in run.tick().items() if entry != 0.0}
        assert found == pytest.approx({moved: expected} if moved else {}, abs=1e-3)
        getattr(pads[0], kind)(index, rest)
        assert not any(run.tick().values())


def test_rumble_of_a_gamepad_has_the_right_strengths_and_stops_by_itself(
    pads: list[VirtualPad],
) -> None:
    pads.append(gamepad("Some Pad"))
    device = PygameDevice()
    assert device.rumble(0.25, 0.75, 20)
    assert pads[0].rumbles == [(16383, 49151)]
    time.sleep(0.05)
    device.sample()
    assert pads[0].rumbles[-1] == (0, 0)


def test_triggers_that_are_half_pressed_at_the_start_turn_nothing(pads: list[VirtualPad]) -> None:
    pads.append(VirtualPad("Some Pad", axes=6, hats=0, buttons=15, gamepad=True))
    for trigger in (LEFT_TRIGGER, RIGHT_TRIGGER):
        pads[0].axis(trigger, 0.2)
    run = Run(PygameDevice())
    assert not any(run.tick().values())  # the two would cancel
    pads[0].axis(RIGHT_TRIGGER, -1.0)
    assert not any(run.tick().values())  # and the left one still does
    pads[0].axis(RIGHT_TRIGGER, 1.0)
    assert run.tick()["roll"] == pytest.approx(1.0)
    pads[0].axis(LEFT_TRIGGER, -1.0)
    run.tick()
    pads[0].axis(LEFT_TRIGGER, 1.0)
    assert run.tick()["roll"] == pytest.approx(0.0)


def test_a_trigger_at_rest_moves_nothing_where_a_stick_is_expected(
    pads: list[VirtualPad],
) -> None:
    pads.append(VirtualPad("Unknown Pad", axes=6))
    pads[0].axis(2, -1.0)
    run = Run(PygameDevice())
    for _ in range(5):
        assert not any(run.tick().values())


def test_unplugged_at_full_deflection_rates_stop_and_no_button_is_down(
    pads: list[VirtualPad],
) -> None:
    pads.append(gamepad("Some Pad"))
    run = Run(PygameDevice())
    run.tick()
    for axis in range(4):
        pads[0].axis(axis, 1.0)
    for button in (UP, LEFT_SHOULDER):
        pads[0].button(button, True)
    held = run.tick()
    assert held["mast_hat"] == held["engage button"] == held["yaw"] == 1.0
    pads[0].unplug()
    lost = run.tick()
    assert {name: lost[name] for name in ("x", "y", "z")} == {"x": 1.0, "y": 1.0, "z": -1.0}
    assert {name: value for name, value in lost.items() if value} == {"x": 1.0, "y": 1.0, "z": -1.0}
    pads[0].plug()
    for axis in (LEFT_TRIGGER, RIGHT_TRIGGER):
        pads[0].axis(axis, -1.0)
    assert run.tick() == lost  # plugging it in again moves nothing


def test_a_profile_asked_for_and_axes_of_the_scenario(pads: list[VirtualPad]) -> None:
    pads.append(gamepad("Some Pad"))
    device = PygameDevice(0, AxisMap(x=3), "playstation")
    assert device.name == "Some Pad (playstation)"
    pads[0].axis(3, SHOWN)
    sample = device.sample()
    assert sample.axes[0] == pytest.approx(SHOWN, abs=1e-4)
    pads.append(VirtualPad("Some Stick"))
    with pytest.raises(ValueError, match="layout game_controller, allowed joystick for Some Stick"):
        PygameDevice(1, None, "playstation")


def test_a_script_is_followed_on_its_clock() -> None:
    clock = iter([5.0, 5.4, 5.5, 7.0])
    moved = at_rest(0.0)._replace(axes=np.full(5, 0.5))
    device = ScriptedDevice([(0.0, at_rest(0.0)), (0.5, moved)], now=lambda: next(clock))
    samples = [device.sample() for _ in range(4)]
    assert [sample.axes[0] for sample in samples] == [0.0, 0.0, 0.5, 0.5]
    assert [sample.stamp for sample in samples] == [5.0, 5.4, 5.5, 7.0]
    assert device.rumble(0.1, 0.2, 30)
    device.close()
    assert not device.rumble(0.1, 0.2, 30)
    assert device.rumbles == [(0.1, 0.2, 30)]
    with pytest.raises(ValueError, match="script: times"):
        ScriptedDevice([])
