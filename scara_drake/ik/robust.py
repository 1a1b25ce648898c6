"""The default for one pose: the closed form, then least squares, then the swarm.

Exact solutions are had from the closed form. A pose that the joints cannot hold exactly, which is
the normal case for five joints, is approached by least squares from the candidates of the closed
form. What neither finds is left to DPSO. Among equals the branch nearest to a posture is taken.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.ik.dpso import dpso_kernel
from scara_drake.ik.kernels.branches import LOWER, UPPER
from scara_drake.ik.kernels.closed_form_arm import arm_branches_kernel, arm_solutions_kernel
from scara_drake.ik.kernels.closed_form_mast import mast_branches_kernel
from scara_drake.ik.kernels.refine import (
    error_kernel,
    keep_limits_kernel,
    nearest_turns_kernel,
    refine_kernel,
)
from scara_drake.ik.result import POSITION_TOLERANCE, ROTATION_LENGTH, ROTATION_TOLERANCE

Array = NDArray[np.float64]

STEPS = 12  # of least squares from each candidate
FEW_STEPS = 4  # enough where the pose is nearly held
NEARLY = 0.1  # misfit of such a candidate [m] and [rad]
CANDIDATES = 24
ROUNDING = 1e-9  # of a solution at a joint limit [m], [rad]


@njit(cache=True)
def distance_kernel(q: Array, near: Array) -> float:
    """Square of the distance between two postures (6,), metres and radians alike."""
    s = 0.0
    for j in range(6):
        s += (q[j] - near[j]) * (q[j] - near[j])
    return s


@njit(cache=True)
def inside_kernel(q: Array) -> bool:
    """Whether a posture (6,) is inside the joint ranges."""
    for j in range(6):  # noqa: SIM110 (numba compiles no generator in `all`)
        if not LOWER[j] <= q[j] <= UPPER[j]:
            return False
    return True


@njit(cache=True)
def settle_kernel(q: Array) -> None:
    """Put the joints of q (6,) that are past a limit by rounding onto it, in place."""
    for j in range(6):
        if LOWER[j] - ROUNDING <= q[j] <= UPPER[j] + ROUNDING:
            q[j] = min(max(q[j], LOWER[j]), UPPER[j])


@njit(cache=True)
def nearest_solution_kernel(p: Array, R: Array, first_joint: int, near: Array, q: Array) -> bool:
    """Write the closed-form solution (6,) nearest to a posture and inside the limits, if any."""
    solutions = np.empty((CANDIDATES, 6))
    if first_joint == 1:
        n = arm_solutions_kernel(p, R, near[0], solutions)
    else:
        n = mast_branches_kernel(p, R, solutions)
    least = np.inf
    for k in range(n):
        nearest_turns_kernel(solutions[k], near, LOWER, UPPER)
        settle_kernel(solutions[k])
        distance = distance_kernel(solutions[k], near)
        if distance < least and inside_kernel(solutions[k]):
            least = distance
            q[:] = solutions[k]
    return least < np.inf


@njit(cache=True)
def quick_approach_kernel(
    p: Array, R: Array, near: Array, candidates: Array, residual: Array, q: Array
) -> int:
    """Try the arm's candidates that nearly hold the pose, nearest first, by a few steps each.

    Writes q (6,) and returns the evaluations, negative where none got within the tolerances.
    """
    none = np.empty((0, 2))
    distance = np.empty(4)
    for k in range(4):
        nearest_turns_kernel(candidates[k], near, LOWER, UPPER)
        usable = residual[k] < NEARLY and inside_kernel(candidates[k])
        distance[k] = distance_kernel(candidates[k], near) if usable else np.inf
    evaluations = 0
    for _ in range(4):
        k = int(np.argmin(distance))
        if distance[k] == np.inf:
            break
        distance[k] = np.inf
        position, rotation, ev, _i = refine_kernel(
            candidates[k], p, R, 1, ROTATION_LENGTH, LOWER, UPPER, 1.0, FEW_STEPS, True, none
        )
        evaluations += ev
        if position <= POSITION_TOLERANCE and rotation <= ROTATION_TOLERANCE:
            q[:] = candidates[k]
            return evaluations
    return -evaluations - 1


@njit(cache=True)
def nearest_approach_kernel(
    p: Array, R: Array, first_joint: int, length: float, near: Array, q: Array
) -> tuple[float, float, int]:
    """Write the best posture (6,) that least squares finds from the closed form's candidates.

    A success nearest to `near` is preferred, else the smallest weighted error. Returns the
    errors [m], [rad] and the evaluations.
    """
    none = np.empty((0, 2))
    candidates, residual = np.empty((CANDIDATES, 6)), np.empty(4)
    if first_joint == 1:
        n = arm_branches_kernel(p, R, near[0], candidates, residual)
    else:
        n = mast_branches_kernel(p, R, candidates)
    best_position, best_rotation, least, evaluations = np.inf, np.inf, np.inf, 0
    found = False
    for k in range(n + 1):
        trial = near.copy() if k == n else candidates[k]
        nearest_turns_kernel(trial, near, LOWER, UPPER)
        keep_limits_kernel(trial, first_joint, LOWER, UPPER, True)
        position, rotation, ev, _ = refine_kernel(
            trial, p, R, first_joint, length, LOWER, UPPER, 1.0, STEPS, True, none
        )
        evaluations += ev
        nearest_turns_kernel(trial, near, LOWER, UPPER)
        success = position <= POSITION_TOLERANCE and rotation <= ROTATION_TOLERANCE
        if success:
            measure = distance_kernel(trial, near)
        else:
            measure = (position / POSITION_TOLERANCE) ** 2 + (rotation / ROTATION_TOLERANCE) ** 2
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
    if nearest_solution_kernel(p, R, first_joint, near, q):
        return 1, 0
    evaluations = 0
    if first_joint == 1:
        candidates, residual = np.empty((4, 6)), np.empty(4)
        arm_branches_kernel(p, R, near[0], candidates, residual)
        evaluations = quick_approach_kernel(p, R, near, candidates, residual, q)
        if evaluations >= 0:
            return evaluations, 0
        evaluations = -evaluations
    least = np.inf
    trial = np.empty(6)
    for length in (ROTATION_LENGTH, 0.1, 1.0):
        position, rotation, ev = nearest_approach_kernel(p, R, first_joint, length, near, trial)
        evaluations += ev
        measure = (position / POSITION_TOLERANCE) ** 2 + (rotation / ROTATION_TOLERANCE) ** 2
        if measure < least:
            least = measure
            q[:] = trial
        if position <= POSITION_TOLERANCE and rotation <= ROTATION_TOLERANCE:
            q[:] = trial
            return evaluations, 0
    trial[:] = near
    ev, iterations = dpso_kernel(p, R, first_joint, seed, trial)
    position, rotation = error_kernel(trial, p, R)
    if (position / POSITION_TOLERANCE) ** 2 + (rotation / ROTATION_TOLERANCE) ** 2 < least:
        q[:] = trial
    return evaluations + ev, iterations
