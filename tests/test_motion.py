"""scara_drake.common.motion: the minimum jerk polynomial."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial import Polynomial

from scara_drake.common.motion import minimum_jerk, minimum_jerk_rate

WAY = Polynomial([0.0, 0.0, 0.0, 10.0, -15.0, 6.0])


@settings(deadline=None)
@given(st.floats(0.0, 1.0))
def test_it_is_the_polynomial_of_flash_and_hogan(x: float) -> None:
    assert abs(minimum_jerk(x) - WAY(x)) < 1e-14
    assert abs(minimum_jerk_rate(x) - WAY.deriv()(x)) < 1e-14


def test_it_goes_from_rest_to_rest() -> None:
    for end, place in ((0.0, 0.0), (1.0, 1.0)):
        assert minimum_jerk(end) == place
        assert minimum_jerk_rate(end) == 0.0


def test_arrays_of_any_shape_have_the_bits_of_numbers() -> None:
    x = np.random.default_rng(0).uniform(0.0, 1.0, (40, 3))
    for function in (minimum_jerk, minimum_jerk_rate):
        one_by_one = [[function(float(entry)) for entry in row] for row in x]
        np.testing.assert_array_equal(function(x), one_by_one)
