"""The default for one pose: the closed form, then least squares. No swarm takes part.

Exact solutions are had from the closed form. A pose that the joints cannot hold exactly, which is
the normal case for five joints, is approached by least squares from the candidates of the closed
form. What neither finds is left to least squares from many draws. Among equals the branch nearest
to a posture is taken. The other methods fall back to this one, and say so.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.ik.kernels.branches import branches_kernel, sharpen_kernel
from scara_drake.ik.kernels.closed_form_arm import arm_branches_kernel
from scara_drake.ik.kernels.errors import confirm_kernel, error_kernel, misfit_kernel, within_kernel
from scara_drake.ik.kernels.multistart import free_search_kernel, multistart_kernel
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
from scara_drake.ik.options import RobustOptions, SearchOptions
from scara_drake.ik.result import ROBUST, ROTATION_LENGTH, Answer, Problem
from scara_drake.joints import LOWER, UPPER

Array = NDArray[np.float64]

STEPS = 12  # of least squares from each candidate
FEW_STEPS = 4  # enough where the pose is nearly held
NEARLY = 0.1  # misfit of such a candidate [m] and [rad]
# The converged position that task="position" promises [m], and how far from the best rotation
# error a branch may lie to count as equally good [rad].
EXACT_POSITION = 1e-6
BRANCH_TOLERANCE = 1e-3


def solve(problem: Problem, options: RobustOptions) -> Answer:
    """Solve one target, on the branch nearest to `nearest_to` or else to the start."""
    if problem.position_first:
        return best_local_solution(problem, options.nearest_to, options.number_of_starts())
    near = reference_posture(problem, options)
    q = np.empty(6)
    evaluations = robust_kernel(problem.p, problem.R, problem.first_joint, near, problem.seed, q)
    return Answer(q, evaluations, 0, found_by=ROBUST)


def best_local_solution(problem: Problem, near: Array | None, starts: int) -> Answer:
    """Return the local solution nearest to a posture among the best, or the best of all.

    Least squares from so many draws, and from the posture.
    """
    reference = reference_of(problem, near)
    q, errors, evaluations, iterations = branches_kernel(
        problem.p, problem.R, problem.first_joint, problem.position_first, reference,
        near is not None, problem.seed, starts,
    )  # fmt: skip
    answer = choose_branch(problem, near, q, errors)
    ev, it = sharpen(problem, answer)
    return Answer(answer, evaluations + ev, iterations + it, found_by=ROBUST)


def reference_posture(problem: Problem, options: SearchOptions) -> Array:
    """Return the posture (6,), in the joint ranges, whose branch is asked for."""
    return reference_of(problem, options.nearest_to)


def reference_of(problem: Problem, near: Array | None) -> Array:
    """Return `near` (6,), or the start without one, clipped, with the height of a still mast."""
    reference = np.clip(problem.start if near is None else np.asarray(near, float), LOWER, UPPER)
    if problem.first_joint == 1:
        reference[0] = problem.start[0]
    return reference


def choose_branch(problem: Problem, near: Array | None, q: Array, errors: Array) -> Array:
    """Return the posture (6,) nearest to `near` among the best of q (n, 6), or the best of all.

    "Best" is exact in the position (or as near as was found) and within 1e-3 rad of the smallest
    rotation error; for task "pose" the two count together.
    """
    first = problem.first_joint
    position, rotation = errors.T
    if problem.position_first:
        good = position <= max(EXACT_POSITION, 1.001 * position.min())
    else:
        inside = np.array([within_kernel(e_p, e_w, False) for e_p, e_w in errors])
        cost = np.hypot(position, ROTATION_LENGTH * rotation)
        cost[~inside] += np.inf if inside.any() else 0.0
        good = cost <= cost.min() + ROTATION_LENGTH * BRANCH_TOLERANCE
    good &= rotation <= rotation[good].min() + BRANCH_TOLERANCE
    measure = rotation
    if near is not None:
        measure = np.linalg.norm(q[:, first:] - np.asarray(near, float)[first:], axis=1)
    chosen: Array = q[int(np.argmin(np.where(good, measure, np.inf)))].copy()
    return chosen


def sharpen(problem: Problem, q: Array) -> tuple[int, int]:
    """Give the answer (6,) to a pose its last digits, in place; return evaluations, iterations.

    It stays as it is where the least sum of squares lies outside the tolerances.
    """
    if problem.position_first:
        return 0, 0
    sharp = q.copy()
    evaluations, iterations = sharpen_kernel(problem.p, problem.R, problem.first_joint, sharp)
    was_inside, is_inside = (confirm_kernel(x, problem.p, problem.R, False)[2] for x in (q, sharp))
    if is_inside or not was_inside:
        q[:] = sharp
    return evaluations, iterations


def attainable(problem: Problem, limits: bool, seed: int = 0) -> bool:
    """Return whether some posture meets the pose, within the joint ranges or without them.

    Without them every revolute joint turns freely, while the mast keeps its range.
    """
    q = problem.start.copy()
    free_search_kernel(problem.p, problem.R, problem.first_joint, limits, seed, q)
    position, rotation = error_kernel(q, problem.p, problem.R)
    return bool(within_kernel(position, rotation, False))


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
def robust_kernel(p: Array, R: Array, first_joint: int, near: Array, seed: int, q: Array) -> int:
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
        Evaluations of forward kinematics.
    """
    found, _ = nearest_solution_kernel(p, R, first_joint, near, SLACK, np.empty((MOST, 6)), q)
    if found:
        return 1
    evaluations, goal = 0, goal_kernel(p, R, first_joint)
    if first_joint == 1:
        candidates, residual = np.empty((4, 6)), np.empty(4)
        arm_branches_kernel(p, R, near[0], candidates, residual)
        evaluations = quick_approach_kernel(goal, near, candidates, residual, q)
        if evaluations >= 0:
            return evaluations
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
            return evaluations
    trial[:] = near
    ev = multistart_kernel(p, R, first_joint, seed, trial)
    position, rotation = error_kernel(trial, p, R)
    if misfit_kernel(position, rotation) < least:
        q[:] = trial
    return evaluations + ev
