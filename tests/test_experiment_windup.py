from functools import lru_cache

import numpy as np
import pytest

from scara_drake.control.integral_sliding_mode import IntegralSlidingMode
from scara_drake.experiments.claim import NOT_REPRODUCED, OURS, REPRODUCED
from scara_drake.experiments.control import windup
from scara_drake.experiments.quantity import text


@lru_cache
def result():
    return windup.run()


def test_data_are_labelled_and_the_run_repeats_to_the_bit():
    data = result().data
    for variable in data.data_vars.values():
        assert {"units", "long_name"} <= variable.attrs.keys()
    assert data.attrs["seed"] == 0
    assert windup.run().data.identical(data)


def test_the_joints_are_pushed_away_as_far_as_the_law_gives_way():
    # Outside its layer the law holds rho + k c e of the push: e = (d - rho) / (k c).
    gains = IntegralSlidingMode()
    rho, k, c = (np.array(gain) for gain in (gains.rho, gains.k, gains.c))
    pushed = result().data.deviation.sel(time=windup.PUSH[1], method="nearest")
    expected = (windup.EXCESS * rho - rho) / (k * c)
    for which in windup.CLAMPS:
        np.testing.assert_allclose(pushed.sel(anti_windup=which), expected, rtol=0.03)


def test_a_clamped_joint_is_back_at_once_and_one_without_when_its_integral_is():
    recovery = windup.recovery_time(result().data)
    assert (recovery.sel(anti_windup="clamp") < 0.8).all()
    # Pushed for 3 s with k sigma = rho, the sum takes 3 s with k sigma = -rho to unwind.
    wound = recovery.sel(anti_windup="no clamp")
    assert (wound > 3.0).all()
    assert (wound < 3.6).all()


def test_without_the_clamp_a_joint_overshoots_by_as_much_as_it_was_pushed():
    deviation = result().data.deviation
    share = -deviation.min("time") / deviation.max("time")
    np.testing.assert_allclose(share.sel(anti_windup="no clamp"), 1.0, atol=0.05)
    assert (share.sel(anti_windup="clamp") < 0.15).all()


def test_only_the_governor_ends_the_overshoot_of_limited_drives():
    data = result().data
    passed = windup.overshoot(data)
    none, clamp, governor = (passed.sel(protection=name) for name in windup.PROTECTIONS)
    assert (none > clamp).all()
    assert (clamp > 0.05).all()
    assert (governor < 0.01).all()
    arrived = data.q.isel(time=-1).sel(protection="clamp and governor")
    np.testing.assert_allclose(arrived, windup.DISPLACEMENT, atol=1e-6)


def test_the_motion_asks_for_twice_what_the_drives_give():
    time = 1e-5 * np.arange(200000, dtype=float)
    velocity = windup._reference(time)[:, 6:]
    peak = np.abs(np.diff(velocity, axis=0)).max(axis=0) / 1e-5
    np.testing.assert_allclose(peak, windup.DEMAND * windup._drives(), rtol=1e-3)


@pytest.mark.parametrize("governed", [True, False])
def test_a_motion_within_the_limits_is_the_same_with_and_without_the_governor(governed):
    time = windup.PERIOD * np.arange(1500, dtype=float)
    reference = windup._reference(0.5 * time)
    reference[:, 6:] *= 0.5
    motion = windup.motion(reference, windup._gains(True, windup._drives()), governed)
    free = windup.motion(reference, windup._gains(True, np.inf), False)
    np.testing.assert_array_equal(motion, free)


def test_claims_carry_their_evidence():
    for claim in result().claims:
        assert (claim.source, claim.verdict) == (OURS, REPRODUCED)
        assert claim.paper is None
        assert "nan" not in text(claim.measured)


@pytest.mark.parametrize(
    ("variable", "where", "value", "claim"),
    [
        ("deviation", {"anti_windup": "clamp"}, 1.0, 0),  # never back
        ("deviation", {"anti_windup": "no clamp"}, 0.0, 0),  # back at once without
        ("q", {"protection": "clamp and governor"}, 1.1, 1),  # beyond the goal with the governor
        ("q", {"protection": "clamp"}, 1.0, 1),  # not beyond it without
    ],
)
def test_it_judges_what_it_is_given(variable, where, value, claim):
    data = result().data.copy(deep=True)
    data[variable].loc[where] = value
    judged = [each.verdict for each in windup.claims(data)]
    assert judged[claim] == NOT_REPRODUCED
    assert judged[1 - claim] == REPRODUCED


def test_the_sentences_carry_what_was_measured():
    data = result().data.copy(deep=True)
    data.q.loc[{"protection": "clamp"}] -= 0.5
    before, after = (windup.claims(each) for each in (result().data, data))
    assert before[1].reason != after[1].reason
