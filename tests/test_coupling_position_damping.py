from __future__ import annotations

import cmath
import math

import numpy as np
import pytest
from coupling_rig import F_M, X_M, X_S, Rig
from hypothesis import assume, given
from hypothesis import strategies as st
from numba import njit

from scara_drake.channel.presets import PRESETS
from scara_drake.common.fields import check
from scara_drake.coupling.layouts import MASTER_CONSTANTS
from scara_drake.coupling.position_damping import (
    PositionDamping,
    damping_margin,
    position_master,
)

STIFFNESS, DELAY = 100.0, 0.1  # [N/m], [s] each way


def damping_at(margin: float) -> float:
    """B [N s/m] with this margin, at `STIFFNESS` and `DELAY`."""
    return STIFFNESS * DELAY * math.sqrt(margin)


def test_the_margin_is_the_sufficient_condition() -> None:
    # 4 B^2 > (T_l + T_r)^2 K^2: with T = 0.3 and 0.4 s, B = 0.35 s times K.
    assert damping_margin(100.0, 35.0, 0.3, 0.4) == pytest.approx(1.0)
    assert damping_margin(100.0, 70.0, 0.3, 0.4) == pytest.approx(4.0)
    assert damping_margin(200.0, 70.0, 0.3, 0.4) == pytest.approx(1.0)
    assert damping_margin(100.0, 35.0, 0.7, 0.0) == pytest.approx(1.0)
    assert damping_margin(100.0, 1.0, 0.0, 0.0) == math.inf
    assert PositionDamping(stiffness=100.0, damping=35.0).margin(0.3, 0.4) == pytest.approx(1.0)


@given(
    up=st.floats(0.01, 2.0),
    down=st.floats(0.01, 2.0),
    damping=st.floats(0.1, 1e3),
    stiffness=st.floats(1.0, 1e3),
)
def test_the_lemma_has_a_solution_where_the_margin_is_above_one(
    up: float, down: float, damping: float, stiffness: float
) -> None:
    margin = damping_margin(stiffness, damping, up, down)
    assume(abs(margin - 1.0) > 0.01)
    # 2 B / K > a + T_l^2 / c and 2 B / K > c + T_r^2 / a: the first bounds a for each c.
    side = 2.0 * damping / stiffness
    c = up * up / side * (1.0 + np.geomspace(1e-4, 1e4, 20_000))
    a = side - up * up / c
    assert np.any(c + down * down / a < side) == (margin > 1.0)


def rightmost(mass: float, damping: float) -> float:
    """Real part of the rightmost root of M s^2 + B s + K (1 + e^(-s T)), by Newton from a grid."""
    roots = []
    for start in (
        complex(x, y) for x in (-3.0, -1.0, 0.0, 1.0) for y in np.linspace(0.5, 40.0, 40)
    ):
        s = start
        for _ in range(60):
            late = STIFFNESS * cmath.exp(-s * DELAY)
            value = mass * s * s + damping * s + STIFFNESS + late
            step = value / (2.0 * mass * s + damping - DELAY * late)
            s -= step
            if not abs(s) < 1e3 or abs(step) < 1e-12:
                break
        if abs(s) < 1e3 and abs(step) < 1e-10:
            roots.append(s.real)
    return max(roots)


@pytest.mark.parametrize("mass", [1.0, 2.0, 5.0, 10.0, 20.0, 50.0])
def test_two_free_masses_are_stable_above_the_margin(mass: float) -> None:
    assert rightmost(mass, damping_at(1.02)) < 0.0


@pytest.mark.parametrize(("margin", "mass"), [(0.64, 5.0), (0.64, 20.0), (0.95, 20.0)])
def test_two_free_masses_are_unstable_below_the_margin(margin: float, mass: float) -> None:
    assert rightmost(mass, damping_at(margin)) > 0.0


@njit
def drift_apart(constants, memories, packet_size, mass, delay, steps):
    """Distance [m] of two free masses at each tick, a master's law at both, from 1 cm each."""
    motion = np.zeros((2, 6))
    motion[0, 0], motion[1, 0] = 0.01, -0.01
    sent = np.zeros((2, steps + 1, packet_size))
    force, energy, packet = np.zeros((2, 3)), np.zeros((2, 6)), np.zeros((2, packet_size))
    apart = np.zeros(steps)
    for k in range(steps):
        for end in range(2):
            position_master(
                motion[end], sent[1 - end, max(k - delay, 0)], constants, memories[end],
                packet[end], force[end], energy[end],
            )  # fmt: skip
        for end in range(2):
            sent[end, k + 1] = packet[end]
            motion[end, 3] -= 1e-3 * force[end, 0] / mass
            motion[end, 0] += 1e-3 * motion[end, 3]
        apart[k] = motion[0, 0] - motion[1, 0]
    return apart


@pytest.mark.parametrize(("damping", "grows"), [(8.0, True), (10.5, False)])
def test_two_masses_of_20_kg_in_the_law_of_the_master(damping: float, grows: bool) -> None:
    coupling = PositionDamping(stiffness=STIFFNESS, damping=damping)
    assert (coupling.margin(DELAY, DELAY) < 1.0) == grows
    start = coupling.exchange().master_start()
    constants = MASTER_CONSTANTS.pack(
        period=1e-3, actuator_limit=np.inf, gains=coupling.parameters(1e-3)
    )
    size = coupling.exchange().down_size
    apart = drift_apart(constants, np.array([start, start]), size, 20.0, 100, 40_000)
    first, last = abs(apart[5_000:10_000]).max(), abs(apart[-5_000:]).max()
    # The rightmost roots are 0.045 and -0.016 /s: over 30 s a factor of 3.9 and 0.6.
    assert (last > 3.0 * first) if grows else (last < 0.75 * first)


def test_the_defaults_are_within_the_condition_but_for_the_longest_channels() -> None:
    coupling, within = PositionDamping(), {}
    for name, preset in PRESETS.items():
        longest = preset.link.maximum()
        within[name] = coupling.margin(longest, longest) > 1.0
    # Of these three, "paper_2s" delays by up to 2 s; the others may, by their longest jitter.
    assert {name for name, met in within.items() if not met} == {"paper_2s", "4g", "satellite"}
    assert coupling.margin(0.299, 0.299) > 1.0 > coupling.margin(0.301, 0.301)


@pytest.mark.parametrize("delay", [0.02, 0.2, lambda t: max(0.2 * math.sin(t), 0.0)])
def test_where_the_condition_holds_it_settles(delay: float) -> None:
    coupling = PositionDamping()
    assert coupling.margin(0.2, 0.2) > 1.0
    result = Rig().run(coupling, delay, delay, 14.0)
    assert abs(result[-500:, F_M]).max() < 0.01
    assert abs(result[-500:, X_M] - result[-500:, X_S]).max() < 1e-4


def test_far_below_the_condition_it_does_not() -> None:
    coupling = PositionDamping(stiffness=5000.0, damping=2.0)
    assert coupling.margin(0.2, 0.2) < 0.01
    result = Rig(wall=-9.0).run(coupling, 0.2, 0.2, 14.0)
    assert abs(result[-1000:, F_M]).max() > 50.0


def test_the_spring_shows_where_the_other_end_is() -> None:
    # In the wall: hand and coupling in series, f = K_h K / (K_h + K) (x_t - x_wall), wall stiff.
    result = Rig().run(PositionDamping(), 0.0, 0.0, 6.0)
    in_series = 150.0 * 100.0 / 250.0 * 0.03
    assert -result[-1, F_M] == pytest.approx(in_series, rel=0.02)


def test_wrong_fields_are_named() -> None:
    with pytest.raises(ValueError, match=r"c\.damping: -1\.0, allowed 0 to 10000"):
        check(PositionDamping(damping=-1.0), "c")
