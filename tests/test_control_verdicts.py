"""No verdict of the control experiments is a constant: other data give other verdicts.

Each claim with a criterion is judged once more on data that were changed variable by variable. A
claim whose verdict no change can move would say the same whatever had been measured.
"""

import numpy as np
import pytest
from test_experiments import small

from scara_drake.experiments.control import (
    equivalent_control,
    figures_16_17,
    figures_18_19,
    figures_29_30,
    figures_29_30_claims,
    perturbation_observer,
    stability,
    table_10,
    windup,
)

MODULES = {
    "table_10": table_10,
    "figures_16_17": figures_16_17,
    "figures_18_19": figures_18_19,
    "figures_29_30": figures_29_30_claims,
    "windup": windup,
    "perturbation_observer": perturbation_observer,
    "stability": stability,
    "equivalent_control": equivalent_control,
}
CHANGES = {
    "a hundred times": lambda values: 100.0 * values,
    "a hundredth": lambda values: 0.01 * values,
    "ten times": lambda values: 10.0 * values,
    "a tenth": lambda values: 0.1 * values,
    "twice": lambda values: 2.0 * values,
    "none": lambda values: 0.0 * values,
    "one more": lambda values: values + 1.0,
    "negative": lambda values: -values,
    "mirrored": lambda values: values[..., ::-1],
    "swapped": lambda values: values[::-1],
}


def changed(data):
    """Yield the data with one variable changed, or all variables of numbers alike."""
    for change in CHANGES.values():
        every = data.copy(deep=True)
        for name in data.data_vars:
            if data[name].dtype.kind not in "fb" or not data[name].ndim:
                continue
            other = data.copy(deep=True)
            values = data[name].values
            new = ~values if values.dtype == bool else change(values)
            other[name].values[:] = new
            every[name].values[:] = new
            yield other
        yield every


@pytest.mark.parametrize("name", MODULES)
def test_other_data_give_another_verdict(name):
    experiment = small(name)
    judged_by = experiment.data
    if name == "figures_29_30":  # its claims come from a few figures of merit
        judged_by = figures_29_30.figures_of_merit(experiment.data)
    seen = [{claim.verdict} for claim in experiment.claims]
    judged = [claim.criterion is not None for claim in experiment.claims]
    with np.errstate(all="ignore"):
        for data in changed(judged_by):
            for verdicts, claim in zip(seen, MODULES[name].claims(data), strict=True):
                verdicts.add(claim.verdict)
            if all(len(verdicts) > 1 for verdicts, can in zip(seen, judged, strict=True) if can):
                return
    stuck = [
        claim.statement
        for claim, verdicts, can in zip(experiment.claims, seen, judged, strict=True)
        if can and len(verdicts) == 1
    ]
    assert not stuck, stuck
