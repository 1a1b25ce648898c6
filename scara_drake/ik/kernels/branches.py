"""Every branch of the solution: local solutions from many draws, and the choice among them.

The number of draws is always the same, so the answer depends on the seed and on nothing else.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake import joints
from scara_drake.ik.kernels.refine import (
    keep_limits_kernel,
    nearest_turns_kernel,
    refine_kernel,
    refine_position_first_kernel,
)
from scara_drake.ik.kernels.swarm import Draws, draw_posture_kernel, draws
from scara_drake.ik.result import (
    POSITION_TOLERANCE,
    ROTATION_LENGTH,
    ROTATION_TOLERANCE,
    Answer,
    Problem,
)
from scara_drake.kinematics import REACH

Array = NDArray[np.float64]

LOWER, UPPER = np.array(joints.LOWER), np.array(joints.UPPER)

# The converged position that task="position" promises [m], and how far from the best rotation
# error a branch may lie to count as equally good [rad].
EXACT_POSITION = 1e-6
BRANCH_TOLERANCE = 1e-3
BRANCH_STEPS = 60


@njit(cache=True)
def mirror_kernel(q: Array, mirrored: Array) -> None:
    """Write the other posture (6,) of the same tool pose: the beam turned by half a turn.

    T(θ3 + π, π - θ4, π - θ5, θ6 + π) = T(θ3, θ4, θ5, θ6); θ4 and θ5 come out within ±π.
    """
    mirrored[:] = q
    mirrored[2] = q[2] + np.pi if q[2] <= 0.0 else q[2] - np.pi
    mirrored[3] = np.pi - q[3] if q[3] > 0.0 else -np.pi - q[3]
    mirrored[4] = np.pi - q[4] if q[4] > 0.0 else -np.pi - q[4]
    mirrored[5] = q[5] + np.pi if q[5] <= 0.0 else q[5] - np.pi


@njit(cache=True)
def branches_kernel(
    p: Array,
    R: Array,
    first_joint: int,
    position_first: bool,
    low: Array,
    high: Array,
    lower: Array,
    upper: Array,
    near: Array,
    from_near: bool,
    state: Draws,
    q: Array,
    errors: Array,
) -> tuple[int, int]:
    """Fill q (n, 6) and errors (n, 2) with local solutions.

    The first starts from `near` where `from_near` is set, every second one from the mirror of the
    one before, the others from draws; theta2, theta3 and theta6 end nearest to `near`. Returns
    evaluations, iterations.
    """
    none = np.empty((0, 2))
    evaluations, iterations = 0, 0
    for k in range(q.shape[0]):
        if k % 2 == 1:
            mirror_kernel(q[k - 1], q[k])
            keep_limits_kernel(q[k], first_joint, lower, upper, True)
        else:
            q[k] = near
            if k > 0 or not from_near:
                draw_posture_kernel(state, low, high, first_joint, q[k])
        if position_first:
            e_p, e_w, ev, it = refine_position_first_kernel(
                q[k], p, R, first_joint, lower, upper, 1.0, BRANCH_STEPS, True, none
            )
        else:
            e_p, e_w, ev, it = refine_kernel(
                q[k], p, R, first_joint, ROTATION_LENGTH, lower, upper, 1.0, BRANCH_STEPS, True,
                none,
            )  # fmt: skip
        errors[k, 0], errors[k, 1] = e_p, e_w
        nearest_turns_kernel(q[k], near, lower, upper)
        evaluations += ev
        iterations += it
    return evaluations, iterations


def search_box(p: Array) -> tuple[Array, Array]:
    """Box (6,), (6,) of the draws: the joint ranges, the mast only where the arm can reach p."""
    low, high = LOWER.copy(), UPPER.copy()
    low[0] = np.clip(p[2] - REACH, LOWER[0], UPPER[0])
    high[0] = np.clip(p[2] + REACH, LOWER[0], UPPER[0])
    return low, high


def best_branch(problem: Problem, near: Array | None, starts: int) -> Answer:
    """Return the local solution nearest to a posture among the best, or the best of all.

    "Best" is exact in the position (or as near as was found) and within 1e-3 rad of the smallest
    rotation error; for task "pose" the two count together.
    """
    low, high = search_box(problem.p)
    first = problem.first_joint
    reference = (problem.start if near is None else np.asarray(near, dtype=np.float64)).copy()
    begin = np.clip(reference, LOWER, UPPER)
    if first == 1:
        begin[0] = problem.start[0]
    q, errors = np.empty((starts, 6)), np.empty((starts, 2))
    evaluations, iterations = branches_kernel(
        problem.p, problem.R, first, problem.position_first, low, high, LOWER, UPPER, begin,
        near is not None, draws(problem.seed), q, errors,
    )  # fmt: skip
    position, rotation = errors.T
    if problem.position_first:
        good = position <= max(EXACT_POSITION, 1.001 * position.min())
    else:
        cost = np.hypot(position, ROTATION_LENGTH * rotation)
        good = cost <= cost.min() + ROTATION_LENGTH * BRANCH_TOLERANCE
        inside = (position <= POSITION_TOLERANCE) & (rotation <= ROTATION_TOLERANCE)
        good = good & inside if np.any(good & inside) else good
    good &= rotation <= rotation[good].min() + BRANCH_TOLERANCE
    measure = rotation if near is None else np.linalg.norm(q[:, first:] - reference[first:], axis=1)
    chosen = int(np.argmin(np.where(good, measure, np.inf)))
    answer = q[chosen].copy()
    if not problem.position_first:
        # Near a double root the last digits come slowly.
        *_, ev, it = refine_kernel(
            answer, problem.p, problem.R, first, ROTATION_LENGTH, LOWER, UPPER, 1.0,
            4 * BRANCH_STEPS, False, np.empty((0, 2)),
        )  # fmt: skip
        evaluations, iterations = evaluations + ev, iterations + it
    return Answer(answer, evaluations, iterations)
