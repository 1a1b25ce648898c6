"""The inverse Jacobian: as a solver from a seed, along a path, and inside a 1 kHz loop."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.ik.kernels.branches import LOWER, UPPER
from scara_drake.ik.kernels.least_squares import bounded_step_kernel
from scara_drake.ik.kernels.refine import error_kernel, refine_kernel, refine_position_first_kernel
from scara_drake.ik.options import InverseJacobianOptions
from scara_drake.ik.result import (
    POSITION_TOLERANCE,
    ROTATION_LENGTH,
    ROTATION_TOLERANCE,
    Answer,
    PathAnswer,
    Problem,
)
from scara_drake.kinematics import rotation_vector_kernel, tool_kinematics_kernel

Array = NDArray[np.float64]


# Second derivative of the tool point along a joint motion, at most about the reach [m/rad^2].
CURVATURE = 1.5


@njit(cache=True)
def track_pose_kernel(
    q: Array,
    p_desired: Array,
    R_desired: Array,
    first_joint: int,
    position_first: bool,
    lower: Array,
    upper: Array,
    max_step: Array,
    iterations: int,
) -> tuple[float, float]:
    """Move q (6,) towards a pose by a fixed number of damped iterations, in place.

    Args:
        q: posture, in place.
        p_desired: (3,) [m].
        R_desired: (3, 3).
        first_joint: 0 moves the mast too, 1 keeps it.
        position_first: the position exactly, the orientation in its null space; else both.
        lower: joint limits (6,).
        upper: joint limits (6,).
        max_step: largest change of each joint (6,) in this whole call [m, rad]; the move is scaled
            as a whole where one joint would exceed it.
        iterations: number of iterations.

    Returns:
        Position error [m] and rotation error [rad] of the new q.
    """
    p, R, J = np.empty(3), np.empty((3, 3)), np.empty((6, 6))
    e_p, e_w, dq, free, start = np.empty(3), np.empty(3), np.empty(6), np.empty(6), q.copy()
    for _ in range(iterations):
        tool_kinematics_kernel(q, p, R, J)
        angle = rotation_vector_kernel(R_desired, R, e_w)
        size = 0.0
        for i in range(3):
            e_p[i] = p_desired[i] - p[i]
            size += e_p[i] * e_p[i]
        size = np.sqrt(size) + (0.0 if position_first else ROTATION_LENGTH * angle)
        # A residual that stays bends the null space: damping of its size keeps the step short.
        extra_p, extra_w = 0.0, 0.5 * angle * angle
        scale = 1.0
        for _attempt in range(2):
            bounded_step_kernel(
                J, e_p, e_w, position_first, extra_p, extra_w, q, first_joint, lower, upper, free,
                dq,
            )  # fmt: skip
            scale = 1.0
            for j in range(first_joint, 6):
                move = abs(q[j] + dq[j] - start[j])
                if move > max_step[j]:
                    scale = min(scale, max_step[j] / move)
            if scale == 1.0:
                break
            # Too far for one call. The residual times the curvature of the motion, as damping,
            # keeps a direction that is nearly lost from taking the whole step.
            extra_p, extra_w = CURVATURE * size, max(extra_w, 0.5 * angle)
        for j in range(first_joint, 6):
            moved = start[j] + scale * (q[j] + dq[j] - start[j])
            q[j] = min(max(moved, lower[j]), upper[j])
        if scale < 1.0:
            break
    return error_kernel(q, p_desired, R_desired)


@njit(cache=True)
def joint_rates_kernel(
    q: Array,
    v_WE: Array,
    w_WE: Array,
    first_joint: int,
    position_first: bool,
    mast_rate: float,
    lower: Array,
    upper: Array,
    rates: Array,
) -> None:
    """Write the joint rates (6,) that realise a tool velocity at q (6,).

    The same damping and priority as track_pose_kernel. A joint at its limit that would leave it has
    rate zero, and the others take over.

    Args:
        q: posture.
        v_WE: velocity of the tool point (3,) [m/s], in W.
        w_WE: angular velocity of the tool (3,) [rad/s], in W.
        first_joint: 0 moves the mast for the task, 1 lets it move at mast_rate.
        position_first: v_WE exactly, w_WE in its null space; else both in the weighted sense.
        mast_rate: rate of the mast [m/s] where first_joint is 1; its motion of the tool is
            subtracted from the task.
        lower: joint limits (6,).
        upper: joint limits (6,).
        rates: result [m/s, rad/s].
    """
    p, R, J = np.empty(3), np.empty((3, 3)), np.empty((6, 6))
    v, free = v_WE.copy(), np.empty(6)
    tool_kinematics_kernel(q, p, R, J)
    mast = 0.0
    if first_joint > 0:
        outward = (q[0] <= lower[0] and mast_rate < 0.0) or (q[0] >= upper[0] and mast_rate > 0.0)
        mast = 0.0 if outward else mast_rate
        v[2] -= mast
    bounded_step_kernel(
        J, v, w_WE, position_first, 0.0, 0.0, q, first_joint, lower, upper, free, rates
    )
    if first_joint > 0:
        rates[0] = mast


@njit(cache=True)
def _solve_kernel(
    q: Array,
    p: Array,
    R: Array,
    first_joint: int,
    position_first: bool,
    length: float,
    lower: Array,
    upper: Array,
    step: float,
    iterations: int,
    wrap: bool,
    history: Array,
) -> tuple[float, float, int, int]:
    if position_first and length > 0.0:
        return refine_position_first_kernel(
            q, p, R, first_joint, lower, upper, step, iterations, wrap, history
        )
    return refine_kernel(
        q, p, R, first_joint, length, lower, upper, step, iterations, wrap, history
    )


@njit(cache=True)
def follow_kernel(
    start: Array,
    p: Array,
    R: Array,
    first_joint: int,
    position_first: bool,
    length: float,
    lower: Array,
    upper: Array,
    step: float,
    max_change: float,
    iterations: int,
    begin: int,
    stop_on_failure: bool,
    q: Array,
    evaluations: NDArray[np.int64],
    steps: NDArray[np.int64],
) -> int:
    """Follow the targets p (n, 3), R (n, 3, 3) from index `begin`, each from the answer before.

    Writes q (n, 6) and the work (n,). A posture further than `max_change` from the one before is
    drawn back along the way. Returns the index of the first point outside the tolerance where
    `stop_on_failure`, else n.
    """
    none = np.empty((0, 2))
    before, pace = start.copy(), np.zeros(6)
    if begin > 1:
        pace[:] = before - q[begin - 2]
    for k in range(begin, p.shape[0]):
        evaluations[k], steps[k] = 0, 0
        good = False
        # From where the motion would carry on, which passes through a singular posture instead of
        # turning back there; else from the posture before.
        for attempt in range(2):
            for j in range(6):
                ahead = before[j] + (pace[j] if attempt == 0 else 0.0)
                q[k, j] = min(max(ahead, lower[j]), upper[j]) if j >= first_joint else before[j]
            position, rotation, ev, it = _solve_kernel(
                q[k], p[k], R[k], first_joint, position_first, length, lower, upper, step,
                iterations, False, none,
            )  # fmt: skip
            evaluations[k] += ev
            steps[k] += it
            largest = 0.0
            for j in range(6):
                largest = max(largest, abs(q[k, j] - before[j]))
            good = position <= POSITION_TOLERANCE and (
                position_first or rotation <= ROTATION_TOLERANCE
            )
            good = good and largest <= max_change
            if good:
                break
        if not good and largest > max_change:
            for j in range(6):
                q[k, j] = before[j] + (q[k, j] - before[j]) * max_change / largest
        if stop_on_failure and not good:
            return k
        pace[:] = q[k] - before
        before[:] = q[k]
    return p.shape[0]


def _length(options: InverseJacobianOptions) -> float:
    return ROTATION_LENGTH if options.rows == "full" else 0.0


def solve(problem: Problem, options: InverseJacobianOptions) -> Answer:
    """Solve one target from the seed: full rows, position first, or the paper's position rows."""
    q = problem.start.copy()
    history = np.empty((options.max_iterations + 1 if options.history else 0, 2))
    *_, evaluations, iterations = _solve_kernel(
        q, problem.p, problem.R, problem.first_joint, problem.position_first, _length(options),
        LOWER, UPPER, options.max_step, options.max_iterations, True, history,
    )  # fmt: skip
    return Answer(
        q, evaluations, iterations, history[: iterations + 1] if options.history else None
    )


def follow(problems: Sequence[Problem], options: InverseJacobianOptions) -> PathAnswer:
    """Solve a path, the first target from the seed and each next one from the answer before."""
    first = solve(problems[0], options)
    p = np.array([problem.p for problem in problems])
    R = np.array([problem.R for problem in problems])
    n = len(problems)
    q, evaluations, steps = np.empty((n, 6)), np.zeros(n, np.int64), np.zeros(n, np.int64)
    q[0], evaluations[0], steps[0] = first.q, first.evaluations, first.iterations
    follow_kernel(
        first.q, p, R, problems[0].first_joint, problems[0].position_first, _length(options),
        LOWER, UPPER, options.max_step, np.inf, options.max_iterations, 1, False,
        q, evaluations, steps,
    )  # fmt: skip
    return PathAnswer(q, evaluations, steps)
