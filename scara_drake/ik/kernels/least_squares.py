"""Damped least squares on small arrays: the linear algebra under the inverse Jacobian.

Every kernel works on the six joints with a mask `free` (6,), 1.0 for a joint that may move and 0.0
for one that is held, and writes a joint step (6,).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.scratch import scratch
from scara_drake.ik.kernels.postures import Bounds
from scara_drake.ik.result import ROTATION_LENGTH

Array = NDArray[np.float64]

# Damping begins where the smallest singular value falls below its bound and grows to DAMPING at
# a singularity: Nakamura's rule. Position rows in m/rad, orientation rows in rad/rad.
POSITION_BOUND = 0.03
ROTATION_BOUND = 0.05
WEIGHTED_BOUND = 0.02


class Priority(NamedTuple):
    """What a step is to meet.

    Attributes:
        position_first: the position exactly and the rotation in its null space; else both.
        extra_p: added to the squared damping of the position, or of both.
        extra_w: added to that of the rotation.
    """

    position_first: bool
    extra_p: float
    extra_w: float


@njit(cache=True)
def cholesky_kernel(H: Array, n: int) -> None:
    """Replace the lower triangle of H (n, n), positive definite, by its Cholesky factor."""
    for j in range(n):
        s = H[j, j]
        for k in range(j):
            s -= H[j, k] * H[j, k]
        d = np.sqrt(max(s, 1e-300))
        H[j, j] = d
        for i in range(j + 1, n):
            s = H[i, j]
            for k in range(j):
                s -= H[i, k] * H[j, k]
            H[i, j] = s / d


@njit(cache=True)
def substitute_kernel(L: Array, x: Array, n: int) -> None:
    """Solve L L^T x = b in place on x (n,), L from cholesky_kernel."""
    for i in range(n):
        s = x[i]
        for k in range(i):
            s -= L[i, k] * x[k]
        x[i] = s / L[i, i]
    for i in range(n - 1, -1, -1):
        s = x[i]
        for k in range(i + 1, n):
            s -= L[k, i] * x[k]
        x[i] = s / L[i, i]


@njit(cache=True)
def eigenvalue_kernel(G: Array, rank: int) -> float:
    """Return the `rank`-th largest eigenvalue of a symmetric G (3, 3): the trigonometric form."""
    m = (G[0, 0] + G[1, 1] + G[2, 2]) / 3.0
    a, b, c = G[0, 0] - m, G[1, 1] - m, G[2, 2] - m
    d, e, f = G[1, 0], G[2, 0], G[2, 1]
    s = np.sqrt((a * a + b * b + c * c + 2.0 * (d * d + e * e + f * f)) / 6.0)
    if s < 1e-300:
        return m
    half_det = 0.5 * (a * (b * c - f * f) - d * (d * c - f * e) + e * (d * f - b * e)) / (s * s * s)
    angle = np.arccos(min(1.0, max(-1.0, half_det))) / 3.0
    return m + 2.0 * s * np.cos(angle + (0.0, 4.0, 2.0)[rank - 1] * np.pi / 3.0)


@njit(cache=True)
def damping_kernel(square: float, bound: float) -> float:
    """Square of the damping for a smallest singular value whose square is `square`."""
    return max(0.0, bound * bound - max(square, 0.0)) + 1e-12


@njit(cache=True)
def _projected_step(A: Array, e: Array, rank: int, bound: float, extra: float, dq: Array) -> None:
    """Add A^T (A A^T + damping)^-1 e to dq, for A (3, 6) of the given rank."""
    G, y = scratch(3, 3), scratch(3)
    for i in range(3):
        y[i] = e[i]
        for k in range(i + 1):
            s = 0.0
            for j in range(6):
                s += A[i, j] * A[k, j]
            G[i, k] = s
    # Below full rank the part of e that A cannot reach must not be divided by rounding.
    floor = 0.0 if rank == 3 else 1e-7
    damping = extra + floor + damping_kernel(eigenvalue_kernel(G, rank), bound)
    for i in range(3):
        G[i, i] += damping
    cholesky_kernel(G, 3)
    substitute_kernel(G, y, 3)
    for j in range(6):
        dq[j] += A[0, j] * y[0] + A[1, j] * y[1] + A[2, j] * y[2]


@njit(cache=True)
def position_first_kernel(
    J_WE: Array, e_p: Array, e_w: Array, free: Array, extra_p: float, extra_w: float, dq: Array
) -> None:
    """Write the step (6,) that meets e_p (3,), and e_w (3,) as far as its null space allows.

    `extra_p` and `extra_w` add to the squared damping of the position and the orientation.
    """
    A, Q, b = scratch(3, 6), scratch(3, 6), scratch(3)
    moving = 0
    for j in range(6):
        dq[j] = 0.0
        moving += int(free[j])
        for i in range(3):
            A[i, j] = J_WE[3 + i, j] * free[j]
    if moving == 0:
        return
    _projected_step(A, e_p, min(3, moving), POSITION_BOUND, extra_p, dq)
    if moving <= 3:
        return
    # Orthonormal rows that span the position rows (Gram-Schmidt, each projection twice).
    for i in range(3):
        for j in range(6):
            Q[i, j] = A[i, j]
        before = np.sqrt(_dot(Q[i], Q[i]))
        for _ in range(2):
            for k in range(i):
                s = _dot(Q[i], Q[k])
                for j in range(6):
                    Q[i, j] -= s * Q[k, j]
        n = np.sqrt(_dot(Q[i], Q[i]))
        g = 1.0 / n if n > 1e-9 * before and n > 1e-12 else 0.0
        for j in range(6):
            Q[i, j] *= g
    for i in range(3):
        b[i] = e_w[i]
        for j in range(6):
            b[i] -= J_WE[i, j] * dq[j]
            A[i, j] = J_WE[i, j] * free[j]
        for _ in range(2):
            for k in range(3):
                s = _dot(A[i], Q[k])
                for j in range(6):
                    A[i, j] -= s * Q[k, j]
    _projected_step(A, b, min(3, moving - 3), ROTATION_BOUND, extra_w, dq)


@njit(cache=True)
def _dot(a: Array, b: Array) -> float:
    s = 0.0
    for j in range(6):
        s += a[j] * b[j]
    return s


@njit(cache=True)
def normal_equations_kernel(
    J_WE: Array, e_p: Array, e_w: Array, length: float, free: Array, H: Array, g: Array
) -> None:
    """Write H = J^T W J (6, 6), lower triangle, and g = J^T W e (6,); W = diag(1, length^2).

    A held joint gets a unit pivot and no step.
    """
    square = length * length
    for j in range(6):
        s = w = 0.0
        for i in range(3):
            w += J_WE[i, j] * e_w[i]
            s += J_WE[3 + i, j] * e_p[i]
        g[j] = (s + square * w) * free[j]
        for k in range(j + 1):
            s = w = 0.0
            for i in range(3):
                w += J_WE[i, j] * J_WE[i, k]
                s += J_WE[3 + i, j] * J_WE[3 + i, k]
            H[j, k] = (s + square * w) * free[j] * free[k]
        if free[j] == 0.0:
            H[j, j] = 1.0


@njit(cache=True)
def weighted_kernel(
    J_WE: Array, e_p: Array, e_w: Array, free: Array, extra: float, dq: Array
) -> None:
    """Write the step (6,) that meets position and orientation together in the weighted sense.

    The smallest eigenvalue, which decides the damping, comes from inverse iteration.
    """
    H, x = scratch(6, 6), scratch(6)
    normal_equations_kernel(J_WE, e_p, e_w, ROTATION_LENGTH, free, H, dq)
    for j in range(6):
        H[j, j] += 1e-12
        x[j] = free[j] * (1.0 + 0.1 * j)
    cholesky_kernel(H, 6)
    smallest = 1.0
    for _ in range(4):
        n = np.sqrt(_dot(x, x))
        if n == 0.0:
            return
        for j in range(6):
            x[j] /= n
        substitute_kernel(H, x, 6)
        smallest = 1.0 / np.sqrt(_dot(x, x))
    damping = extra + damping_kernel(smallest, WEIGHTED_BOUND)
    if damping > 2e-12:
        normal_equations_kernel(J_WE, e_p, e_w, ROTATION_LENGTH, free, H, dq)
        for j in range(6):
            H[j, j] += damping
        cholesky_kernel(H, 6)
    substitute_kernel(H, dq, 6)


@njit(cache=True)
def bounded_step_kernel(
    J_WE: Array,
    e_p: Array,
    e_w: Array,
    priority: Priority,
    q: Array,
    bounds: Bounds,
    free: Array,
    dq: Array,
) -> None:
    """Write the step (6,) with every joint held that sits at a limit and would leave it.

    The remaining joints take over the task; `free` (6,) returns who may move.
    """
    lower, upper, first_joint = bounds.lower, bounds.upper, bounds.first_joint
    for j in range(6):
        free[j] = 1.0 if j >= first_joint else 0.0
    for _ in range(6):
        if priority.position_first:
            position_first_kernel(J_WE, e_p, e_w, free, priority.extra_p, priority.extra_w, dq)
        else:
            weighted_kernel(J_WE, e_p, e_w, free, priority.extra_p, dq)
        again = False
        for j in range(first_joint, 6):
            out = (q[j] <= lower[j] and dq[j] < 0.0) or (q[j] >= upper[j] and dq[j] > 0.0)
            if out and free[j] > 0.0:
                free[j] = 0.0
                again = True
        if not again:
            return
