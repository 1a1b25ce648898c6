"""The inverse Jacobian in a loop: the rates of a tool motion, and a few steps towards a pose."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.scratch import scratch
from scara_drake.ik.kernels.errors import error_kernel, linear_kernel, linearize_kernel
from scara_drake.ik.kernels.least_squares import Priority, bounded_step_kernel
from scara_drake.ik.kernels.postures import Bounds, Goal
from scara_drake.ik.result import ROTATION_LENGTH
from scara_drake.kinematics import tool_kinematics_kernel

Array = NDArray[np.float64]

# Second derivative of the tool point along a joint motion, at most about the reach [m/rad^2].
CURVATURE = 1.5


@njit(cache=True)
def track_pose_kernel(
    q: Array, goal: Goal, position_first: bool, max_step: Array, iterations: int
) -> tuple[float, float]:
    """Move q (6,) towards a pose by a fixed number of damped iterations, in place.

    Args:
        q: posture, in place.
        goal: pose and joints.
        position_first: the position exactly, the orientation in its null space; else both.
        max_step: largest change of each joint (6,) in this whole call [m, rad]; the move is scaled
            as a whole where one joint would exceed it.
        iterations: number of iterations.

    Returns:
        Position error [m] and rotation error [rad] of the new q.
    """
    at, dq, free, start = linear_kernel(), np.empty(6), np.empty(6), q.copy()
    bounds, first_joint = goal.bounds, goal.bounds.first_joint
    for _ in range(iterations):
        square, angle = linearize_kernel(q, goal.p, goal.R, at)
        size = np.sqrt(square) + (0.0 if position_first else ROTATION_LENGTH * angle)
        # A residual that stays bends the null space: damping of its size keeps the step short.
        extra_p, extra_w = 0.0, 0.5 * angle * angle
        scale = 1.0
        for _attempt in range(2):
            priority = Priority(position_first, extra_p, extra_w)
            bounded_step_kernel(at.J, at.e_p, at.e_w, priority, q, bounds, free, dq)
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
            q[j] = min(max(moved, bounds.lower[j]), bounds.upper[j])
        if scale < 1.0:
            break
    return error_kernel(q, goal.p, goal.R)


@njit(cache=True)
def joint_rates_kernel(
    q: Array,
    v_WE: Array,
    w_WE: Array,
    bounds: Bounds,
    position_first: bool,
    mast_rate: float,
    rates: Array,
) -> None:
    """Write the joint rates (6,) that realise a tool velocity at q (6,).

    The same damping and priority as track_pose_kernel. A joint at its limit that would leave it has
    rate zero, and the others take over.

    Args:
        q: posture.
        v_WE: velocity of the tool point (3,) [m/s], in W.
        w_WE: angular velocity of the tool (3,) [rad/s], in W.
        bounds: of the joints; the mast moves for the task, or is let move at mast_rate.
        position_first: v_WE exactly, w_WE in its null space; else both in the weighted sense.
        mast_rate: rate of the mast [m/s] where it does not move for the task; its motion of the
            tool is subtracted from the task.
        rates: result [m/s, rad/s].
    """
    p, R, J = scratch(3), scratch(3, 3), scratch(6, 6)
    v, free = scratch(3), scratch(6)
    v[:] = v_WE
    tool_kinematics_kernel(q, p, R, J)
    mast = 0.0
    if bounds.first_joint > 0:
        low, high = bounds.lower[0], bounds.upper[0]
        outward = (q[0] <= low and mast_rate < 0.0) or (q[0] >= high and mast_rate > 0.0)
        mast = 0.0 if outward else mast_rate
        v[2] -= mast
    priority = Priority(position_first, 0.0, 0.0)
    bounded_step_kernel(J, v, w_WE, priority, q, bounds, free, rates)
    if bounds.first_joint > 0:
        rates[0] = mast
