"""Certificates of stability: what is proven is never more than what is seen."""

from __future__ import annotations

import math
from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numba import njit
from numpy.typing import NDArray
from strategies import examples

from scara_drake.coupling.direct import Direct
from scara_drake.coupling.position_damping import PositionDamping
from scara_drake.coupling.wave_variables import WaveVariables
from scara_drake.metrics import bilateral as bilateral_metrics
from scara_drake.operator.master import Master
from scara_drake.scenario import load_scenario
from scara_drake.simulation.run import simulate
from scara_drake.stability import Certificates, certify
from scara_drake.stability.certificates import (
    Loop,
    absolute_delay,
    bears_any_delay,
    colgate_bound,
    krasovskii,
    proven_delay,
    seen_delay,
    varying_delay,
)
from scara_drake.stability.certificates.exact import exact, is_positive_definite
from scara_drake.stability.certificates.linear_couplings import Touch, loop_of, touches
from scara_drake.stability.certificates.result import VARYING, Certificate, Seen

Array = NDArray[np.float64]
ALONE = Loop(np.array([[0.0]]), np.array([[-1.0]]), np.array([[1.0]]))  # x' = -x(t - h)
SOFT = "!Direct {force_scale: 0.03}"


@cache
def certified(coupling: str) -> Certificates:
    return certify(load_scenario("bilateral", {"coupling": coupling}))


def grows(loop: Loop, delay: float) -> bool:
    """Whether the loop swings up, simulated by Heun's rule over what it was before."""
    a, b, c = loop.lumped()
    rates = np.abs(np.linalg.eigvals(loop.undelayed()))
    late = math.ceil(delay / min(0.02 / rates.max(), delay / 20.0))
    step = delay / late
    x = heun(a, b[:, 0], c[0], late, step, min(round(400.0 / rates.min() / step), 400_000))
    energy = ((x / np.abs(x).max(axis=0)) ** 2).sum(axis=1)
    third = energy.size // 3
    return bool(energy[-third:].sum() > energy[third : 2 * third].sum())


@njit
def heun(a: Array, b: Array, c: Array, late: int, step: float, count: int) -> Array:
    """States (count, n) of x' = a x + b c x(t - late steps), from 1 and at rest there before."""
    x = np.ones((count, b.size))
    for k in range(count - 1):
        now, then = c @ x[max(k - late, 0)], c @ x[max(k + 1 - late, 0)]
        slope = a @ x[k] + b * now
        x[k + 1] = x[k] + 0.5 * step * (slope + a @ (x[k] + step * slope) + b * then)
    return x


# --- exact arithmetic


def test_definite_is_decided_without_rounding() -> None:
    third = Fraction(1, 3)
    assert not is_positive_definite([[1, third], [third, Fraction(1, 9)]])  # singular
    assert is_positive_definite([[1, third], [third, Fraction(1, 9) + Fraction(1, 10**40)]])
    assert not is_positive_definite([[1, third], [third, Fraction(1, 9) - Fraction(1, 10**40)]])
    assert not is_positive_definite([[1, 0], [third, 1]])
    with pytest.raises(ValueError, match="values: not all are finite, allowed finite numbers"):
        exact([1.0, math.nan])


@given(st.integers(1, 6), st.integers(0, 2**32 - 1), st.floats(-1.0, 1.0))
@examples(20)
def test_definite_is_what_the_eigenvalues_say(size: int, seed: int, shift: float) -> None:
    half = np.random.default_rng(seed).normal(size=(size, size))
    matrix = half @ half.T + shift * np.eye(size)
    least = np.linalg.eigvalsh(0.5 * (matrix + matrix.T)).min()
    if abs(least) > 1e-9:
        assert is_positive_definite(exact(0.5 * (matrix + matrix.T))) == (least > 0.0)


# --- loops


def test_the_textbook_loop() -> None:
    # x' = -x(t - h): stable up to pi / 2 where h is constant, and up to 3 / 2 where it varies.
    assert seen_delay(ALONE) == pytest.approx(0.5 * np.pi)
    assert 0.99 * 0.5 * np.pi < proven_delay(ALONE) < 0.5 * np.pi
    assert 0.99 < varying_delay(ALONE) <= 1.0  # of small gain
    assert not bears_any_delay(ALONE)
    assert bears_any_delay(Loop(np.array([[-1.0]]), np.array([[-0.99]]), np.array([[1.0]])))
    assert not bears_any_delay(Loop(np.array([[-1.0]]), np.array([[-1.01]]), np.array([[1.0]])))


def test_what_is_unstable_without_a_delay_has_no_proof() -> None:
    loop = Loop(np.array([[0.0]]), np.array([[1.0]]), np.array([[1.0]]))
    assert seen_delay(loop) == proven_delay(loop) == varying_delay(loop) == 0.0


def test_a_functional_that_proves_nothing_is_refused() -> None:
    found = krasovskii.find(ALONE, 0.0, 1.0, 1)
    assert found is not None
    assert krasovskii.verify(ALONE, 0.0, 1.0, found, 1)
    assert not krasovskii.verify(ALONE, 0.0, 2.0, found, 1)
    for worse in (found._replace(p=-found.p), found._replace(s=-found.s), found._replace(r=0.0)):
        assert not krasovskii.verify(ALONE, 0.0, 1.0, worse, 1)
    assert not krasovskii.verify(ALONE, 0.0, 1.0, found._replace(p=np.nan * found.p), 1)


couplings = st.one_of(
    st.builds(Direct, force_scale=st.floats(1e-3, 0.3), position_scale=st.floats(0.5, 2.0)),
    st.builds(
        PositionDamping,
        stiffness=st.floats(50.0, 3000.0),
        damping=st.floats(1.0, 60.0),
        force_scale=st.floats(0.1, 2.0),
    ),
)
hands = st.tuples(st.floats(20.0, 1000.0), st.floats(0.5, 20.0), st.floats(0.1, 2.0))
walls = st.tuples(st.floats(200.0, 2e4), st.floats(1.0, 200.0))


@given(coupling=couplings, hand=hands, wall=walls)
@examples(4)
def test_no_random_loop_is_proven_beyond_what_is_seen(
    coupling: Direct | PositionDamping,
    hand: tuple[float, float, float],
    wall: tuple[float, float],
) -> None:
    scenario = load_scenario("bilateral")
    scenario.coupling = coupling
    scenario.operator = Master(hand_stiffness=hand[0], hand_damping=hand[1], mass=hand[2])
    for touch in (Touch(), Touch("wall", *wall)):
        loop = loop_of(scenario, touch)
        if loop is None:
            continue
        seen = seen_delay(loop)
        if bears_any_delay(loop):
            assert seen == math.inf
            continue
        proven = proven_delay(loop, 1.0, order=1)
        each = varying_delay(loop, 1.0)
        assert 2.0 * each <= proven * 1.02 or proven >= 1.0
        assert proven <= seen
        if 0.0 < proven < 0.5:
            assert not grows(loop, proven)
            assert proven > 0.8 * seen
            assert grows(loop, 1.05 * seen)


# --- couplings


@given(
    stiffness=st.floats(10.0, 1e3),
    damping=st.floats(1.0, 60.0),
    friction=st.floats(0.0, 5.0),
)
@examples(5)
def test_llewellyn_of_springs_and_dampers_is_their_condition(
    stiffness: float, damping: float, friction: float
) -> None:
    # 4 B_l B_r = (T_l + T_r)² K², the device's friction being a part of B_l.
    longest = 2.0 * math.sqrt((damping + friction) * damping) / stiffness
    coupling = PositionDamping(stiffness=stiffness, damping=damping)
    found = absolute_delay(coupling, Master(damping=friction), 400.0)
    assert found == pytest.approx(longest, rel=1e-3)
    if friction == 0.0:
        assert coupling.margin(0.5 * longest, 0.5 * longest) == pytest.approx(1.0)


def test_llewellyn_of_the_others() -> None:
    assert absolute_delay(WaveVariables(), Master(), 400.0) == math.inf
    assert absolute_delay(Direct(), Master(), 400.0) == 0.0


def test_colgate_is_half_a_period_of_stiffness() -> None:
    assert colgate_bound(2.0, 0.5, 1e-3) == pytest.approx(3000.0)
    assert colgate_bound(2.0, -0.5, 1e-3) == pytest.approx(3000.0)


@pytest.mark.parametrize(
    "coupling", ["!Direct {}", SOFT, "!PositionDamping {stiffness: 1000.0, damping: 5.0}"]
)
def test_a_scenario_is_nowhere_proven_beyond_what_is_seen(coupling: str) -> None:
    found = certified(coupling)
    assert found.contradictions() == []
    assert all(one.exact for one in found.proven if one.contact != "any")
    for contact in found.contacts:
        assert found.proven_delay(contact, VARYING) <= found.proven_delay(contact)
        assert found.seen_delay(contact) < math.inf or found.proven_delay(contact) == math.inf


def stable_press(coupling: str, delay: float) -> bool:
    up = f"!ConstantDelay {{delay: {delay}}}"
    fields = {"coupling": coupling, "channel.up": up, "channel.down": "!ConstantDelay {}"}
    recording = simulate(load_scenario("bilateral", fields), duration=6.0)
    return bilateral_metrics.is_stable_press(
        recording, begin=2.0, end=6.0, way=0.04, stiffness=150.0, mass=0.3
    )


def test_the_arm_itself_turns_over_behind_what_is_proven() -> None:
    found = certified(SOFT)
    lightly, firmly = (found.proven_delay(contact) for contact in ("wall, lightly", "wall"))
    assert 0.0 < lightly < firmly
    assert stable_press(SOFT, math.floor(1e3 * lightly) * 1e-3)
    # The hand holds the tool deeper than the blend, so the firm contact decides.
    assert not stable_press(SOFT, math.ceil(1e3 * found.seen_delay("wall")) * 1e-3 + 1e-3)


def test_the_default_springs_and_dampers_are_proven_for_their_channel() -> None:
    found = certified("!PositionDamping {}")
    assert found.covers()
    assert found.channel == pytest.approx(0.2)
    rule = next(one for one in found.proven if one.rule.startswith("4 B"))
    assert rule.delay == pytest.approx(0.6 - found.own)
    assert found.proven_delay("free", VARYING) >= rule.delay


def test_what_is_lost_has_no_bounded_age() -> None:
    lossy = "!Packets {loss: {in_good: 0.1}, longest: 0.05}"
    for coupling, covered in (("!PositionDamping {}", False), ("!WaveVariables {}", True)):
        found = certify(load_scenario("bilateral", {"coupling": coupling, "channel.up": lossy}))
        assert found.channel == math.inf
        assert found.covers() == covered
        assert "age has no bound" in str(found)


def test_it_says_what_it_does_not_know() -> None:
    for coupling in ("!Tdpa {}", "!ModelMediated {}"):
        found = certified(coupling)
        assert not found.covers()
        assert "no linear loop" in str(found)
    assert "passive up to 4000 N/m" in str(found)


def test_it_is_told_in_words_and_in_a_notebook() -> None:
    found = certified(SOFT)
    text = str(found)
    assert text.startswith("Direct, channel of 200 ms there and back: not proven")
    assert "touching wall, lightly: proven up to" in text
    assert "Lyapunov-Krasovskii" in found._repr_html_()


def test_a_contradiction_is_told() -> None:
    proven = Certificate("rule", "wall", "constant", 0.02, "nothing", exact=True)
    seen = Seen("wall", 0.01)
    found = Certificates("Direct", 0.0, 0.0, True, 0.0, (proven,), (seen,))
    assert found.contradictions() == ["wall: proven up to 20 ms, seen unstable at 10 ms"]


def test_only_a_hand_on_a_device_closes_a_loop() -> None:
    with pytest.raises(ValueError, match=r"operator: !Joystick, allowed !Master"):
        certify(load_scenario("teleoperation"))


def test_a_contact_with_another_law_is_left_out() -> None:
    scenario = load_scenario("bilateral")
    assert [touch.name for touch in touches(scenario)] == ["free", "wall", "wall, lightly"]
    scenario.environment.surfaces[0].law = "hunt_crossley"
    assert [touch.name for touch in touches(scenario)] == ["free"]
