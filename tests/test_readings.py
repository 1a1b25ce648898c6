"""What hangs on a reading stands beside other readings; each verdict comes from the data."""

from typing import Any

import numpy as np
import pytest
from small_experiments import small
from test_control_verdicts import changed

from scara_drake.experiments import NOT_COMPARABLE, VERDICTS, report
from scara_drake.experiments.control import (
    figures_16_17,
    figures_18_19,
    figures_29_30,
    table_10,
)
from scara_drake.experiments.inverse_kinematics import figures_10_11, table_5, table_6, table_8
from scara_drake.experiments.quantity import text
from scara_drake.experiments.teleoperation import figure_28, figures_20_27

ASKED: dict[str, Any] = {
    "table_5": table_5,
    "table_6": table_6,
    "table_8": table_8,
    "figures_10_11": figures_10_11,
    "table_10": table_10,
    "figures_16_17": figures_16_17,
    "figures_18_19": figures_18_19,
    "figures_20_27": figures_20_27,
    "figure_28": figure_28,
    "figures_29_30": figures_29_30,
}
each = pytest.mark.parametrize("name", ASKED)


@each
def test_a_question_is_one_table_and_its_claim_has_the_verdict_of_our_reading(name):
    experiment = small(name)
    verdicts = {claim.statement: claim.verdict for claim in experiment.claims}
    assert experiment.questions
    for question in experiment.questions:
        table = report.reading_table(question)
        assert len(table) == len(question.readings) >= 2
        assert "nan" not in table.to_string()
        assert set(table.verdict) <= set(VERDICTS) - {NOT_COMPARABLE}
        assert len(set(table.reading)) == len(table)
        chosen = next(reading for reading in question.readings if reading.chosen)
        assert verdicts[question.claim] == chosen.verdict
        shown = [tuple(map(text, r.consequences.values())) for r in question.readings]
        assert len(set(shown)) > 1  # a reading that changes nothing would be none


def thinned(data):
    """Fewer samples, which decide as well and are judged sooner."""
    return data.isel(
        {dim: slice(None, None, 50) for dim in ("time", "raw_time") if dim in data.dims}
    )


def verdicts_of(questions):
    return {(q.question, r.name): r.verdict for q in questions for r in q.readings}


@each
def test_other_data_give_another_verdict_under_each_reading(name):
    experiment = small(name)
    seen = {key: {verdict} for key, verdict in verdicts_of(experiment.questions).items()}
    stuck = list(seen)
    with np.errstate(all="ignore"):
        for data in changed(thinned(experiment.data)):
            for key, verdict in verdicts_of(ASKED[name].questions(data)).items():
                seen[key].add(verdict)
            stuck = [key for key, verdicts in seen.items() if len(verdicts) == 1]
            if not stuck:
                break
    assert stuck == []
