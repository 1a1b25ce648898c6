import numpy as np
import pytest
from numba import njit
from scipy import stats

from scara_drake.common.draws import gamma, normal, uniform

N = 100_000


@njit
def sample(draw, seed, n):
    return np.array([draw(seed, i) for i in range(n)])


@njit
def sample_gamma(shape, seed, n):
    return np.array([gamma(shape, seed, i) for i in range(n)])


@pytest.mark.parametrize(
    ("draw", "distribution"), [(uniform, stats.uniform()), (normal, stats.norm())]
)
def test_distribution(draw, distribution):
    assert stats.kstest(sample(draw, 7, N), distribution.cdf).pvalue > 0.01


@pytest.mark.parametrize("shape", [0.3, 1.0, 4.0, 50.0])
def test_gamma(shape):
    assert stats.kstest(sample_gamma(shape, 7, N), stats.gamma(shape).cdf).pvalue > 0.01


def test_neighbouring_counters_and_seeds_are_uncorrelated():
    one, other = sample(uniform, 1, N), sample(uniform, 2, N)
    bound = 4.0 / np.sqrt(N)
    assert abs(np.corrcoef(one[1:], one[:-1])[0, 1]) < bound
    assert abs(np.corrcoef(one, other)[0, 1]) < bound


def test_a_draw_is_a_function_of_seed_and_counter():
    assert uniform(5, 9) == uniform(5, 9) != uniform(5, 10)
    assert gamma(2.5, 5, 9) == gamma(2.5, 5, 9)
