"""Every real root of a trigonometric polynomial of degree three, double ones too.

Bisection that proves what it drops: a third-order Taylor bound tells whether an interval holds no
root, or the polynomial is monotonic or of one curvature there, so that one root or two remain. Only
around a root of multiplicity three or more does it descend to intervals on which the polynomial
cannot be told from zero.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

# In units of the sum of the amplitudes: the rounding of the polynomial, and how near to zero an
# extremum counts as a double root (its coefficients are rounded too).
ROUNDING = 1e-15
TOUCHING = 1e-11
START_INTERVALS = 16
FIRST_ANGLE = -3.0  # where they begin; multiples of a right angle stay off their ends
CONVERGING = 1e-9  # a Newton step after which only rounding remains, [rad]
SAME = 1e-12  # [rad]
SHARP = 1e-7  # a root known this well is a plain one, [rad]
BLUR = 1e-6  # of a multiple root, [rad]
MAX_ROOTS = 24


class Roots(NamedTuple):
    """What was found.

    Attributes:
        angles: (MAX_ROOTS,), ascending [rad].
        multiple: (MAX_ROOTS,), 1.0 for roots of which several cannot be told apart, else 0.0.
        rounding: value of the polynomial that is rounding.
        touching: value of an extremum that counts as zero.
    """

    angles: Array
    multiple: Array
    rounding: float
    touching: float


@njit(cache=True)
def evaluate_kernel(c: Array, t: float) -> tuple[float, float, float]:
    """Value and first two derivatives of c0 + sum of c[2k-1] cos kt + c[2k] sin kt, k = 1, 2, 3."""
    s1, c1 = np.sin(t), np.cos(t)
    s2, c2 = 2.0 * s1 * c1, c1 * c1 - s1 * s1
    s3, c3 = s2 * c1 + c2 * s1, c2 * c1 - s2 * s1
    a, b, d = c[1] * c1 + c[2] * s1, c[3] * c2 + c[4] * s2, c[5] * c3 + c[6] * s3
    slope = (
        (c[2] * c1 - c[1] * s1)
        + 2.0 * (c[4] * c2 - c[3] * s2)
        + 3.0 * (c[6] * c3 - c[5] * s3)
    )  # fmt: skip
    return c[0] + a + b + d, slope, -a - 4.0 * b - 9.0 * d


@njit(cache=True)
def _root_between(f: float, f_end: float, slope_end: float, rounding: float) -> bool:
    """Whether there is a change of sign, or a plain root at the end that rounding may hide."""
    at_end = abs(f_end) < rounding < SHARP * abs(slope_end)
    return f * f_end <= 0.0 or at_end


@njit(cache=True)
def _root(c: Array, t: float, low: float, high: float, rising: bool) -> float:
    """Root of a polynomial with one change of sign on [low, high], by Newton steps from t."""
    for _ in range(60):
        t = min(max(t, low), high)
        f, slope, _ = evaluate_kernel(c, t)
        if (f > 0.0) == rising:
            high = t
        else:
            low = t
        step = f / slope if slope != 0.0 else np.inf
        inside = low <= t - step <= high
        t = t - step if inside else 0.5 * (low + high)
        if (inside and abs(step) < CONVERGING) or high - low < 1e-15:
            break
    return t


@njit(cache=True)
def _extremum(c: Array, low: float, high: float, slope: float, curvature: float) -> float:
    """Extremum of a polynomial of one curvature on [low, high], or the end nearest to it.

    Slope and curvature are those in the middle.
    """
    t = 0.5 * (low + high)
    for _ in range(60):
        if slope * curvature > 0.0:
            high = t
        else:
            low = t
        step = slope / curvature if curvature != 0.0 else np.inf
        inside = low <= t - step <= high
        t = t - step if inside else 0.5 * (low + high)
        if (inside and abs(step) < CONVERGING) or high - low < 1e-15:
            break
        _, slope, curvature = evaluate_kernel(c, t)
    return t


@njit(cache=True)
def _add(root: float, several: bool, roots: Roots, n: int) -> int:
    """Append a root, unless the one before is the same; return the new number."""
    if n == MAX_ROOTS or (n > 0 and root - roots.angles[n - 1] < SAME):
        return n
    roots.angles[n], roots.multiple[n] = root, 1.0 if several else 0.0
    return n + 1


@njit(cache=True)
def _add_monotonic(
    c: Array, t: float, h: float, f: float, slope: float, roots: Roots, n: int
) -> int:
    """Append the root of a polynomial that is monotonic on t ± h, if any; return the new number.

    It can only lie on the side where the polynomial comes nearer to zero.
    """
    end = t - h if f * slope > 0.0 else t + h
    f_end, slope_end, _ = evaluate_kernel(c, end)
    if _root_between(f, f_end, slope_end, roots.rounding):
        root = _root(c, t - f / slope, min(t, end), max(t, end), slope > 0.0)
        n = _add(root, False, roots, n)
    return n


@njit(cache=True)
def _add_curved(
    c: Array, t: float, h: float, slope: float, curvature: float, roots: Roots, n: int
) -> int:
    """Append the roots of a polynomial of one curvature on t ± h; return the new number.

    There are none, two, or one double root, around the extremum.
    """
    middle = _extremum(c, t - h, t + h, slope, curvature)
    f, slope, curvature = evaluate_kernel(c, middle)
    zero = abs(f) < roots.rounding or (abs(f) < roots.touching and f * curvature > 0.0)
    if abs(slope) < abs(curvature) * 1e-9 and zero:
        n = _add(middle, True, roots, n)
    elif f * curvature < 0.0 or abs(f) < roots.rounding:
        away = np.sqrt(abs(2.0 * f / curvature))
        for sign in (-1.0, 1.0):
            end = t + sign * h
            f_end, slope_end, _ = evaluate_kernel(c, end)
            if _root_between(f, f_end, slope_end, roots.rounding):
                low, high = min(middle, end), max(middle, end)
                rising = sign * curvature > 0.0
                root = _root(c, middle + sign * away, low, high, rising)
                n = _add(root, False, roots, n)
    return n


@njit(cache=True)
def _search(c: Array, third: float, roots: Roots) -> int:
    """Write the roots in one turn, the seam looked at from both sides; return their number.

    `third` bounds the third derivative.
    """
    stack = np.empty((64, 2))
    n = 0
    cluster_start = cluster_end = -np.inf
    width = np.pi / START_INTERVALS  # half of an interval
    for start in range(START_INTERVALS):
        stack[0, 0], stack[0, 1] = FIRST_ANGLE + (2 * start + 1) * width, width
        waiting = 1
        while waiting > 0:
            waiting -= 1
            t, h = stack[waiting, 0], stack[waiting, 1]
            f, slope, curvature = evaluate_kernel(c, t)
            spread = h * (abs(slope) + h * (0.5 * abs(curvature) + h * third / 6.0))
            if abs(f) > spread + roots.touching:
                continue
            if abs(slope) > h * (abs(curvature) + 0.5 * h * third):
                n = _add_monotonic(c, t, h, f, slope, roots, n)
            elif abs(curvature) > h * third:
                n = _add_curved(c, t, h, slope, curvature, roots, n)
            elif spread < roots.rounding:
                # Neighbours make one cluster, entered by its middle.
                if abs(f) < 2.0 * roots.rounding and n > 0 and t - cluster_end < 8.0 * h:
                    roots.angles[n - 1] = 0.5 * (cluster_start + t)
                    cluster_end = t
                elif abs(f) < 2.0 * roots.rounding:
                    n = _add(t, True, roots, n)
                    cluster_start = cluster_end = t
            else:
                stack[waiting, 0], stack[waiting, 1] = t + 0.5 * h, 0.5 * h
                stack[waiting + 1, 0], stack[waiting + 1, 1] = t - 0.5 * h, 0.5 * h
                waiting += 2
    return n


@njit(cache=True)
def roots_kernel(c: Array, roots: Array, multiple: Array) -> int:
    """Write the real roots in one turn, [rad], and which are (nearly) multiple; their number.

    Args:
        c: coefficients (7,), see `evaluate_kernel`.
        roots: (MAX_ROOTS,), ascending in [-3, 2 pi - 3).
        multiple: (MAX_ROOTS,), 1.0 for roots of which several cannot be told apart (one entry
            stands for all), also where the polynomial only just misses zero, and 0.0 for the
            others. The polynomial zero counts as one such root, at 0.
    """
    scale, third = abs(c[0]), 0.0
    for k in range(1, 4):
        size = np.sqrt(c[2 * k - 1] * c[2 * k - 1] + c[2 * k] * c[2 * k])
        scale += size
        third += k * k * k * size
    if scale == 0.0:
        roots[0], multiple[0] = 0.0, 1.0
        return 1
    n = _search(c, third, Roots(roots, multiple, ROUNDING * scale, TOUCHING * scale))
    # The circle closes; roots at the seam are found from both sides.
    if n > 1 and roots[n - 1] - roots[0] > 2.0 * np.pi - (BLUR if multiple[0] > 0.0 else SAME):
        n -= 1
    return n
