"""The command `scara-drake devices`, with SDL's virtual pad."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pygame
import pytest
from virtual_pad import VirtualPad, load_sdl

from scara_drake.cli import devices as command
from scara_drake.cli.main import main
from scara_drake.operator.devices import PygameDevice
from scara_drake.operator.devices.profiles import load_profile
from scara_drake.vectors import BUTTON_NAMES

pytestmark = [
    pytest.mark.device,
    pytest.mark.skipif(
        load_sdl() is None, reason="pygame's SDL library with virtual joysticks was not found"
    ),
]


@pytest.fixture
def pad() -> Iterator[VirtualPad]:
    made = VirtualPad("My Stick", axes=5, buttons=8)
    made.axis(4, -1.0)  # a trigger
    yield made
    made.unplug()
    pygame.event.clear()


@pytest.fixture
def wide(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "160")


def test_it_lists_what_is_there(
    pad: VirtualPad, wide: None, capsys: pytest.CaptureFixture[str]
) -> None:
    gamepad = VirtualPad("Xbox Pad", axes=6, buttons=15, gamepad=True, motors=False)
    assert main(["devices"]) == 0
    said = capsys.readouterr().out
    gamepad.unplug()
    rows = [[cell.strip() for cell in line.split("│")[1:-1]] for line in said.splitlines()]
    rows = [row for row in rows if len(row) == 6]
    guid = PygameDevice(0)._guid
    assert rows[0] == ["0", "My Stick", "joystick", "flight_stick", "yes", guid]
    assert rows[1][:5] == ["1", "Xbox Pad", "joystick", "xbox", "no"]


def test_without_a_device_it_says_what_is_played(capsys: pytest.CaptureFixture[str]) -> None:
    if pygame.joystick.get_init() and pygame.joystick.get_count():
        pytest.skip("a real joystick is plugged in")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(command, "has_screen", lambda: False)
        patch.setattr(command, "spacemouse_names", list)
        assert main(["devices"]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[-1] == "No device is there: operator.device auto plays the recorded operator"


def test_it_shows_axes_and_buttons(
    pad: VirtualPad, wide: None, capsys: pytest.CaptureFixture[str]
) -> None:
    pad.axis(1, -0.5)
    pad.button(0, True)
    assert main(["devices", "--watch", "--seconds", "0.1"]) == 0
    said = capsys.readouterr().out
    assert "My Stick (flight_stick)" in said
    (line,) = [line for line in said.splitlines() if line.startswith("│ y ")]
    assert "#####|" in line
    assert "-0.50" in line
    (line,) = [line for line in said.splitlines() if line.startswith("│ buttons")]
    assert "engage" in line
    assert "clutch" not in line


def act(pad: VirtualPad, monkeypatch: pytest.MonkeyPatch, idle: tuple[str, ...] = ()) -> list[str]:
    """Let an operator do what the command asks for; return what it has said."""
    said: list[str] = []
    axes = {"x": 3, "y": 1, "z": 0, "yaw": 4}  # not those that one would guess
    ways = {"x": (1.0, -1.0), "y": (-1.0, 0.9), "z": (0.8, -0.8), "yaw": (0.5, 1.0)}
    buttons = dict(zip(BUTTON_NAMES, (7, 6, 5, 4, 3, 2), strict=True))

    def motions() -> Iterator[None]:
        while True:
            kind, _, rest = said[-1].partition(" ")
            asked, name = said[-1], rest.partition(":")[0]
            if kind == "Axis" and name in axes and name not in idle:
                for value in (*ways[name], -1.0 if name == "yaw" else 0.0):
                    pad.axis(axes[name], value)
                    yield
            elif kind == "Axis" and name == "mast_hat" and name not in idle:
                for vertical in (1, -1, 0):
                    pad.hat(0, vertical)
                    yield
            elif kind == "Button" and name not in idle:
                for down in (True, False):
                    pad.button(buttons[name], down)
                    yield
            while said[-1] == asked:
                yield

    script: Iterator[None] | None = None

    def sleep(seconds: float) -> None:
        nonlocal script
        script = script or motions()
        next(script)

    monkeypatch.setattr(command.time, "sleep", sleep)
    monkeypatch.setattr(command, "_say", lambda console, text: said.append(text))
    return said


def test_it_writes_a_profile_by_asking(
    pad: VirtualPad, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "mine.yaml"
    act(pad, monkeypatch)
    assert main(["devices", "--calibrate", "0", "--output", str(path)]) == 0
    monkeypatch.undo()
    profile = load_profile(str(path))
    assert profile.name == "mine"
    assert [profile.axes.x[0].input, profile.axes.y[0].input] == ["axis3", "axis1"]
    assert profile.axes.y[0].invert
    trigger = profile.axes.yaw[0]
    assert (trigger.input, trigger.low, trigger.rest, trigger.high) == ("axis4", -1.0, -1.0, 1.0)
    device = PygameDevice(0, None, str(path))
    for index, value in ((0, 0.8), (1, -1.0), (3, -1.0), (4, 0.0)):
        pad.axis(index, value)
    pad.hat(0, 1)
    pad.button(7, True)
    sample = device.sample()
    np.testing.assert_allclose(sample.axes, [-1.0, 1.0, 1.0, 0.0, 1.0], atol=1e-3)
    assert sample.orientation[2] == pytest.approx((0.5 - 0.05) / 0.95, abs=1e-3)
    np.testing.assert_array_equal(sample.buttons, [1, 0, 0, 0, 0, 0])


def test_what_is_not_moved_is_left_out(
    pad: VirtualPad, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "mine.yaml"
    said = act(pad, monkeypatch, idle=("z", "mast_hat", "estop"))
    arguments = ["devices", "--calibrate", "0", "--output", str(path), "--patience", "0.2"]
    assert main(arguments) == 0
    profile = load_profile(str(path))
    assert profile.axes.z == profile.axes.mast_hat == profile.buttons.estop == []
    assert profile.axes.x
    assert profile.buttons.mast == ["button2"]
    assert sum("left out" in line for line in said) == 3


def test_nothing_is_written_where_nothing_moves_or_it_is_unplugged(
    pad: VirtualPad,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    arguments = ["devices", "--calibrate", "0", "--output", str(tmp_path / "mine.yaml")]
    monkeypatch.setattr(command.time, "sleep", lambda seconds: None)
    assert main([*arguments, "--patience", "0.1"]) == 2
    assert "nothing has moved" in capsys.readouterr().err
    monkeypatch.setattr(command.time, "sleep", lambda seconds: pad.unplug())
    assert main(arguments) == 2
    assert "unplugged" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--calibrate", "0"], "--calibrate: no file, allowed with --output FILE.yaml"),
        (["--calibrate", "0", "--output", "."], "--output: '.' is there already"),
        (["--calibrate", "7", "--output", "no.yaml"], "operator.index: 7, allowed 0 (My Stick)"),
        (["--calibrate", "0", "--output", "no.yaml", "--patience", "nan"], "--patience: nan"),
        (["--watch", "0", "--seconds", "-1"], "--seconds: -1"),
        (["--watch", "0", "--profile", "nope"], "operator.profile: 'nope', allowed flight_stick"),
        (["--watch", "0", "--profile", "xbox"], "layout game_controller, allowed joystick"),
    ],
)
def test_bad_input_is_one_line(
    pad: VirtualPad, arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["devices", *arguments]) == 2
    said = capsys.readouterr().err
    assert message in said
    assert said.count("\n") == 1
