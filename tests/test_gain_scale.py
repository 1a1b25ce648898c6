"""The operator's scale of the gains: what it scales, how fast, and that 1 is nothing."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import examples

import scara_drake as sd
from scara_drake.control.gain_scale import LEAST, MOST, GainScale, scale_step
from scara_drake.control.integral_sliding_mode import (
    INTEGRAL,
    IntegralSlidingMode,
    ismc_update,
)
from scara_drake.vectors import LIVE_SETTINGS, NEUTRAL_SETTINGS

H = 1e-3


def settings(scale: float) -> np.ndarray:
    return LIVE_SETTINGS.pack(**NEUTRAL_SETTINGS._replace(gain_scale=scale)._asdict())


@given(st.lists(st.floats(allow_nan=True), min_size=1, max_size=30))
@examples(50)
def test_the_scale_stays_in_its_bounds_and_has_no_step(wanted: list[float]) -> None:
    scale, seen = np.ones(1), [1.0]
    for value in wanted:
        for _ in range(50):
            scale_step(settings(value), H, scale)
            seen.append(scale.item())
    assert LEAST <= min(seen) <= max(seen) <= MOST
    assert abs(np.diff(seen)).max() <= H + 1e-12


def test_the_scale_arrives() -> None:
    scale = np.ones(1)
    for _ in range(600):
        scale_step(settings(0.5), H, scale)
    assert scale.item() == pytest.approx(0.5)


def law(gains: IntegralSlidingMode, scale: float, seed: int) -> list[np.ndarray]:
    """What the law writes in a tick, from states and a memory at random."""
    rng = np.random.default_rng(seed)
    desired, state, memory = (
        rng.normal(size=12),
        rng.normal(size=12),
        rng.normal(size=INTEGRAL.size),
    )
    written = [np.zeros(6) for _ in range(3)]
    ismc_update(desired, state, np.array([scale]), gains.parameters(H), memory, *written)
    return [*written, memory]


@given(st.floats(LEAST, MOST), st.integers(0, 10_000))
@examples(50)
def test_it_scales_k_and_rho_and_nothing_else(scale: float, seed: int) -> None:
    gains = IntegralSlidingMode(gravity_compensation=True)
    less = dataclasses.replace(
        gains, k=[scale * k for k in gains.k], rho=[scale * rho for rho in gains.rho]
    )
    for one, other in zip(law(gains, scale, seed), law(less, 1.0, seed), strict=True):
        np.testing.assert_array_equal(one, other)


def test_the_rule_against_chatter_holds_at_every_scale() -> None:
    gains = IntegralSlidingMode()
    for scale in np.linspace(LEAST, MOST, 16):
        less = dataclasses.replace(
            gains, k=[scale * k for k in gains.k], rho=[scale * rho for rho in gains.rho]
        )
        less.check_sampling("controller", H)


def test_it_is_said_where_a_controller_takes_no_scale(tmp_path, caplog) -> None:
    trace = tmp_path / "settings.csv"
    trace.write_text("time,x,y,z,mast_axis,mast_hat,gain_scale\n0,0,0,0,0,0,1\n")
    changes = {"operator.trace": str(trace), "supervision": "{}", "controller": "!Pid {}"}
    with caplog.at_level("INFO", logger="scara_drake"):
        sd.make_diagram(sd.load_scenario("teleoperation", changes))
        assert "Gain scale: of no effect with Pid" in caplog.text
        caplog.clear()
        diagram = sd.make_diagram(
            sd.load_scenario("teleoperation", {**changes, "controller": "!IntegralSlidingMode {}"})
        )
    assert "Gain scale" not in caplog.text
    assert isinstance(diagram.GetSubsystemByName("gain_scale"), GainScale)
