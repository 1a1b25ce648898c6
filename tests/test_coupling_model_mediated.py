from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from coupling_rig import E_IN_M, E_OUT_M, F_ENV, F_M, PERIOD, PROFILES, X_M, X_S, Rig, arrivals
from hypothesis import assume, given
from hypothesis import strategies as st
from strategies import examples
from strategies.channels import Conditions, conditions
from strategies.hands import hands

from scara_drake.common.fields import check
from scara_drake.coupling.model_mediated import ModelMediated, press
from scara_drake.coupling.surface_model import (
    FIT,
    MODEL,
    Model,
    fit_surface,
    read_surface,
    render,
)
from scara_drake.operator.master import Master


def fitted(x: np.ndarray, v: np.ndarray, f: np.ndarray) -> Model:
    fit, model = np.zeros(FIT.size), np.zeros(MODEL.size)
    for sample in zip(x, v, f, strict=True):
        fit_surface(*sample, 0.995, fit)
        read_surface(fit, sample[2], model)
    return MODEL.unpack(model)


@examples(60)
@given(
    stiffness=st.floats(200.0, 5e4),
    damping=st.floats(0.0, 500.0),
    surface=st.floats(-0.5, 0.5),
    side=st.sampled_from([-1.0, 1.0]),
)
def test_the_fit_converges_to_a_known_wall(
    stiffness: float, damping: float, surface: float, side: float
) -> None:
    t = 1e-3 * np.arange(1000)
    x = surface + side * (2e-3 + 1e-3 * np.sin(12.0 * t) + 3e-4 * np.sin(31.0 * t))
    v = np.gradient(x, t)
    model = fitted(x, v, stiffness * (x - surface) + damping * v)
    assert model.stiffness == pytest.approx(stiffness, rel=0.02)
    assert model.damping == pytest.approx(damping, rel=0.02, abs=0.02 * stiffness / 30.0)
    assert model.x == pytest.approx(surface, abs=5e-5)
    assert model.side == side


def test_the_fit_forgets_a_wall_that_has_changed() -> None:
    t = 1e-3 * np.arange(4000)
    x = 2e-3 + 1e-3 * np.sin(12.0 * t) + 3e-4 * np.sin(31.0 * t)
    v = np.gradient(x, t)
    stiffness = np.where(t < 1.0, 1e4, 3e3)
    assert fitted(x, v, stiffness * x).stiffness == pytest.approx(3e3, rel=0.01)


def test_a_model_makes_no_step_of_force() -> None:
    # The hand is 2 cm inside when the model comes: 200 N at once, if it were taken as it is.
    model, period, power = np.array([1e4, 50.0, 0.0, 1.0]), 1e-3, 0.1
    rest, stored, x = 0.02, 0.0, 0.02
    for _ in range(500):
        f, rest = render(model, x, 0.0, rest, period, 1e4, power)
        energy = 0.5 * 1e4 * (x - rest) ** 2
        assert energy <= stored + power * period + 1e-12
        stored = energy
    assert f == pytest.approx(np.sqrt(2.0 * 1e4 * 500 * power * period), rel=1e-6)
    # The work of the hand may store more at once: from contact on, it is the wall.
    rest, f = 0.0, 0.0
    for depth in np.linspace(0.0, 1e-3, 500):
        before, f = f, render(model, depth, 2e-3, rest, period, 1e4, 1.0)[0]
        rest = render(model, depth, 2e-3, rest, period, 1e4, 1.0)[1]
        assert abs(f - before) < 1.0
    assert f == pytest.approx(10.0 + 2e-3 * 50.0, rel=1e-2)


def test_no_pull_and_no_force_outside() -> None:
    model = np.array([1e4, 100.0, 0.0, -1.0])
    assert render(model, 1e-3, 0.0, 0.0, 1e-3, 1e4, 0.1) == (0.0, 0.0)
    assert render(model, -1e-4, 0.5, 0.0, 1e-3, 1e4, 0.1)[0] == 0.0
    assert render(np.zeros(4), 5.0, 1.0, 0.0, 1e-3, 1e4, 0.1) == (0.0, 5.0)


@pytest.mark.parametrize("profile", PROFILES)
def test_the_wall_is_felt_where_it_is_whatever_the_delay(profile: str) -> None:
    up, down = (arrivals(PROFILES[profile], 16_000, 0.1, seed) for seed in (1, 2))
    result = Rig().run(ModelMediated(), up, down, 16.0)
    hold = (result[:, 0] > 5.0) & (result[:, 0] < 6.0)
    # The hand of 150 N/m, 3 cm inside a wall of 1e4 N/m that begins at -1 cm: 0.44 mm, 4.43 N.
    assert abs(result[:, F_M]).max() < 10.0
    assert result[hold, F_M].mean() == pytest.approx(-4.43, abs=0.15)
    assert result[hold, X_M].mean() == pytest.approx(-0.01044, abs=1.5e-3)
    assert abs(result[-500:, X_M] - result[-500:, X_S]).max() < 1e-3


STEADY: dict[str, Conditions] = {
    "none": Conditions(),
    "0.1 s": Conditions(delay=0.1),
    "lossy": Conditions(delay=0.1, spread=0.1, loss=0.3, seed=1),
}


@pytest.mark.parametrize("force_scale", [1.0, 0.3])
@pytest.mark.parametrize("channel", STEADY)
def test_the_tool_presses_with_the_force_that_is_shown(channel: str, force_scale: float) -> None:
    up = STEADY[channel]
    down = replace(up, seed=up.seed + 1)
    coupling = ModelMediated(force_scale=force_scale)
    result = Rig().run(coupling, up.shown(6000), down.shown(6000), 6.0)
    hold = result[:, 0] > 5.0
    shown, felt = -result[hold, F_M].mean(), force_scale * result[hold, F_ENV].mean()
    assert shown == pytest.approx(0.03 / (1.0 / 150.0 + 1.0 / (force_scale * 1e4)), rel=0.05)
    assert felt == pytest.approx(shown, rel=0.02)


@given(spring=st.floats(-50.0, 50.0), shown=st.floats(-50.0, 50.0))
def test_the_press_is_bounded_by_spring_and_shown_force(spring: float, shown: float) -> None:
    force = press(spring, shown)
    # Never against what is shown, never more than the larger; nothing beyond the spring's reach.
    assert abs(force) <= max(abs(spring), abs(shown)) + 1e-12
    assert abs(force - spring) <= abs(shown) + 1e-12
    assert press(spring, 0.0) == spring
    if 0.0 <= spring <= shown:
        assert force == pytest.approx(shown)


@examples(60)
@given(hand=hands(6.0), up=conditions(0.3), down=conditions(0.3))
def test_what_is_rendered_is_passive_for_brisk_hands(
    hand: Master, up: Conditions, down: Conditions
) -> None:
    result = Rig(master=hand).run(ModelMediated(), up.shown(6000), down.shown(6000), 6.0)
    # As for the passive couplings: hand and actuators turn the device at 200 m/s² at most.
    assume(abs(np.diff(result[:, X_M], 2)).max() < 200.0 * PERIOD**2)
    # The model may store 0.1 W under the hand; the sampled spring is paid by its damping, but for
    # the way between two ticks where the hand goes in or comes out.
    touches = result[:, F_M] != 0.0
    crossed = np.diff(touches, prepend=False) | np.diff(touches, append=False)
    way = np.diff(result[:, X_M], prepend=0.0)
    held = np.cumsum(np.where(crossed, ModelMediated().max_stiffness * way**2, 0.0))
    allowed = ModelMediated().power * result[:, 0] + 0.01 + held
    assert np.all(result[:, E_OUT_M] - result[:, E_IN_M] <= allowed)
    assert abs(result[:, X_M]).max() < 0.3  # the hand itself goes to 0.2 m


def test_wrong_fields_are_named() -> None:
    with pytest.raises(ValueError, match=r"c\.forgetting: 1\.5, allowed 0\.9 to 1"):
        check(ModelMediated(forgetting=1.5), "c")


def test_a_device_bounds_what_is_rendered() -> None:
    # On a device of 400 N/m and 4 N s/m, a wall of 10 kN/m and 100 N s/m is one of these.
    cut = ModelMediated().within(400.0, 4.0)
    assert (cut.max_stiffness, cut.max_damping) == (400.0, 4.0)
    assert ModelMediated(max_stiffness=50.0).within(400.0, 4.0).max_stiffness == 50.0
    assert cut.asked_stiffness(1e4) == 400.0
    model = np.array([1e4, 100.0, 0.0, 1.0])
    f, rest = 0.0, 0.0
    for _ in range(4000):
        f, rest = render(model, 5e-3, 0.01, rest, 1e-3, 400.0, 0.1, 4.0)
    assert f == pytest.approx(400.0 * 5e-3 + 4.0 * 0.01)
