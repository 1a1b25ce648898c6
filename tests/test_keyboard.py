"""The keyboard as a device: posted events, without a window that could be seen."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
if not os.environ.get("DISPLAY"):
    os.environ.setdefault("SDL_VIDEODRIVER", "dummy")

import pygame
from hypothesis import given
from hypothesis import strategies as st
from strategies import examples

from scara_drake.operator.devices import NoDeviceError
from scara_drake.operator.devices.keyboard import RAMP, KeyboardDevice, open_keyboard
from scara_drake.operator.joystick import Joystick

TICK = 0.01


class Hands:
    """A keyboard, and who types on it."""

    def __init__(self) -> None:
        self.time = 0.0
        self.device = KeyboardDevice(now=lambda: self.time)
        pygame.event.clear()

    def key(self, code: int, down: bool = True) -> None:
        pygame.event.post(pygame.event.Event(pygame.KEYDOWN if down else pygame.KEYUP, key=code))

    def ticks(self, seconds: float) -> np.ndarray:
        rows = []
        for _ in range(round(seconds / TICK)):
            self.time += TICK
            rows.append(self.device.sample().axes)
        return np.array(rows)


@pytest.fixture
def hands() -> Iterator[Hands]:
    made = Hands()
    yield made
    made.device.close()
    pygame.event.clear() if pygame.display.get_init() else None


def test_an_axis_runs_to_its_key_and_back_without_a_step(hands: Hands) -> None:
    hands.key(pygame.K_RIGHT)
    x = hands.ticks(0.5)[:, 0]
    np.testing.assert_allclose(x, np.minimum(np.arange(1, 51) * TICK / RAMP, 1.0), atol=1e-9)
    hands.key(pygame.K_RIGHT, down=False)
    x = hands.ticks(0.5)[:, 0]
    np.testing.assert_allclose(x, np.maximum(1.0 - np.arange(1, 51) * TICK / RAMP, 0.0), atol=1e-9)


def test_opposite_keys_cancel_and_buttons_are_there_at_once(hands: Hands) -> None:
    for code in (pygame.K_LEFT, pygame.K_RIGHT, pygame.K_SPACE, pygame.K_ESCAPE):
        hands.key(code)
    assert hands.ticks(TICK)[0, 0] == 0.0
    buttons = hands.device.sample().buttons
    np.testing.assert_array_equal(buttons, [1, 0, 0, 0, 1, 0])


@pytest.mark.parametrize("event", [pygame.WINDOWFOCUSLOST])
def test_without_the_focus_all_keys_are_let_go(hands: Hands, event: int) -> None:
    hands.key(pygame.K_UP)
    hands.key(pygame.K_SPACE)
    assert hands.ticks(RAMP + TICK)[-1, 1] == -1.0
    pygame.event.post(pygame.event.Event(event))
    assert not hands.device.sample().buttons.any()
    assert hands.ticks(RAMP + TICK)[-1, 1] == 0.0
    assert hands.device.sample().connected


def test_a_closed_window_is_a_lost_device(hands: Hands) -> None:
    hands.key(pygame.K_UP)
    held = hands.ticks(0.1)[-1]
    pygame.event.post(pygame.event.Event(pygame.QUIT))
    lost = hands.device.sample()
    assert not lost.connected
    np.testing.assert_array_equal(lost.axes, held)
    assert not hands.device.rumble(1.0, 1.0, 100)


@examples(20)
@given(
    presses=st.lists(
        st.tuples(st.sampled_from([pygame.K_LEFT, pygame.K_RIGHT, pygame.K_a]), st.booleans()),
        max_size=30,
    ),
    pause=st.floats(0.001, 5.0),
)
def test_no_axis_steps_whatever_is_typed(presses: list[tuple[int, bool]], pause: float) -> None:
    hands = Hands()
    last = np.zeros(5)
    for code, down in presses:
        hands.key(code, down)
        hands.time += pause
        axes = hands.device.sample().axes
        # Of the two keys of an axis each runs its way; a pause counts as 0.1 s at most.
        assert np.abs(axes - last).max() <= 2.0 * min(pause, 0.1) / RAMP + 1e-9
        last = axes


def test_without_a_display_the_recorded_operator_plays_and_it_is_said(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setattr("sys.platform", "linux")
    with pytest.raises(NoDeviceError, match="there is no display"):
        open_keyboard()
    assert Joystick(device="keyboard").open_device() is None
    (said,) = [record.getMessage() for record in caplog.records]
    assert said.startswith("operator.device: keyboard, but there is no display")
    assert said.endswith("; the recorded operator plays")


def test_without_pygame_the_recorded_operator_plays_and_it_is_said(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    from scara_drake.operator.devices import sdl

    monkeypatch.setitem(__import__("sys").modules, "pygame", None)
    sdl.sdl.cache_clear()
    try:
        for kind in ("auto", "joystick"):
            caplog.clear()
            assert Joystick(device=kind).open_device() is None
            (said,) = [record.getMessage() for record in caplog.records]
            assert f"{kind}, but pygame cannot be loaded" in said
            assert said.endswith("; the recorded operator plays")
    finally:
        sdl.sdl.cache_clear()


def test_a_key_that_does_not_exist_and_another_layout_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text("layout: keyboard\nbuttons: {engage: [spacebar]}\n", encoding="utf-8")
    with pytest.raises(ValueError, match="'spacebar', allowed a key of pygame"):
        KeyboardDevice(str(path))
    with pytest.raises(ValueError, match="'xbox' of layout game_controller, allowed keyboard"):
        KeyboardDevice("xbox")
