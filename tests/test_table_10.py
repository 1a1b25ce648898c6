"""Table 10: its numbers against closed forms, and how it judges."""

import functools

import numpy as np
import pytest

from scara_drake.experiments.claim import IN_KIND, NOT_COMPARABLE, NOT_REPRODUCED, REPRODUCED
from scara_drake.experiments.control import table_10
from scara_drake.experiments.quantity import text


@functools.cache
def experiment():
    return table_10.run()


def at(name, law, disturbance):
    return float(experiment().data[name].sel(law=law, disturbance=disturbance))


def verdicts(claims):
    return [claim.verdict for claim in claims]


def test_data_are_labelled_and_the_same_for_a_seed():
    data = experiment().data
    assert all({"units", "long_name"} <= set(v.attrs) for v in data.data_vars.values())
    assert data.identical(table_10.run().data)
    assert data.x.dims == ("law", "disturbance", "time")
    for claim in experiment().claims:
        assert len(claim.reason) > 30
        assert "nan" not in text(claim.measured) + claim.reason
        assert "inf" not in text(claim.measured) + claim.reason


def test_both_laws_have_the_times_of_the_sliding_motion_without_disturbance():
    for law in ("ISMC", "SMC"):
        assert at("rise_time", law, "none") == pytest.approx(np.log(10.0), rel=0.03)
        assert at("settling_time", law, "none") == pytest.approx(np.log(100.0), rel=0.03)


@pytest.mark.parametrize(("disturbance", "d"), [("constant", -10.0), ("constant, light", -3.75)])
def test_a_constant_leaves_smc_an_error_and_ismc_none(disturbance, d):
    # phi d / (rho c), on the side to which it pushes
    assert at("steady_error", "SMC", disturbance) == pytest.approx(-d / 700.0, rel=0.01)
    assert at("steady_error", "ISMC", disturbance) == pytest.approx(0.0, abs=1e-4)


def test_the_light_constant_gives_the_paper_s_row_of_smc():
    # x = 1 - (1 + g) e^-t + g with g = d / 700, from which the paper's two times say what d is.
    for paper, level in ((2.36, 0.9), (5.35, 0.99)):
        g = (level - 1.0 + np.exp(-paper)) / (1.0 - np.exp(-paper))
        assert 700.0 * g == pytest.approx(-3.75, abs=0.8)
    assert at("rise_time", "SMC", "constant, light") == pytest.approx(2.36, rel=0.01)
    assert at("settling_time", "SMC", "constant, light") == pytest.approx(5.35, rel=0.01)
    assert at("late_error", "SMC", "constant, light") < 0.01


@pytest.mark.parametrize(("disturbance", "omega"), [("slow sine", 2.0), ("fast sine", 20.0)])
def test_sines_leave_what_the_linear_laws_in_the_layer_let_through(disturbance, omega):
    # SMC: d / ((p + 700) (p + 1)); ISMC with k = rho / phi = 50: p d / ((p + 50)² (p + 1)).
    p = 1j * omega
    smc = abs(10.0 / ((p + 700.0) * (p + 1.0)))
    ismc = abs(10.0 * p / ((p + 50.0) ** 2 * (p + 1.0)))
    assert at("late_error", "SMC", disturbance) == pytest.approx(smc, rel=0.03)
    assert at("late_error", "ISMC", disturbance) == pytest.approx(ismc, rel=0.05)


def test_the_gains_are_free_of_chatter_at_this_period():
    # ISMC: (rho / phi + k) T_s = 0.1, SMC: 0.7, both below 1.
    assert (experiment().data.effort_variation < 500.0).all()
    assert at("largest_effort", "SMC", "none") == pytest.approx(700.0)
    assert at("largest_effort", "ISMC", "none") == pytest.approx(50.0)


def test_verdicts():
    assert verdicts(experiment().claims) == [
        REPRODUCED, IN_KIND, IN_KIND, IN_KIND, IN_KIND, IN_KIND, NOT_COMPARABLE, REPRODUCED,
    ]  # fmt: skip
    settles = experiment().claims[4]
    assert settles.reason.endswith(
        "under: slow sine; fast sine. The disturbance decides the order."
    )
    assert "ISMC 4.63 s, SMC never (constant)" in text(settles.measured)


def test_it_judges_what_it_is_given():
    data = experiment().data.copy(deep=True)
    smc = {"law": "SMC"}
    data.settling_time.loc[smc] = 5.35
    data.rise_time.loc[smc] = 2.36
    data.settling_time.loc[{"law": "ISMC"}] = 4.65
    data.late_error[:] = 0.0
    data.x.loc[{**smc, "disturbance": "fast sine"}] += 0.1
    assert verdicts(table_10.claims(data))[:6] == [REPRODUCED] * 6
    data.rise_time[:] = 1.0
    data.settling_time[:] = np.nan
    data.late_error[:] = 1.0
    data.x.loc[{"law": "ISMC", "disturbance": list(data.disturbance.values[1:])}] += 1.0
    claims = table_10.claims(data)
    assert verdicts(claims)[:6] == [NOT_REPRODUCED] * 6
    assert verdicts(claims)[7] == NOT_REPRODUCED
    assert "nan" not in "".join(text(claim.measured) for claim in claims)
