"""The default for one pose: the closed form, then least squares, then the swarm.

Exact solutions are had from the closed form. A pose that the joints cannot hold exactly, which is
the normal case for five joints, is approached by least squares from the candidates of the closed
form. What neither finds is left to DPSO. Among equals the branch nearest to a posture is taken.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.ik.kernels.closed_form_arm import arm_branches_kernel
from scara_drake.ik.kernels.dpso import dpso_kernel
from scara_drake.ik.kernels.errors import error_kernel, misfit_kernel, within_kernel
from scara_drake.ik.kernels.postures import (
    Goal,
    distance_kernel,
    goal_kernel,
    inside_kernel,
    keep_limits_kernel,
    nearest_turns_kernel,
)
from scara_drake.ik.kernels.refine import Descent, refine_kernel
from scara_drake.ik.kernels.solutions import MOST, SLACK, nearest_solution_kernel, solutions_kernel
from scara_drake.ik.result import ROTATION_LENGTH

Array = NDArray[np.float64]

STEPS = 12  # of least squares from each candidate
FEW_STEPS = 4  # enough where the pose is nearly held
NEARLY = 0.1  # misfit of such a candidate [m] and [rad]


@njit(cache=True)
def quick_approach_kernel(
    goal: Goal, near: Array, candidates: Array, residual: Array, q: Array
) -> int:
    """Try the arm's candidates that nearly hold the pose, nearest first, by a few steps each.

    Writes q (6,) and returns the evaluations, negative where none got within the tolerances.
    """
    descent, none = Descent(ROTATION_LENGTH, 1.0, FEW_STEPS, True), np.empty((0, 2))
    distance = np.empty(4)
    for k in range(4):
        nearest_turns_kernel(candidates[k], near)
        usable = residual[k] < NEARLY and inside_kernel(candidates[k])
        distance[k] = distance_kernel(candidates[k], near) if usable else np.inf
    evaluations = 0
    for _ in range(4):
        k = int(np.argmin(distance))
        if distance[k] == np.inf:
            break
        distance[k] = np.inf
        position, rotation, ev, _i = refine_kernel(candidates[k], goal, descent, none)
        evaluations += ev
        if within_kernel(position, rotation, False):
            q[:] = candidates[k]
            return evaluations
    return -evaluations - 1


@njit(cache=True)
def nearest_approach_kernel(
    goal: Goal, length: float, near: Array, q: Array
) -> tuple[float, float, int]:
    """Write the best posture (6,) that least squares finds from the closed form's candidates.

    A success nearest to `near` is preferred, else the smallest weighted error. Returns the
    errors [m], [rad] and the evaluations.
    """
    descent, none = Descent(length, 1.0, STEPS, True), np.empty((0, 2))
    candidates, residual = np.empty((MOST, 6)), np.empty(4)
    if goal.bounds.first_joint == 1:
        n = arm_branches_kernel(goal.p, goal.R, near[0], candidates, residual)
    else:
        n = solutions_kernel(goal.p, goal.R, 0, near[0], candidates)
    best_position, best_rotation, least, evaluations = np.inf, np.inf, np.inf, 0
    found = False
    for k in range(n + 1):
        trial = near.copy() if k == n else candidates[k]
        nearest_turns_kernel(trial, near)
        keep_limits_kernel(trial, goal.bounds, True)
        position, rotation, ev, _ = refine_kernel(trial, goal, descent, none)
        evaluations += ev
        nearest_turns_kernel(trial, near)
        success = within_kernel(position, rotation, False)
        measure = distance_kernel(trial, near) if success else misfit_kernel(position, rotation)
        if (success and not found) or (success == found and measure < least):
            found, least = success, measure
            best_position, best_rotation = position, rotation
            q[:] = trial
    return best_position, best_rotation, evaluations


@njit(cache=True)
def robust_kernel(
    p: Array, R: Array, first_joint: int, near: Array, seed: int, q: Array
) -> tuple[int, int]:
    """Write the posture (6,) for a pose, on the branch nearest to `near` where there is a choice.

    The entry for loops. What is not within the tolerances is the best that was found.

    Args:
        p: target (3,) [m].
        R: target (3, 3).
        first_joint: 0 moves the mast, 1 keeps the height near[0].
        near: posture (6,) inside the joint ranges.
        seed: of the draws, should it come to them.
        q: result (6,).

    Returns:
        Evaluations of forward kinematics, and iterations of the swarm.
    """
    found, _ = nearest_solution_kernel(p, R, first_joint, near, SLACK, np.empty((MOST, 6)), q)
    if found:
        return 1, 0
    evaluations, goal = 0, goal_kernel(p, R, first_joint)
    if first_joint == 1:
        candidates, residual = np.empty((4, 6)), np.empty(4)
        arm_branches_kernel(p, R, near[0], candidates, residual)
        evaluations = quick_approach_kernel(goal, near, candidates, residual, q)
        if evaluations >= 0:
            return evaluations, 0
        evaluations = -evaluations
    least = np.inf
    trial = np.empty(6)
    for length in (ROTATION_LENGTH, 0.1, 1.0):
        position, rotation, ev = nearest_approach_kernel(goal, length, near, trial)
        evaluations += ev
        misfit = misfit_kernel(position, rotation)
        if misfit < least:
            least = misfit
            q[:] = trial
        if within_kernel(position, rotation, False):
            q[:] = trial
            return evaluations, 0
    trial[:] = near
    ev, iterations = dpso_kernel(p, R, first_joint, seed, trial)
    position, rotation = error_kernel(trial, p, R)
    if misfit_kernel(position, rotation) < least:
        q[:] = trial
    return evaluations + ev, iterations
