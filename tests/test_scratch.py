import numpy as np
import pytest
from numba import njit
from numba.core.errors import NumbaError

from scara_drake.common.scratch import scratch


@njit
def product(a: np.ndarray, b: np.ndarray, result: np.ndarray) -> float:
    turned, total = scratch(2, 3), scratch(4)
    for i in range(2):
        for j in range(3):
            turned[i, j] = a[j, i]
    total[:] = 0.0
    for i in range(2):
        for j in range(2):
            result[i, j] = 0.0
            for k in range(3):
                result[i, j] += turned[i, k] * b[k, j]
            total[2 * i + j] = result[i, j]
    return total.sum() + 1000 * turned.size + total.shape[0]


def test_scratch_arrays_hold_what_is_written() -> None:
    a, b = np.random.default_rng(0).normal(size=(2, 3, 2))
    for run in (product, product.py_func):
        result = np.empty((2, 2))
        assert run(a, b, result) == pytest.approx((a.T @ b).sum() + 6004.0, rel=1e-14)
        np.testing.assert_allclose(result, a.T @ b, rtol=1e-14)


@njit
def two_at_once(x: float) -> float:
    first, second = scratch(3), scratch(3)
    first[:] = x
    second[:] = 2.0 * x
    return first.sum() - second.sum()


def test_scratch_arrays_do_not_share_memory() -> None:
    assert two_at_once(1.0) == -3.0


def test_a_length_that_is_not_written_out_is_refused() -> None:
    @njit
    def open_length(n: int) -> float:
        return scratch(n).sum()

    with pytest.raises(NumbaError):
        open_length(3)
