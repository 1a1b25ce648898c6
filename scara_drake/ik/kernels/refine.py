"""Local solutions: Levenberg-Marquardt on the pose, and motion along the position's self-motion.

Both keep the joint ranges at every step. With `wrap` the joints of more than one turn (theta2,
theta3, theta6) re-enter at the other side, which a solver may do and a moving robot may not.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.ik.kernels.least_squares import (
    bounded_step_kernel,
    cholesky_kernel,
    normal_equations_kernel,
    substitute_kernel,
)
from scara_drake.ik.result import ROTATION_LENGTH
from scara_drake.kinematics import rotation_vector_kernel, tool_kinematics_kernel, tool_pose_kernel

Array = NDArray[np.float64]

EXACT = 1e-9  # a position error [m], or its equivalent in rad, that ends the iterations


@njit(cache=True)
def error_kernel(q: Array, p_desired: Array, R_desired: Array) -> tuple[float, float]:
    """Position [m] and rotation [rad] error of one posture (6,)."""
    p, R, w = np.empty(3), np.empty((3, 3)), np.empty(3)
    tool_pose_kernel(q, p, R)
    rotation = rotation_vector_kernel(R_desired, R, w)
    x, y, z = p_desired[0] - p[0], p_desired[1] - p[1], p_desired[2] - p[2]
    return np.sqrt(x * x + y * y + z * z), rotation


@njit(cache=True)
def keep_limits_kernel(q: Array, first_joint: int, lower: Array, upper: Array, wrap: bool) -> None:
    """Bring q (6,) inside the limits: whole turns where allowed, else the nearest limit."""
    for j in range(first_joint, 6):
        if wrap and (j == 1 or j == 2 or j == 5):
            while q[j] > upper[j]:
                q[j] -= 2.0 * np.pi
            while q[j] < lower[j]:
                q[j] += 2.0 * np.pi
        q[j] = min(max(q[j], lower[j]), upper[j])


@njit(cache=True)
def nearest_turns_kernel(q: Array, reference: Array, lower: Array, upper: Array) -> None:
    """Turn theta2, theta3 and theta6 of q (6,) by whole turns to lie nearest to a posture."""
    for j in (1, 2, 5):
        turned = q[j] + 2.0 * np.pi * np.round((reference[j] - q[j]) / (2.0 * np.pi))
        if turned > upper[j]:
            turned -= 2.0 * np.pi
        elif turned < lower[j]:
            turned += 2.0 * np.pi
        if lower[j] <= turned <= upper[j]:
            q[j] = turned


@njit(cache=True)
def _limit_step(dq: Array, step: float) -> float:
    largest = 0.0
    for j in range(6):
        largest = max(largest, abs(dq[j]))
    if largest > step:
        for j in range(6):
            dq[j] *= step / largest
    return largest


@njit(cache=True)
def refine_kernel(
    q: Array,
    p_desired: Array,
    R_desired: Array,
    first_joint: int,
    length: float,
    lower: Array,
    upper: Array,
    step: float,
    iterations: int,
    wrap: bool,
    history: Array,
) -> tuple[float, float, int, int]:
    """Minimise |p_d - p|^2 + length^2 angle^2 from q (6,), in place (Levenberg-Marquardt).

    The paper's inverse Jacobian, (1) to (10), with damping where its (8) inverts a matrix of
    deficient rank; length = 0 leaves the position rows (26) alone.

    Args:
        q: posture, in place.
        p_desired: (3,) [m].
        R_desired: (3, 3).
        first_joint: 0 or 1; joints before it are held.
        length: weight of the rotation [m/rad].
        lower: joint limits (6,).
        upper: joint limits (6,).
        step: largest change of a joint in one iteration [rad], [m].
        iterations: budget.
        wrap: whole turns instead of the limits of theta2, theta3, theta6.
        history: (h, 2), receives the errors of the first h iterations; (0, 2) for none.

    Returns:
        Position error [m], rotation error [rad], evaluations, iterations.
    """
    p, R, J = np.empty(3), np.empty((3, 3)), np.empty((6, 6))
    e_p, e_w, trial = np.empty(3), np.empty(3), np.empty(6)
    H, L, g, dq, free = np.empty((6, 6)), np.empty((6, 6)), np.empty(6), np.empty(6), np.empty(6)
    mu, cost, position, rotation = 1e-3, np.inf, np.inf, np.inf
    exact = EXACT * EXACT
    evaluations, iteration = 0, 0
    trial[:] = q
    while True:
        tool_kinematics_kernel(trial, p, R, J)
        evaluations += 1
        trial_rotation = rotation_vector_kernel(R_desired, R, e_w)
        square = 0.0
        for i in range(3):
            e_p[i] = p_desired[i] - p[i]
            square += e_p[i] * e_p[i]
        trial_cost = square + length * length * trial_rotation * trial_rotation
        if trial_cost < cost:
            stalled = cost - trial_cost < 1e-9 * cost
            cost, position, rotation = trial_cost, np.sqrt(square), trial_rotation
            q[:] = trial
            mu = max(0.1 * mu, 1e-6)
            for j in range(6):
                free[j] = 1.0 if j >= first_joint else 0.0
            normal_equations_kernel(J, e_p, e_w, length, free, H, g)
            held = False
            for j in range(first_joint, 6):
                if wrap and (j == 1 or j == 2 or j == 5):
                    continue
                if (q[j] <= lower[j] and g[j] < 0.0) or (q[j] >= upper[j] and g[j] > 0.0):
                    free[j] = 0.0
                    held = True
            if held:
                normal_equations_kernel(J, e_p, e_w, length, free, H, g)
        else:
            stalled = mu > 1e9
            mu *= 10.0
        if iteration < history.shape[0]:
            history[iteration, 0], history[iteration, 1] = position, rotation
        if cost < exact or stalled or iteration >= iterations:
            return position, rotation, evaluations, iteration
        for j in range(6):
            dq[j] = g[j]
            for k in range(j + 1):
                L[j, k] = H[j, k]
            L[j, j] += mu * cost + 1e-12
        cholesky_kernel(L, 6)
        substitute_kernel(L, dq, 6)
        if _limit_step(dq, step) < 1e-12:
            return position, rotation, evaluations, iteration
        for j in range(6):
            trial[j] = q[j] + dq[j]
        keep_limits_kernel(trial, first_joint, lower, upper, wrap)
        iteration += 1


@njit(cache=True)
def refine_position_first_kernel(
    q: Array,
    p_desired: Array,
    R_desired: Array,
    first_joint: int,
    lower: Array,
    upper: Array,
    step: float,
    iterations: int,
    wrap: bool,
    history: Array,
) -> tuple[float, float, int, int]:
    """Reach the position from q (6,), then turn towards R_desired without leaving it; in place.

    Each move is a damped step in the null space of the position rows, brought back onto the
    position, and accepted where the rotation error falls. Arguments as refine_kernel.
    """
    none = np.empty((0, 2))
    p, R, J = np.empty(3), np.empty((3, 3)), np.empty((6, 6))
    e_p, e_w, trial = np.empty(3), np.empty(3), np.empty(6)
    dq, free = np.empty(6), np.empty(6)
    # Together first: on a pose that can be reached this is already the answer.
    position, rotation, evaluations, iteration = refine_kernel(
        q, p_desired, R_desired, first_joint, ROTATION_LENGTH, lower, upper, step, iterations,
        wrap, history,
    )  # fmt: skip
    if position < EXACT and rotation < EXACT / ROTATION_LENGTH:
        return position, rotation, evaluations, iteration
    position, rotation, n, i = refine_kernel(
        q, p_desired, R_desired, first_joint, 0.0, lower, upper, step, iterations, wrap, none
    )
    evaluations += n
    iteration += i
    mu = 1e-2
    fresh = True
    for _ in range(iterations):
        iteration += 1
        if iteration < history.shape[0]:
            history[iteration, 0], history[iteration, 1] = position, rotation
        if fresh:
            tool_kinematics_kernel(q, p, R, J)
            rotation_vector_kernel(R_desired, R, e_w)
            e_p[:] = 0.0
        bounded_step_kernel(J, e_p, e_w, True, 0.0, mu, q, first_joint, lower, upper, free, dq)
        if _limit_step(dq, step) < 1e-10:
            break
        for j in range(6):
            trial[j] = q[j] + dq[j]
        keep_limits_kernel(trial, first_joint, lower, upper, wrap)
        p_new, r_new, n, _i = refine_kernel(
            trial, p_desired, R_desired, first_joint, 0.0, lower, upper, step, 8, wrap, none
        )
        evaluations += n + 1
        fresh = p_new <= 1.001 * position + EXACT and r_new < rotation
        if fresh:
            gain = rotation - r_new
            q[:] = trial
            position, rotation = p_new, r_new
            mu = max(0.2 * mu, 1e-9)
            if gain < 1e-9:
                break
        else:
            mu *= 5.0
            if mu > 1e4:
                break
    return position, rotation, evaluations, iteration
