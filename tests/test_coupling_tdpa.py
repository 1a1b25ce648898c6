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
    energy_left,
)
from hypothesis import assume, given
from hypothesis import strategies as st
from strategies import examples
from strategies.channels import Conditions, conditions
from strategies.hands import BRISK, hands, to_and_fro

from scara_drake.common.fields import check
from scara_drake.coupling.direct import Direct
from scara_drake.coupling.tdpa import DOWN, UP, Tdpa
from scara_drake.operator.master import Master

DURATION = 6.0
STEPS = round(DURATION / PERIOD)


@examples(200)
@given(
    hand=hands(DURATION),
    up=conditions(),
    down=conditions(),
    reserve=st.floats(0.005, 0.1),
    force_scale=st.sampled_from([1.0, 0.3, 0.1]),
    stiffness=st.sampled_from([500.0, 1000.0, 4000.0]),
    limit=st.sampled_from([5.0, 40.0, np.inf]),
)
def test_no_end_gives_more_than_has_come_in(
    hand: Master,
    up: Conditions,
    down: Conditions,
    reserve: float,
    force_scale: float,
    stiffness: float,
    limit: float,
) -> None:
    coupling = Tdpa(reserve=reserve, force_scale=force_scale, stiffness=stiffness)
    result = Rig(master=hand, limit=limit).run(
        coupling, up.shown(STEPS), down.shown(STEPS), DURATION, UP.slices["e_in"],
        DOWN.slices["e_in"],
    )  # fmt: skip
    # The bound is for hands of that kind; against a stiff wall a brisk one may not be.
    assume(abs(np.diff(result[:, X_M], 2)).max() < coupling.turn * PERIOD**2)
    # What has arrived so far, at best; the energies at the device are exact, see test_master.
    arrived_s = np.maximum.accumulate(result[:, RX_S])
    arrived_m = np.maximum.accumulate(result[:, RX_M])
    assert np.all(result[:, E_OUT_S] <= arrived_s + reserve + 1e-12)
    assert np.all(result[:, E_OUT_M] <= arrived_m + reserve + 1e-12)
    assert energy_left(result).min() + coupling.reserves() >= -1e-12


@pytest.mark.parametrize("motion", BRISK)
def test_a_brisk_hand_takes_no_more_than_the_reserve(motion: tuple[float, float]) -> None:
    up, down = (Conditions(spread=0.3, loss=0.3, seed=seed).shown(STEPS) for seed in (1, 2))
    rig = Rig(master=to_and_fro(*motion, DURATION))
    result = rig.run(Tdpa(), up, down, DURATION, UP.slices["e_in"], DOWN.slices["e_in"])
    taken = result[:, E_OUT_M] - np.maximum.accumulate(result[:, RX_M])
    assert taken.max() <= Tdpa().reserve + 1e-12
    assert energy_left(result).min() + Tdpa().reserves() >= -1e-12
    assert abs(result[:, F_M]).max() > 3.0  # it is felt


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
