"""Random numbers that are functions of a seed and a counter: no generator, no state, no order.

A draw that a system makes at its k-th event is the number that belongs to k, so a seed gives the
same bits from any copy of a Context.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

_STEP = np.uint64(0x9E3779B97F4A7C15)  # splitmix64's


@njit(cache=True)
def _mix(x: np.uint64) -> np.uint64:
    """Scramble 64 bits: the output function of splitmix64."""
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return x ^ (x >> np.uint64(31))


@njit(cache=True)
def uniform(seed: int, counter: int) -> float:
    """Number in (0, 1) that belongs to (seed, counter), both 0 or more."""
    bits = _mix(_mix(np.uint64(seed) + _STEP) + np.uint64(counter) * _STEP)
    return (float(bits >> np.uint64(11)) + 0.5) * 2.0**-53


@njit(cache=True)
def normal(seed: int, counter: int) -> float:
    """Standard normal number that belongs to (seed, counter), by Box and Muller."""
    radius = math.sqrt(-2.0 * math.log(uniform(seed, 2 * counter)))
    return radius * math.cos(2.0 * math.pi * uniform(seed, 2 * counter + 1))


@njit(cache=True)
def gamma(shape: float, seed: int, counter: int) -> float:
    """Gamma number of unit scale that belongs to (seed, counter).

    Method of Marsaglia and Tsang, ACM Trans. Math. Softw. 26 (2000) 363: squeezed from a normal
    number, rejected in fewer than one of twenty tries.
    """
    tries = 64
    base = counter * tries
    boost = 1.0
    if shape < 1.0:
        boost = uniform(seed + 2, counter) ** (1.0 / shape)
        shape += 1.0
    d = shape - 1.0 / 3.0
    c = 1.0 / math.sqrt(9.0 * d)
    v = 1.0
    for i in range(tries):
        x = normal(seed, base + i)
        v = (1.0 + c * x) ** 3
        if v > 0.0 and math.log(uniform(seed + 1, base + i)) < 0.5 * x * x + d * (
            1.0 - v + math.log(v)
        ):
            break
    return boost * d * max(v, 0.0)
