"""What hangs on a reading stands beside other readings; each verdict comes from the data."""

from typing import Any

import numpy as np
import pytest
import xarray as xr
from small_experiments import small

from scara_drake.experiments import (
    IN_KIND,
    NOT_COMPARABLE,
    NOT_REPRODUCED,
    REPRODUCED,
    VERDICTS,
    report,
)
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
        rows = [report.reading_row(reading) for reading in question.readings]
        assert len(rows) >= 2
        assert "nan" not in str(rows)
        assert {reading.verdict for reading in question.readings} <= {*VERDICTS} - {NOT_COMPARABLE}
        assert len({name for name, *_ in rows}) == len(rows)
        chosen = next(reading for reading in question.readings if reading.chosen)
        assert verdicts[question.claim] == chosen.verdict
        shown = [tuple(map(text, r.consequences.values())) for r in question.readings]
        assert len(set(shown)) > 1  # a reading that changes nothing would be none


ORDERS = ("order_position_error", "order_rotation_error", "order_free_position_error",
          "order_free_rotation_error")  # fmt: skip
BOTH = ("position_error", "rotation_error", "angle_difference")
# Data by which every reading meets its claim, and by which none does: variables, and their values.
MET: dict[str, dict[str, Any]] = {
    "table_5": dict.fromkeys((*BOTH, *ORDERS), 0.0),
    "table_6": {"position_error": 0.0, "literal_position_error": 0.0} | dict.fromkeys(
        ("rotation_error", "literal_rotation_error", "angle_difference"), 2.0
    ),
    "table_8": dict.fromkeys((*BOTH, "arm_position_error", "arm_rotation_error"), 0.0),
    "figures_10_11": {"position_error": 0.0},
    "table_10": {
        "settling_time": np.array([[4.65], [5.35]]),  # of ISMC, of SMC
        "pair_rise_time": 2.31,
        "pair_settling_time": 4.65,
    },
    "figures_16_17": {
        "q_measured": lambda data: data.q_desired - 2e-3, "error_in_metres": 2e-3,
    },
    "figures_18_19": {
        "q_measured": lambda data: data.q_desired,
        "q_raw": lambda data: data.q_desired.sel(run="nominal"),
    },
    "figures_20_27": {
        "tool_error": 0.0, "delay_error": 0.0, "q_measured": lambda data: data.q_desired - 2e-3,
    },
    "figure_28": {"delay": 2.0},
    "figures_29_30": {"q_measured": lambda data: data.q_desired + 1e-6},
}  # fmt: skip
LOST: dict[str, dict[str, Any]] = {
    "table_5": dict.fromkeys(MET["table_5"], 1.0),
    "table_6": {"position_error": 1.0, "literal_position_error": 1.0} | dict.fromkeys(
        ("rotation_error", "literal_rotation_error", "angle_difference"), 0.0
    ),
    "table_8": dict.fromkeys(MET["table_8"], 1.0),
    "figures_10_11": {"position_error": 1.0},
    "table_10": {
        "settling_time": np.array([[5.35], [4.65]]),
        "pair_rise_time": 9.0,
        "pair_settling_time": 9.0,
    },
    "figures_16_17": {"q_measured": lambda data: data.q_desired, "error_in_metres": 0.0},
    "figures_18_19": {
        "q_measured": lambda data: data.q_desired + 1.0,
        "q_raw": lambda data: data.q_desired.sel(run="nominal") + 1.0,
    },
    "figures_20_27": {
        "tool_error": 1.0, "delay_error": 1.0, "q_measured": lambda data: data.q_desired,
    },
    "figure_28": {"delay": 0.2},
    "figures_29_30": {"q_measured": 9.0},
}  # fmt: skip


def verdicts_under(name, values):
    data = small(name).data.copy(deep=True)
    for variable, value in values.items():
        new = value(data) if callable(value) else value
        data[variable].values[...] = new.values if isinstance(new, xr.DataArray) else new
    with np.errstate(all="ignore"):
        questions = ASKED[name].questions(data)
    return {(q.question, r.name): r.verdict for q in questions for r in q.readings}


@each
def test_the_data_decide_the_verdict_under_each_reading(name):
    met = verdicts_under(name, MET[name])
    assert {key for key, verdict in met.items() if verdict not in (REPRODUCED, IN_KIND)} == set()
    lost = verdicts_under(name, LOST[name])
    assert {key for key, verdict in lost.items() if verdict != NOT_REPRODUCED} == set()
