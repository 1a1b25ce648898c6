"""Figures 29 and 30: the readings of the control-process delay, and how they are judged."""

import functools
import math

import numpy as np
import pytest

from scara_drake import joints, robot
from scara_drake.experiments.claim import (
    IN_KIND,
    NOT_COMPARABLE,
    NOT_REPRODUCED,
    REPRODUCED,
    VERDICTS,
)
from scara_drake.experiments.control import figures_29_30 as figures
from scara_drake.experiments.quantity import text


@functools.cache
def experiment():
    return figures.run()


def verdicts(claims):
    return [claim.verdict for claim in claims]


def test_the_data_are_labelled_and_the_claims_say_why():
    result = experiment()
    for name, values in result.data.data_vars.items():
        assert values.attrs["units"], name
        assert values.attrs["long_name"], name
        assert np.isfinite(values).all(), name
    assert set(result.data.reading.values) == {*figures.READINGS, figures.ALONE}
    for claim in result.claims:
        assert claim.verdict in VERDICTS
        assert len(claim.reason) > 30
        assert "nan" not in text(claim.measured) + claim.reason


def test_a_joint_alone_errs_by_what_the_laws_leave():
    # In the boundary layer SMC leaves phi d / (rho c), and ISMC phi d' / (rho k c).
    error = figures.largest_error(experiment().data).sel(reading=figures.ALONE)
    peak = 100 * math.sqrt(2)
    assert error.sel(controller="SMC") == pytest.approx(peak / (150 * 50), rel=0.02)
    assert error.sel(controller="SMC, high gain") == pytest.approx(peak / (700 * 50), rel=0.02)
    assert error.sel(controller="ISMC") == pytest.approx(peak / (150 * 100 * 50), rel=0.05)


def test_the_effort_of_a_joint_alone_meets_the_perturbation():
    alone = experiment().data.sel(reading=figures.ALONE, controller="ISMC")
    t = alone.time.values
    motion = -0.7854 * 1.25**2 * np.sin(1.25 * t)
    u = motion - 100 * np.sin(t) - 100 * np.cos(t)
    wanted = robot.nominal_inertias()[1] * u
    late = t > 0.2
    np.testing.assert_allclose(
        alone.tau[late], wanted[late], atol=1.0 * robot.nominal_inertias()[1]
    )


def test_without_delay_both_track():
    error = figures.largest_error(experiment().data).sel(reading="none")
    assert (error < 1e-3).all()


def test_the_reduced_perturbation_uses_the_drive_up_to_the_paper_s_share():
    data = experiment().data.sel(reading="B reduced", time=slice(figures.START, None))
    share = abs(data.tau).max("time") / joints.EFFORT[1]
    assert ((share > 0.9) & (share < 1.0)).all()
    error = figures.largest_error(experiment().data).sel(reading="B reduced")
    assert error.sel(controller="ISMC") < 1e-3 < error.sel(controller="SMC, high gain")


def test_the_command_path_delays_both_alike():
    # The error is the way within the delay: at most 0.98 rad/s × 100 ms.
    data = experiment().data.sel(reading=["C"])
    error = figures.largest_error(data)
    assert (error > 0.05).all()
    assert (error < 0.098).all()
    assert float(error.max() - error.min()) < 1e-3
    assert ((figures.lag(data) > 0.01) & (figures.lag(data) < 0.1)).all()


@pytest.mark.parametrize("reading", ["A", "B"])
def test_readings_beyond_the_loop_or_the_drive_are_lost(reading):
    assert (figures.largest_error(experiment().data).sel(reading=reading) > 1.0).all()


def test_verdicts():
    assert verdicts(experiment().claims) == [
        IN_KIND, IN_KIND, IN_KIND, NOT_REPRODUCED, NOT_COMPARABLE,
    ]  # fmt: skip


def ideal():
    data = experiment().data.copy(deep=True)
    data.q_measured[:] = data.q_desired
    return data


def test_it_judges_what_it_is_given():
    data = ideal()
    data.q_measured[:] = data.q_measured + 1e-6
    assert verdicts(figures.claims(data)) == [
        REPRODUCED, NOT_REPRODUCED, NOT_REPRODUCED, NOT_REPRODUCED, NOT_COMPARABLE,
    ]  # fmt: skip
    window = {"reading": "C", "time": slice(3.0, 4.0)}
    data.q_measured.loc[{"controller": "ISMC", **window}] += 2e-3
    late = data.q_desired.shift(time=30, fill_value=0.0)
    data.q_measured.loc[{"controller": "SMC, high gain", "reading": "C"}] = 0.9 * late
    assert verdicts(figures.claims(data))[:4] == [REPRODUCED] * 4
    assert "in that window: C" in text(figures.claims(data)[3].measured)
    data.q_measured.loc[{"controller": "ISMC", "reading": ["A", "B", "C"]}] += 0.1
    assert verdicts(figures.claims(data))[0] == IN_KIND  # by the reduced one and the joint alone
    data.q_measured.loc[{"controller": "ISMC"}] += 0.1
    assert verdicts(figures.claims(data))[0] == NOT_REPRODUCED
    data.q_measured[:] = 9.0
    assert verdicts(figures.claims(data))[:4] == [NOT_REPRODUCED] * 4


@pytest.mark.parametrize("ticks", [0, 5, 50])
def test_lag_is_found(ticks):
    data = ideal()
    data.q_measured[:] = data.q_desired.shift(time=ticks, fill_value=0.0)
    np.testing.assert_allclose(figures.lag(data), ticks * 1e-3, atol=1e-9)


def test_undershoot_is_what_lacks_at_the_turns():
    data = ideal()
    data.q_measured[:] = 0.9 * data.q_desired
    np.testing.assert_allclose(figures.undershoot(data), 0.1, atol=1e-4)
    data.q_measured[:] = 1.1 * data.q_desired
    np.testing.assert_allclose(figures.undershoot(data), 0.0)
