"""Equations (48) to (51): the evidence, and how it is judged."""

from typing import Any

import numpy as np
import pytest
from small_experiments import SMALL, small

from scara_drake.experiments.claim import (
    IN_KIND,
    NOT_COMPARABLE,
    NOT_REPRODUCED,
    REPRODUCED,
    VERDICTS,
)
from scara_drake.experiments.control import stability
from scara_drake.experiments.quantity import text

OTHER: dict[str, Any] = SMALL["stability"] | {"variations": {"nominal": {}}}


def experiment():
    return small("stability")


def verdicts(data):
    return [claim.verdict for claim in stability.claims(data)]


def test_the_data_are_labelled_and_the_claims_complete():
    result = experiment()
    for name, values in result.data.data_vars.items():
        assert values.attrs["units"], name
        assert values.attrs["long_name"], name
    assert result.data.attrs["seed"] == 0
    for claim in result.claims:
        assert claim.verdict in VERDICTS
        assert all([claim.statement, text(claim.paper), text(claim.measured), claim.reason])
        assert "nan" not in text(claim.measured) + claim.reason


def test_verdicts():
    assert verdicts(experiment().data) == [
        IN_KIND, IN_KIND, IN_KIND, REPRODUCED, REPRODUCED, NOT_COMPARABLE,
    ]  # fmt: skip


def ideal():
    data = experiment().data.copy(deep=True)
    data.share_rising_inside[:] = 0.0
    data.used[:] = 0.5
    data.excursion[:] = 0.5
    return data


def test_it_judges_what_it_is_given():
    data = ideal()
    assert verdicts(data)[:5] == [REPRODUCED] * 5
    data.used_late[:], data.used[:] = 1.5, 1.5
    data.s_start[:] = 0.1
    data.gravity_share[0, 0, 0] = 2.0
    data.peak.loc[{"variation": "payload 25 kg", "joint": "d1"}] = 3e-3
    assert verdicts(data)[1:5] == [NOT_REPRODUCED, NOT_REPRODUCED, IN_KIND, IN_KIND]
    data.pole_real[0, 0, 0] = 1e-3
    data.stable.loc[{"variation": "payload 25 kg"}] = False
    assert verdicts(data)[3:5] == [NOT_REPRODUCED, NOT_REPRODUCED]


@pytest.mark.parametrize("broken", ["share_decreasing", "within_bound"])
def test_v_that_rises_outside_or_a_bound_that_is_broken_is_seen(broken):
    data = experiment().data.copy(deep=True)
    data[broken][:] = 0.5 if broken == "share_decreasing" else False
    assert verdicts(data)[0] == NOT_REPRODUCED


def test_another_seed_takes_other_postures():
    other = stability.run(seed=1, **OTHER).data
    assert not np.array_equal(other.q, experiment().data.q)
    assert np.array_equal(other.delay_onset, experiment().data.delay_onset)
