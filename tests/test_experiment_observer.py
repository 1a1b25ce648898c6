"""The observer's experiment: where it pays, and how the claims judge what they are given."""

import functools

import numpy as np
import pytest
from kinds import of_kind

from scara_drake.experiments.claim import NOT_COMPARABLE, NOT_REPRODUCED, PAPER, REPRODUCED
from scara_drake.experiments.control import perturbation_observer as study
from scara_drake.experiments.quantity import Quantity, parts, text


@functools.cache
def experiment():
    return study.run(contact_duration=24.0)


def test_the_data_are_labelled_and_the_claims_say_why():
    result = experiment()
    for name, values in result.data.data_vars.items():
        assert values.attrs["units"], name
        assert values.attrs["long_name"], name
        assert np.isfinite(values).all(), name
    for claim in result.claims:
        assert claim.paper is None  # the paper gives no number
        assert (claim.verdict == NOT_COMPARABLE) == (claim.source == PAPER)
        assert "future work" in claim.statement
        assert len(claim.reason) > 30
        assert "nan" not in text(claim.measured) + claim.reason
    assert [claim.verdict for claim in result.claims[::3]] == [REPRODUCED, REPRODUCED]


@pytest.mark.parametrize("case", ["weak", "weak, 3 m_hat", "weak, m_hat / 3"])
def test_with_weak_gains_it_errs_five_times_less_with_a_quarter_of_rho(case):
    rmse = experiment().data.rmse.sel(case=case)
    assert rmse.sel(law=study.PLAIN) >= 5.0 * rmse.sel(law=study.OBSERVER)
    variation = experiment().data.total_variation.sel(case=case)
    assert variation.sel(law=study.OBSERVER) <= 1.01 * variation.sel(law=study.PLAIN)


def test_with_the_gains_of_table_12_it_does_not_pay_but_is_quiet():
    data = experiment().data
    strong = [str(name) for name in data.case.values if str(name).startswith("Table 12")]
    rmse, variation = data.rmse.sel(case=strong), data.total_variation
    assert (rmse.sel(law=study.OBSERVER) > rmse.sel(law=study.PLAIN)).all()
    noisy = variation.sel(case="Table 12, noise")
    assert noisy.sel(law=study.OBSERVER) < 0.5 * noisy.sel(law=study.PLAIN)


def test_a_fast_observer_is_noisier_than_the_law_without():
    variation = experiment().data.total_variation
    fast = variation.sel(case="weak, noise, pole 500", law=study.OBSERVER)
    assert fast > variation.sel(case="weak, noise, pole 500", law=study.PLAIN)
    assert fast > variation.sel(case="weak, noise", law=study.OBSERVER)


def test_plain_ismc_errs_by_its_closed_form_where_it_does_not_saturate():
    # In the layer s' = Psi - rho s / phi - ..., so the error's amplitude over the perturbation's is
    # |G(jw)| with G = s / ((s + c) (s² + (k + rho) s + k rho)), phi = m_hat = 1; the reference's
    # acceleration is a perturbation too.
    case = study.CASES["Table 12"]
    rho = case.rho[0]

    def amplitude(size, w):
        s = 1j * w
        return size * abs(s / ((s + case.c) * (s**2 + (case.k + rho) * s + case.k * rho)))

    expected = np.hypot(amplitude(*study.PERTURBATION), amplitude(*study.REFERENCE)) / np.sqrt(2)
    rmse = experiment().data.rmse.sel(case="Table 12", law=study.PLAIN)
    assert float(rmse) == pytest.approx(expected, rel=0.1)


def test_the_contact_force_is_within_a_tenth_in_steady_pressing():
    error = study.contact_error(experiment().data)
    assert int(error.notnull().sum()) > 50
    assert float(error.max()) <= 0.1


def test_a_seed_gives_the_same_noise():
    small = {"duration": 1.5, "contact_duration": 0.02}
    first, again, other = (study.run(seed, **small).data.total_variation for seed in (0, 0, 1))
    np.testing.assert_array_equal(first, again)
    assert (first != other).sel(case="Table 12, noise").all()


def test_it_judges_what_it_is_given():
    data = experiment().data.copy(deep=True)
    data.rmse.loc[{"law": study.OBSERVER}] = data.rmse.sel(law=study.PLAIN).values / 100.0
    claims = study.claims(data)
    assert [claims[0].verdict, claims[3].verdict] == [REPRODUCED] * 2
    data.rmse.loc[{"law": study.OBSERVER}] = data.rmse.sel(law=study.PLAIN).values / 2.0
    data.force_estimated[:] = 1.2 * data.force
    claims = study.claims(data)
    assert str(claims[0].measured) == "2 times lower RMSE"
    assert claims[0].verdict == NOT_REPRODUCED
    assert "Table 12, 3 m_hat" in claims[1].reason
    force = of_kind(Quantity, parts(claims[3].measured)[0])
    assert force.values == (pytest.approx(20.0),)
    assert force.unit == "%"
    assert claims[3].verdict == NOT_REPRODUCED
    assert study.free_error(data) == 0.0
    data.force[:] = 0.0
    assert "no steady contact" in text(study.claims(data)[3].measured)
    assert study.claims(data)[3].verdict == NOT_REPRODUCED


def test_steady_needs_half_a_second_without_a_change():
    data = experiment().data.copy(deep=True)
    data.force[:] = 0.0
    late = data.time >= 10.0
    data.force[:, 1] = np.where(late, 100.0, 0.0)
    data.force[data.time.values >= 15.0, 1] = 150.0
    steady = study.steady(data)
    first = float(data.time[steady.values][0])
    assert first == pytest.approx(10.0 + study.STEADY, abs=0.02)
    assert not steady.sel(time=15.2, method="nearest")
    assert steady.sel(time=15.6, method="nearest")
