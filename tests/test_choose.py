"""scara_drake.common.choose."""

import pytest
from numba import njit

from scara_drake.common.choose import chooser


@njit
def add(a: float, b: float) -> float:
    return a + b


@njit
def subtract(a: float, b: float) -> float:
    return a - b


@njit
def multiply(a: float, b: float) -> float:
    return a * b


@pytest.mark.parametrize(("number", "expected"), [(0, 10.0), (1.0, 4.0), (2, 21.0)])
def test_the_function_of_a_number_is_called(number: float, expected: float) -> None:
    assert chooser([add, subtract, multiply])(number, 7.0, 3.0) == expected


def test_a_table_of_one() -> None:
    assert chooser([subtract])(0, 7.0, 3.0) == 4.0
