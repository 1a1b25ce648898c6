import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scara_drake.channel.delays import ConstantDelay, SineDelay, StepDelay, TableDelay
from scara_drake.common.fields import check

TIMES = [0.5, 1.0, 2.5]
DELAYS = [0.2, 0.0, 0.3]


@given(st.floats(0.0, 10.0))
def test_sine_is_never_negative_nor_above_its_maximum(t):
    law = SineDelay(0.2, -0.05, 3.0, 0.7)
    assert 0.0 <= law.at(t) <= law.maximum() == pytest.approx(0.15)
    assert law.at(t) == pytest.approx(max(0.2 * np.sin(3.0 * t + 0.7) - 0.05, 0.0))


@given(st.floats(-1.0, 5.0))
def test_table_is_straight_between_points_and_constant_outside(t):
    law = TableDelay(TIMES, DELAYS)
    assert law.at(t) == pytest.approx(np.interp(t, TIMES, DELAYS))
    assert law.maximum() == 0.3


@pytest.mark.parametrize(
    ("t", "delay"), [(0.0, 0.2), (0.5, 0.2), (0.99, 0.2), (1.0, 0.0), (2.4, 0.0), (2.5, 0.3)]
)
def test_steps_hold_until_the_next(t, delay):
    assert StepDelay(TIMES, DELAYS).at(t) == delay


def test_constant():
    assert ConstantDelay(0.1).at(3.0) == ConstantDelay(0.1).maximum() == 0.1


@pytest.mark.parametrize(
    ("law", "message"),
    [
        (ConstantDelay(-1.0), r"^up\.delay: -1\.0, allowed 0 to 60$"),
        (SineDelay(amplitude=float("nan")), r"^up\.amplitude: nan, allowed 0 to 60$"),
        (StepDelay([], []), r"^up\.times: no entries, allowed 1 or more$"),
        (StepDelay([0.0], [-0.1]), r"^up\.delays\[0\]: -0\.1, allowed 0 to 60$"),
        (TableDelay([0.0, 1.0], [0.1]), r"^up\.delays: 1 entries, allowed 2$"),
        (TableDelay([1.0, 0.5], [0.1, 0.1]), r"^up\.times\[1\]: 0\.5, allowed above 1\.0$"),
    ],
)
def test_bad_laws_are_refused_by_field_and_range(law, message):
    with pytest.raises(ValueError, match=message):
        check(law, "up")
