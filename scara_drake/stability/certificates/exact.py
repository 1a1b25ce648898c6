"""Is a matrix positive definite? Answered for its floating-point entries without rounding.

A number of the machine is a fraction whose denominator is a power of two, so sums and products of
such are exact as fractions of integers. What a solver found is taken as it stands, whatever way it
was found, and Sylvester's criterion is decided by Bareiss' elimination, which stays in integers.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Exact = NDArray[np.object_]


def exact(values: ArrayLike) -> Exact:
    """Return an array of fractions that are equal to the numbers of an array.

    Raises:
        ValueError: NaN or infinity among them.
    """
    numbers = np.asarray(values, dtype=np.float64)
    if not np.isfinite(numbers).all():
        raise ValueError("values: not all are finite, allowed finite numbers")
    made = np.empty(numbers.shape, dtype=object)
    for index, number in np.ndenumerate(numbers):
        made[index] = Fraction(float(number))
    return made


def is_positive_definite(matrix: Any) -> bool:
    """Whether a symmetric matrix (n, n) of fractions is positive definite, exactly.

    Args:
        matrix: of fractions or integers; that it is symmetric is looked at too.
    """
    size = len(matrix)
    common = math.lcm(*(Fraction(entry).denominator for row in matrix for entry in row))
    rows = [[int(entry * common) for entry in row] for row in matrix]
    if any(rows[i][j] != rows[j][i] for i in range(size) for j in range(i)):
        return False
    last = 1
    for k in range(size):
        pivot = rows[k][k]  # the leading minor of order k + 1
        if pivot <= 0:
            return False
        for i in range(k + 1, size):
            for j in range(k + 1, size):
                rows[i][j] = (rows[i][j] * pivot - rows[i][k] * rows[k][j]) // last
        last = pivot
    return True
