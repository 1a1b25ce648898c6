from __future__ import annotations

import numpy as np
import pytest
from coupling_rig import (
    E_OUT_M,
    E_OUT_S,
    F_M,
    PERIOD,
    PROFILES,
    RX_M,
    RX_S,
    X_M,
    X_S,
    Rig,
    arrivals,
)
from hypothesis import given, settings
from hypothesis import strategies as st

from scara_drake.common.fields import check
from scara_drake.coupling.direct import Direct
from scara_drake.coupling.tdpa import DOWN, UP, Tdpa

DURATION = 10.0
STEPS = round(DURATION / PERIOD)


def random_channel(seed: int, longest: float, loss: float) -> np.ndarray:
    """A walk of the delay up to `longest` [s], with loss, jitter that reorders, and an outage."""
    draw = np.random.default_rng(seed)
    walk = np.cumsum(draw.normal(0.0, 0.003, STEPS)) + draw.uniform(0.0, longest)
    delay = np.abs((walk + longest) % (2.0 * longest) - longest)
    delay += draw.exponential(0.01, STEPS) * (draw.random(STEPS) < 0.3)
    start = draw.integers(0, STEPS)
    arrive = np.arange(STEPS) + np.round(delay / PERIOD).astype(int)
    arrive[draw.random(STEPS) < loss] = 2 * STEPS
    arrive[start : start + draw.integers(0, 1500)] = 2 * STEPS
    # The port shows the packet that came last, which may be an old one: the end has to drop it.
    shown = np.zeros(STEPS + 1, dtype=np.int64)
    for number, tick in enumerate(arrive):
        if tick < STEPS:
            shown[tick + 1] = number + 1
    for k in range(1, STEPS):
        shown[k] = shown[k] or shown[k - 1]
    return shown[:STEPS]


@settings(deadline=None, max_examples=200)
@given(
    seed=st.integers(0, 2**31),
    longest=st.floats(0.002, 1.0),
    loss=st.floats(0.0, 0.5),
    reserve=st.floats(0.005, 0.1),
    force_scale=st.sampled_from([1.0, 0.3, 0.1]),
    stiffness=st.sampled_from([500.0, 1000.0, 4000.0]),
)
def test_no_end_gives_more_than_has_come_in(
    seed: int, longest: float, loss: float, reserve: float, force_scale: float, stiffness: float
) -> None:
    coupling = Tdpa(reserve=reserve, force_scale=force_scale, stiffness=stiffness)
    up, down = random_channel(seed, longest, loss), random_channel(seed + 1, longest, loss)
    result = Rig().run(coupling, up, down, DURATION, UP.slices["e_in"], DOWN.slices["e_in"])
    # What has arrived so far, at best; the energies at the device are exact, see test_master.
    arrived_s = np.maximum.accumulate(result[:, RX_S])
    arrived_m = np.maximum.accumulate(result[:, RX_M])
    assert np.all(result[:, E_OUT_S] <= arrived_s + reserve + 1e-12)
    assert np.all(result[:, E_OUT_M] <= arrived_m + reserve + 1e-12)
    assert abs(result[:, X_M]).max() < 0.1  # the hand itself goes to 0.04 m


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("loss", [0.0, 0.1])
def test_direct_diverges_where_tdpa_presses(profile: str, loss: float) -> None:
    steps = 16_000
    up, down = (arrivals(PROFILES[profile], steps, loss, seed) for seed in (1, 2))
    direct = Rig().run(Direct(), up, down, 16.0)
    assert abs(direct[:, F_M]).max() > 100.0  # the hand can press with 4.5 N
    full = Rig().run(Tdpa(), up, down, 16.0)
    tenth = Rig().run(Tdpa(force_scale=0.1), up, down, 16.0)
    assert abs(full[:, F_M]).max() < 40.0
    assert abs(tenth[:, F_M]).max() < 10.0
    for result in (full, tenth):
        assert abs(result[-500:, X_M] - result[-500:, X_S]).max() < 1e-3
        assert abs(result[-500:, F_M]).max() < 0.5


def test_a_reserve_of_zero_locks_up() -> None:
    # Nothing can start: no force, so no energy, so no force. The slave stays outside the wall.
    locked = Rig().run(Tdpa(reserve=0.0), 0.1, 0.1, 6.0)
    free = Rig().run(Tdpa(), 0.1, 0.1, 6.0)
    assert abs(locked[-500:, X_M] - locked[-500:, X_S]).mean() > 0.015
    assert abs(free[-500:, X_M] - free[-500:, X_S]).mean() < 0.010


@pytest.mark.parametrize("end", [1.6, 3.0, 8.0])
def test_an_outage_stops_the_slave_and_ends_without_a_jump(end: float) -> None:
    steps = 14_000
    up = arrivals(0.02, steps)
    down = up.copy()
    cut = slice(1500, round(end / PERIOD))
    up[cut], down[cut] = up[1500], down[1500]
    result = Rig().run(Tdpa(), up, down, 14.0)
    after = result[1900 : round(end / PERIOD), X_S]
    if after.size:
        assert np.ptp(after) < 2e-3
    assert abs(np.diff(result[:, X_S])).max() / PERIOD < 0.35
    assert abs(result[:, F_M]).max() < 40.0
    assert abs(result[-500:, X_M] - result[-500:, X_S]).max() < 1e-3


def test_wrong_fields_are_named() -> None:
    with pytest.raises(ValueError, match=r"c\.reserve: -1\.0, allowed 0 to 100"):
        check(Tdpa(reserve=-1.0), "c")
    with pytest.raises(ValueError, match=r"c\.horizon: 0\.0, allowed 0\.002 to 1"):
        check(Tdpa(horizon=0.0), "c")
