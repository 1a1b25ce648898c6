"""Every branch of the solution: local solutions from many draws.

The number of draws is always the same, so the answer depends on the seed and on nothing else.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.ik.kernels.postures import (
    goal_kernel,
    keep_limits_kernel,
    mirror_kernel,
    nearest_turns_kernel,
)
from scara_drake.ik.kernels.refine import Descent, refine_kernel, refine_position_first_kernel
from scara_drake.ik.kernels.search import search_box_kernel
from scara_drake.ik.kernels.swarm import draw_posture_kernel, draws
from scara_drake.ik.result import ROTATION_LENGTH

Array = NDArray[np.float64]

BRANCH_STEPS = 60


@njit(cache=True)
def branches_kernel(
    p: Array,
    R: Array,
    first_joint: int,
    position_first: bool,
    near: Array,
    from_near: bool,
    seed: int,
    n: int,
) -> tuple[Array, Array, int, int]:
    """Find n local solutions.

    The first starts from `near` where `from_near` is set, every second one from the mirror of the
    one before, the others from draws; theta2, theta3 and theta6 end nearest to `near`.

    Returns:
        Postures (n, 6), their errors (n, 2) [m], [rad], evaluations, iterations.
    """
    goal, box, state = goal_kernel(p, R, first_joint), search_box_kernel(p), draws(seed)
    descent, none = Descent(ROTATION_LENGTH, 1.0, BRANCH_STEPS, True), np.empty((0, 2))
    q, errors = np.empty((n, 6)), np.empty((n, 2))
    evaluations, iterations = 0, 0
    for k in range(n):
        if k % 2 == 1:
            mirror_kernel(q[k - 1], q[k])
            keep_limits_kernel(q[k], goal.bounds, True)
        else:
            q[k] = near
            if k > 0 or not from_near:
                draw_posture_kernel(state, box.low, box.high, first_joint, q[k])
        if position_first:
            e_p, e_w, ev, it = refine_position_first_kernel(q[k], goal, descent, none)
        else:
            e_p, e_w, ev, it = refine_kernel(q[k], goal, descent, none)
        errors[k, 0], errors[k, 1] = e_p, e_w
        nearest_turns_kernel(q[k], near)
        evaluations += ev
        iterations += it
    return q, errors, evaluations, iterations


@njit(cache=True)
def sharpen_kernel(p: Array, R: Array, first_joint: int, q: Array) -> tuple[int, int]:
    """Give a local solution q (6,) its last digits, which come slowly near a double root.

    Returns evaluations, iterations.
    """
    descent = Descent(ROTATION_LENGTH, 1.0, 4 * BRANCH_STEPS, False)
    _, _, evaluations, iterations = refine_kernel(
        q, goal_kernel(p, R, first_joint), descent, np.empty((0, 2))
    )
    return evaluations, iterations
