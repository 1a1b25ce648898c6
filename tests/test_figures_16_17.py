"""Figures 16 and 17: the mast at rest against its weight, and how it is judged."""

import functools

import numpy as np
import pytest
from kinds import of_kind

from scara_drake.control.integral_sliding_mode import IntegralSlidingMode
from scara_drake.experiments.claim import IN_KIND, NOT_COMPARABLE, NOT_REPRODUCED, REPRODUCED
from scara_drake.experiments.control import figures_16_17 as figures
from scara_drake.experiments.quantity import text
from scara_drake.scenario import load_scenario

PLAIN, RAW, HEAVY = list(figures.RUNS)[:3]


@functools.cache
def experiment():
    return figures.run()


def error(name):
    data = experiment().data.sel(run=name)
    return data.q_desired - data.q_measured


def verdicts(claims):
    return [claim.verdict for claim in claims]


def test_data_are_labelled():
    data = experiment().data
    for variable in data.data_vars.values():
        assert {"units", "long_name"} <= set(variable.attrs)
        assert np.isfinite(variable).all()


def test_the_gains_of_the_closed_form_are_those_that_ran():
    gains = of_kind(IntegralSlidingMode, load_scenario(figures.SCENARIO).controller)
    assert (gains.k[0], gains.c[0], gains.rho[0]) == (figures.K, figures.C, figures.RHO)


@pytest.mark.parametrize(("name", "mass"), [(RAW, 735.5), (HEAVY, 1.3 * 735.5)])
def test_in_mm_and_n_the_mast_hangs_where_the_law_holds_its_weight(name, mass):
    # 300 N of rho, and 150 * 50 N for each mm; before the move and after it.
    expected = 1e-3 * (mass * 9.81 - 300.0) / 7500.0
    still = error(name)
    for t in (0.9, 7.9):
        assert float(still.sel(time=t, method="nearest")) == pytest.approx(expected, rel=1e-3)


def test_the_integral_holds_the_weight_where_u_is_an_acceleration():
    late = error(PLAIN).sel(time=slice(1.0, None))
    assert abs(late).max() < 1e-5
    assert abs(late[-1]) < 1e-9


def test_the_drive_holds_the_weight_at_rest():
    force = experiment().data.tau.sel(time=7.9, method="nearest")
    weight = 735.5 * 9.81
    np.testing.assert_allclose(
        force, [weight, weight, 1.3 * weight, 1.3 * weight, 0.7 * weight], rtol=1e-3
    )


def test_the_reference_is_the_minimum_jerk_polynomial():
    q = experiment().data.q_desired.isel(run=0)
    assert float(q[0]) == 3.0
    assert float(q.sel(time=3.0, method="nearest")) == pytest.approx(3.25)
    assert float(q.sel(time=2.0, method="nearest")) == pytest.approx(3.0 + 0.5 * 0.103515625)
    assert float(q[-1]) == pytest.approx(3.5)


def test_verdicts():
    assert verdicts(experiment().claims) == [
        REPRODUCED, IN_KIND, REPRODUCED, REPRODUCED, NOT_COMPARABLE,
    ]  # fmt: skip
    assert "0.922 mm (in mm and N)" in text(experiment().claims[1].measured)


def test_it_judges_what_it_is_given():
    data = experiment().data.copy(deep=True)
    data.q_measured.loc[{"run": RAW}] = data.q_desired.sel(run=RAW) - 1.9e-3
    assert verdicts(figures.claims(data))[:3] == [REPRODUCED, REPRODUCED, NOT_REPRODUCED]
    data.q_measured[:] = data.q_desired - 0.3e-3
    assert verdicts(figures.claims(data))[1:4] == [NOT_REPRODUCED] * 3
    data.q_measured.loc[{"run": HEAVY}] = data.q_desired.sel(run=HEAVY) - 5e-3
    assert verdicts(figures.claims(data))[:3] == [IN_KIND, NOT_REPRODUCED, IN_KIND]
    data.q_measured.loc[{"run": "normalised"}] = data.q_desired.sel(run="normalised")
    assert verdicts(figures.claims(data))[3] == IN_KIND
    data.q_measured[:] = data.q_desired - 5e-3
    assert verdicts(figures.claims(data))[0] == NOT_REPRODUCED
