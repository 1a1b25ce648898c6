"""The closed form inside the joint ranges: every solution, the nearest one, or the least error.

`closed_form_arm` and `closed_form_mast` find the solutions modulo whole turns; here theta2, theta3
and theta6 are turned and the limits applied.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.ik.kernels.closed_form_arm import EXACT, arm_branches_kernel, arm_solutions_kernel
from scara_drake.ik.kernels.closed_form_mast import mast_branches_kernel
from scara_drake.ik.kernels.errors import confirm_kernel, error_kernel
from scara_drake.ik.kernels.postures import (
    TURNED,
    distance_kernel,
    inside_kernel,
    keep_limits_kernel,
    nearest_turns_kernel,
    ranges_kernel,
    settle_kernel,
    turned_kernel,
)
from scara_drake.ik.result import ROTATION_LENGTH
from scara_drake.joints import LOWER, UPPER
from scara_drake.kinematics import D6

Array = NDArray[np.float64]

MOST = 24  # solutions modulo whole turns
# A joint this far outside its range is at the limit, by rounding [m], [rad]: where solutions are to
# be exact, and where they are to be within the tolerances.
EXACT_SLACK, SLACK = 1e-10, 1e-9


@njit(cache=True)
def solutions_kernel(p: Array, R: Array, first_joint: int, mast_height: float, q: Array) -> int:
    """Write the solutions q (24, 6) modulo whole turns, limits not applied; return their number."""
    if first_joint == 1:
        return arm_solutions_kernel(p, R, mast_height, q)
    return mast_branches_kernel(p, R, q)


@njit(cache=True)
def nearest_solution_kernel(
    p: Array, R: Array, first_joint: int, near: Array, slack: float, solutions: Array, q: Array
) -> tuple[bool, int]:
    """Write the exact solution q (6,) inside the limits that is nearest to a posture, if any.

    A joint outside its range by `slack` or less is put on the limit. Returns whether there is one,
    and the number of `solutions` (24, 6), which are left there turned
    as near as they can be.
    """
    n = solutions_kernel(p, R, first_joint, near[0], solutions)
    least = np.inf
    for k in range(n):
        nearest_turns_kernel(solutions[k], near)
        settle_kernel(solutions[k], slack)
        distance = distance_kernel(solutions[k], near)
        if distance < least and inside_kernel(solutions[k]):
            least = distance
            q[:] = solutions[k]
    return least < np.inf, n


@njit(cache=True)
def nearest_kernel(
    p: Array, R: Array, first_joint: int, near: Array, work: Array, q: Array
) -> tuple[bool, int]:
    """Write the exact solution inside the limits that is nearest to a posture.

    Without one, the candidate with the least error, clipped to the limits; an arm that moves its
    mast then also tries the mast at its limits, and level with the wrist and the tool.

    Args:
        p: target (3,) [m].
        R: target (3, 3).
        first_joint: 0 or 1; with 1 the mast stays at near[0].
        near: posture (6,).
        work: (24, 6).
        q: result (6,), not `near` itself.

    Returns:
        Whether q is exact, and how many candidates were looked at.
    """
    found, n = nearest_solution_kernel(p, R, first_joint, near, EXACT_SLACK, work, q)
    if found:
        return True, n
    residual, bounds = np.empty(4), ranges_kernel(0)
    heights = (near[0], LOWER[0], UPPER[0], p[2], p[2] - D6 * R[2, 2])
    least, tried = np.inf, n
    for i in range(6 if first_joint == 0 else 2):
        # The solutions outside the limits first, then the candidates at each height.
        if i > 0:
            height = min(max(heights[i - 1], LOWER[0]), UPPER[0])
            n = arm_branches_kernel(p, R, height, work, residual)
            tried += n
        for k in range(n):
            nearest_turns_kernel(work[k], near)
            keep_limits_kernel(work[k], bounds, False)
            position, rotation = error_kernel(work[k], p, R)
            error = np.hypot(position, ROTATION_LENGTH * rotation)
            if error < least:
                least = error
                q[:] = work[k]
    return False, tried


@njit(cache=True)
def nearest_batch_kernel(
    p: Array, R: Array, first_joint: int, near: Array, level: bool, follow: bool
) -> tuple[Array, NDArray[np.bool_], NDArray[np.int64]]:
    """Solve n targets p (n, 3), R (n, 3, 3); return q (n, 6), success (n,) and tried (n,).

    The posture `near` (6,) is that of the last success where `follow`; its mast height is that of
    the target where `level`.
    """
    n = p.shape[0]
    q, success, tried = np.empty((n, 6)), np.empty(n, np.bool_), np.empty(n, np.int64)
    work, near = np.empty((MOST, 6)), near.copy()
    for i in range(n):
        if level:
            near[0] = min(max(p[i, 2], LOWER[0]), UPPER[0])
        success[i], tried[i] = nearest_kernel(p[i], R[i], first_joint, near, work, q[i])
        if not success[i]:
            _, _, success[i] = confirm_kernel(q[i], p[i], R[i], False)
        if follow and success[i]:
            near[:] = q[i]
    return q, success, tried


@njit(cache=True)
def every_turn_kernel(solutions: Array, n: int, slack: float, listed: Array) -> int:
    """List n solutions with all whole turns of theta2, theta3, theta6 inside the limits.

    Returns how many were written to the first rows of `listed`, whose last row is work space.
    """
    count = 0
    for k in range(n):
        for i in range(TURNED):
            if turned_kernel(solutions[k], i, slack, listed[count]) and count < listed.shape[0] - 1:
                count += 1
    return count


@njit(cache=True)
def all_kernel(p: Array, R: Array, first_joint: int, mast_height: float) -> Array:
    """Return every solution (n, 6) inside the limits, by whole turns too, exact within 1e-9."""
    work, q = np.empty((MOST, 6)), np.empty((MOST * TURNED + 1, 6))
    found = solutions_kernel(p, R, first_joint, mast_height, work)
    n = 0
    for k in range(every_turn_kernel(work, found, EXACT_SLACK, q)):
        position, rotation = error_kernel(q[k], p, R)
        if position <= EXACT and rotation <= EXACT:
            q[n] = q[k]
            n += 1
    return q[:n].copy()
