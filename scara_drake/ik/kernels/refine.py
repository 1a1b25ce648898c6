"""Local solutions: Levenberg-Marquardt on the pose, and motion along the position's self-motion.

Both keep the joint ranges at every step. With `wrap` the joints of more than one turn (theta2,
theta3, theta6) re-enter at the other side, which a solver may do and a moving robot may not.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.ik.kernels.errors import Linear, linear_kernel, linearize_kernel
from scara_drake.ik.kernels.least_squares import (
    Priority,
    bounded_step_kernel,
    cholesky_kernel,
    normal_equations_kernel,
    substitute_kernel,
)
from scara_drake.ik.kernels.postures import Bounds, Goal, keep_limits_kernel, turns_kernel
from scara_drake.ik.result import ROTATION_LENGTH
from scara_drake.kinematics import rotation_vector_kernel, tool_kinematics_kernel

Array = NDArray[np.float64]

EXACT = 1e-9  # a position error [m], or its equivalent in rad, that ends the iterations


class Descent(NamedTuple):
    """How a posture is refined.

    Attributes:
        length: weight of the rotation [m/rad]; 0 leaves the position rows (26) alone.
        step: largest change of a joint in one iteration [rad], [m].
        iterations: budget.
        wrap: whole turns instead of the limits of theta2, theta3, theta6.
    """

    length: float
    step: float
    iterations: int
    wrap: bool


class Equations(NamedTuple):
    """The linear equations of one step.

    Attributes:
        H: J^T W J (6, 6), lower triangle.
        L: its damped copy (6, 6), then the Cholesky factor of that.
        g: J^T W e (6,).
        dq: step (6,).
        free: 1 for a joint that moves, 0 for one that is held (6,).
    """

    H: Array
    L: Array
    g: Array
    dq: Array
    free: Array


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
def _equations(q: Array, at: Linear, bounds: Bounds, descent: Descent, system: Equations) -> None:
    """Write H and g at q (6,), with the joints held that sit at a limit and would leave it."""
    H, g, free = system.H, system.g, system.free
    for j in range(6):
        free[j] = 1.0 if j >= bounds.first_joint else 0.0
    normal_equations_kernel(at.J, at.e_p, at.e_w, descent.length, free, H, g)
    held = False
    for j in range(bounds.first_joint, 6):
        if descent.wrap and turns_kernel(j):
            continue
        if (q[j] <= bounds.lower[j] and g[j] < 0.0) or (q[j] >= bounds.upper[j] and g[j] > 0.0):
            free[j] = 0.0
            held = True
    if held:
        normal_equations_kernel(at.J, at.e_p, at.e_w, descent.length, free, H, g)


@njit(cache=True)
def _damped_step(system: Equations, damping: float) -> None:
    """Write the step dq that solves the equations with the damping added."""
    H, L, g, dq = system.H, system.L, system.g, system.dq
    for j in range(6):
        dq[j] = g[j]
        for k in range(j + 1):
            L[j, k] = H[j, k]
        L[j, j] += damping
    cholesky_kernel(L, 6)
    substitute_kernel(L, dq, 6)


@njit(cache=True)
def refine_kernel(
    q: Array, goal: Goal, descent: Descent, history: Array
) -> tuple[float, float, int, int]:
    r"""Minimise |p_d - p|^2 + length^2 angle^2 from q (6,), in place (Levenberg-Marquardt).

    A step is the paper's inverse Jacobian, (1) to (10), with damping :math:`\mu`, as its (8)
    inverts :math:`J J^\top`, which has no inverse for five joints:

    .. math::

        \Delta q = (J^\top W J + \mu I)^{-1}\, J^\top W\, e, \quad e = (e_p, e_\omega), \quad
        W = \operatorname{diag}(1, \text{length}^2)

    Args:
        q: posture, in place.
        goal: pose and joints.
        descent: weight, step and budget.
        history: (h, 2), receives the errors of the first h iterations; (0, 2) for none.

    Returns:
        Position error [m], rotation error [rad], evaluations, iterations.
    """
    at, trial = linear_kernel(), q.copy()
    system = Equations(
        np.empty((6, 6)), np.empty((6, 6)), np.empty(6), np.empty(6), np.empty(6)
    )  # fmt: skip
    mu, cost, position, rotation = 1e-3, np.inf, np.inf, np.inf
    evaluations, iteration = 0, 0
    while True:
        square, trial_rotation = linearize_kernel(trial, goal.p, goal.R, at)
        evaluations += 1
        length = descent.length
        trial_cost = square + length * length * trial_rotation * trial_rotation
        if trial_cost < cost:
            stalled = cost - trial_cost < 1e-9 * cost
            cost, position, rotation = trial_cost, np.sqrt(square), trial_rotation
            q[:] = trial
            mu = max(0.1 * mu, 1e-6)
            _equations(q, at, goal.bounds, descent, system)
        else:
            stalled = mu > 1e9
            mu *= 10.0
        if iteration < history.shape[0]:
            history[iteration, 0], history[iteration, 1] = position, rotation
        if cost < EXACT * EXACT or stalled or iteration >= descent.iterations:
            return position, rotation, evaluations, iteration
        _damped_step(system, mu * cost + 1e-12)
        if _limit_step(system.dq, descent.step) < 1e-12:
            return position, rotation, evaluations, iteration
        for j in range(6):
            trial[j] = q[j] + system.dq[j]
        keep_limits_kernel(trial, goal.bounds, descent.wrap)
        iteration += 1


@njit(cache=True)
def refine_position_first_kernel(
    q: Array, goal: Goal, descent: Descent, history: Array
) -> tuple[float, float, int, int]:
    """Reach the position from q (6,), then turn towards the rotation without leaving it; in place.

    Arguments as refine_kernel, without the length.
    """
    step, budget, wrap = descent.step, descent.iterations, descent.wrap
    # Together first: on a pose that can be reached this is already the answer.
    position, rotation, evaluations, iterations = refine_kernel(
        q, goal, Descent(ROTATION_LENGTH, step, budget, wrap), history
    )
    if position < EXACT and rotation < EXACT / ROTATION_LENGTH:
        return position, rotation, evaluations, iterations
    position, rotation, n, i = refine_kernel(
        q, goal, Descent(0.0, step, budget, wrap), history[iterations:]
    )
    evaluations += n
    position, rotation, n, iterations = _turn_in_place(
        q, goal, descent, position, rotation, history, iterations + i
    )
    return position, rotation, evaluations + n, iterations


@njit(cache=True)
def _turn_in_place(
    q: Array,
    goal: Goal,
    descent: Descent,
    position: float,
    rotation: float,
    history: Array,
    iteration: int,
) -> tuple[float, float, int, int]:
    """Turn q (6,), whose errors are given, towards the rotation with the position held; in place.

    Each move is a damped step in the null space of the position rows, brought back onto the
    position, and accepted where the rotation error falls. Returns the errors, the evaluations, and
    the count of iterations that goes on from `iteration`.
    """
    p, R, J = np.empty(3), np.empty((3, 3)), np.empty((6, 6))
    e_p, e_w, trial, dq, free = np.zeros(3), np.empty(3), np.empty(6), np.empty(6), np.empty(6)
    evaluations, mu, fresh = 0, 1e-2, True
    back = Descent(0.0, descent.step, 8, descent.wrap)
    for _ in range(descent.iterations):
        iteration += 1
        if iteration < history.shape[0]:
            history[iteration, 0], history[iteration, 1] = position, rotation
        if fresh:
            tool_kinematics_kernel(q, p, R, J)
            rotation_vector_kernel(goal.R, R, e_w)
        bounded_step_kernel(J, e_p, e_w, Priority(True, 0.0, mu), q, goal.bounds, free, dq)
        if _limit_step(dq, descent.step) < 1e-10:
            break
        for j in range(6):
            trial[j] = q[j] + dq[j]
        keep_limits_kernel(trial, goal.bounds, descent.wrap)
        p_new, r_new, n, _i = refine_kernel(trial, goal, back, np.empty((0, 2)))
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
