"""The delayed virtual wall: the device's kernel against eigenvalues and published laws."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from small_experiments import small
from strategies import examples

from scara_drake.experiments import REPRODUCED, Experiment
from scara_drake.experiments.literature import delayed_wall
from scara_drake.experiments.literature.delayed_wall import (
    DELAYS,
    HANDS,
    exact_boundary,
    simulated_boundary,
)

# Largest stiffness [N/m] over `DELAYS`, from eigenvalues worked out by another program.
OTHERS = {
    ("no hand", 0.0): (4004, 1336, 802, 366, 193),
    ("no hand", 10.0): (23242, 7719, 4588, 2019, 995),
    ("hand", 0.0): (12041, 4023, 2422, 1113, 596),
    ("hand", 10.0): (31060, 10330, 6153, 2724, 1357),
}


def experiment() -> Experiment:
    return small("delayed_wall")


@pytest.mark.parametrize(("hand", "damping"), OTHERS)
def test_the_eigenvalues_are_those_of_another_program(hand: str, damping: float) -> None:
    ours = [exact_boundary(HANDS[hand], damping, delay) for delay in DELAYS]
    assert ours == pytest.approx(OTHERS[hand, damping], abs=0.6)


@given(
    stiffness=st.floats(0.0, 500.0),
    grip=st.floats(0.0, 10.0),
    damping=st.floats(0.0, 10.0),
    ticks=st.integers(0, 6),
)
@examples(4)
def test_the_kernel_bears_what_the_eigenvalues_say(
    stiffness: float, grip: float, damping: float, ticks: int
) -> None:
    cell = (stiffness, grip), damping, 1e-3 * ticks
    assert simulated_boundary(*cell, duration=10.0) == pytest.approx(
        exact_boundary(*cell), rel=5e-5
    )


def test_verdicts() -> None:
    assert [claim.verdict for claim in experiment().claims] == [REPRODUCED] * 4


def test_it_judges_what_it_is_given() -> None:
    data = experiment().data
    for factor, met in ((1.0, [1, 1, 1, 1]), (1.0002, [0, 1, 1, 1]), (0.5, [0, 0, 0, 0])):
        changed = data.copy(deep=True)
        changed["by_kernel"] = data.by_kernel * factor
        changed["in_springs"] = data.in_springs * factor
        judged = delayed_wall.claims(changed)
        assert [claim.verdict == REPRODUCED for claim in judged] == [bool(one) for one in met]
    changed["in_springs"] = data.in_springs * 1.05
    assert delayed_wall.claims(changed)[3].verdict != REPRODUCED


def test_passive_is_below_stable() -> None:
    data = experiment().data
    assert data.passive.values.tolist() == [4000.0, -16000.0]  # 2 (b - |B|) / T
    assert np.all(data.in_springs > 4000.0)


@pytest.mark.parametrize("delay", [0.0005, np.nan, np.inf, -0.001])
def test_a_delay_is_whole_periods(delay: float) -> None:
    with pytest.raises(ValueError, match=r"delays\[0\]: .*allowed"):
        delayed_wall.run(delays=(delay,))
