"""The smoothest path through the branches of the closed form.

A path that is followed point by point can enter a branch that ends later: near a fold two branches
are equally near, and only what comes tells them apart. With every solution of every point known,
dynamic programming finds the sequence whose largest joint step is the smallest.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.ik.kernels.solutions import MOST, SLACK, every_turn_kernel, solutions_kernel

Array = NDArray[np.float64]

MOST_TURNED = 8 * MOST  # solutions of a point, whole turns counted


@njit(cache=True)
def largest_step_kernel(a: Array, b: Array) -> float:
    """Return the largest change of a joint between two postures (6,)."""
    largest = 0.0
    for j in range(6):
        largest = max(largest, abs(a[j] - b[j]))
    return largest


@njit(cache=True)
def smoothest_path_kernel(
    p: Array, R: Array, first_joint: int, start: Array, fixed: bool, q: Array
) -> float:
    """Write the path q (n, 6) of exact solutions whose largest joint step is the smallest.

    Args:
        p: targets (n, 3) [m].
        R: targets (n, 3, 3).
        first_joint: 0 moves the mast, 1 keeps the height of start.
        start: posture (6,) of the first point.
        fixed: whether the first point keeps it, or may be on any branch.
        q: result (n, 6).

    Returns:
        The largest step [m, rad]; infinite, with q left as it was, where a point has no exact
        solution.
    """
    n = p.shape[0]
    work, listed = np.empty((MOST, 6)), np.empty((n, MOST_TURNED + 1, 6))
    counts, came = np.zeros(n, np.int64), np.zeros((n, MOST_TURNED), np.int64)
    cost, length = np.full(MOST_TURNED, np.inf), np.zeros(MOST_TURNED)
    if fixed:
        counts[0] = 1
        listed[0, 0] = start
        cost[0] = 0.0
    for k in range(1 if fixed else 0, n):
        found = solutions_kernel(p[k], R[k], first_joint, start[0], work)
        counts[k] = every_turn_kernel(work, found, SLACK, listed[k])
        if counts[k] == 0:
            return np.inf
        if k == 0:
            cost[: counts[0]] = 0.0
            continue
        new_cost, new_length = np.full(MOST_TURNED, np.inf), np.zeros(MOST_TURNED)
        for j in range(counts[k]):
            for i in range(counts[k - 1]):
                step = largest_step_kernel(listed[k - 1, i], listed[k, j])
                worst, total = max(cost[i], step), length[i] + step
                # Among equal largest steps the shorter path.
                if worst < new_cost[j] or (worst == new_cost[j] and total < new_length[j]):
                    new_cost[j], new_length[j], came[k, j] = worst, total, i
        cost, length = new_cost, new_length
    j = 0
    for i in range(counts[n - 1]):
        if cost[i] < cost[j] or (cost[i] == cost[j] and length[i] < length[j]):
            j = i
    largest = cost[j]
    for k in range(n - 1, -1, -1):
        q[k] = listed[k, j]
        j = came[k, j]
    return largest


@njit(cache=True)
def has_jump_kernel(q: Array, ratio: float) -> bool:
    """Whether a step of a path q (n, 6) stands out from both its neighbours by `ratio`."""
    n = q.shape[0]
    for k in range(1, n):
        step = largest_step_kernel(q[k - 1], q[k])
        before = largest_step_kernel(q[k - 2], q[k - 1]) if k > 1 else 0.0
        after = largest_step_kernel(q[k], q[k + 1]) if k < n - 1 else 0.0
        if step > ratio * max(before, after) + 1e-3:
            return True
    return False
