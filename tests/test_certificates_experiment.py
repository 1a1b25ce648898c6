"""The table of certificates: its data, and how they are judged."""

from __future__ import annotations

import numpy as np
import pytest
from small_experiments import small

from scara_drake.experiments import REPRODUCED, Experiment
from scara_drake.experiments.literature import certificates


def experiment() -> Experiment:
    return small("certificates")


def test_verdicts() -> None:
    assert [claim.verdict for claim in experiment().claims] == [REPRODUCED] * 3


def test_it_judges_what_it_is_given() -> None:
    data = experiment().data
    for name, factor, met in (
        ("proven", 1.02, [False, True, True]),
        ("proven", 0.9, [True, False, True]),
        ("proven_varying", 2.0, [True, False, True]),
        ("absolute", 0.5**0.5, [True, True, False]),
    ):
        changed = data.assign({name: data[name] * factor})
        judged = certificates.claims(changed)
        assert [claim.verdict == REPRODUCED for claim in judged] == met
    arm = data.assign(seen_with_arm=("case", np.array([0.005, np.inf])))
    assert certificates.claims(arm)[0].verdict != REPRODUCED
    assert certificates.claims(data)[0].verdict == REPRODUCED


def test_there_is_no_loop_where_nothing_comes_back() -> None:
    data = experiment().data
    assert np.isnan(data.proven.sel(case="direct, force x 0.03", contact="free"))
    assert (data.proven.sel(case="waves") == np.inf).all()


@pytest.mark.slow
def test_the_arm_turns_over_behind_what_is_proven() -> None:
    found = certificates.run(cases={"d": "!ScaledForce {force_scale: 0.03}"}, longest=40)
    assert found.data.proven.min() < found.data.seen_with_arm[0] < 0.02
    assert found.claims[0].verdict == REPRODUCED
