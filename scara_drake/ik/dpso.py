"""Dual particle swarm optimisation, and the traditional PSO beside it; see `kernels`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scara_drake.ik.kernels.branches import branches_kernel, sharpen_kernel
from scara_drake.ik.kernels.dpso import (
    dpso_kernel,
    dual_search_kernel,
    free_search_kernel,
    position_search_kernel,
    single_search_kernel,
)
from scara_drake.ik.kernels.errors import error_kernel, within_kernel
from scara_drake.ik.kernels.postures import nearest_turns_kernel
from scara_drake.ik.options import TUNED, SwarmOptions
from scara_drake.ik.result import ROTATION_LENGTH, Answer, Problem
from scara_drake.joints import LOWER, UPPER

Array = NDArray[np.float64]

HISTORY_ROWS = 20_000  # a longer history is cut
# The converged position that task="position" promises [m], and how far from the best rotation
# error a branch may lie to count as equally good [rad].
EXACT_POSITION = 1e-6
BRANCH_TOLERANCE = 1e-3


def _solve(problem: Problem, options: SwarmOptions, dual: bool) -> Answer:
    parameters = options.parameter_set()
    position_only = problem.position_first and options.polish is False
    if not position_only and (options.nearest_to is not None or problem.position_first):
        return best_branch(problem, options.nearest_to, options.number_of_starts())
    p, R, first_joint, seed = problem.p, problem.R, problem.first_joint, problem.seed
    polish = dual if options.polish is None else options.polish
    q = problem.start.copy()
    if parameters is TUNED and dual and polish and not options.history:
        return Answer(q, *dpso_kernel(p, R, first_joint, seed, q))
    history = np.empty((HISTORY_ROWS if options.history else 0, 2))
    if position_only:
        # As the paper's live experiment does. Each target is drawn anew, so that neighbouring
        # targets may get answers far apart.
        evaluations, iterations, written = position_search_kernel(
            parameters, p, R, first_joint, seed, history, q
        )
    else:
        search = dual_search_kernel if dual else single_search_kernel
        evaluations, iterations, written = search(
            parameters, polish, p, R, first_joint, seed, history, q
        )
        nearest_turns_kernel(q, problem.start)
    kept = history[:written].copy() if options.history else None
    return Answer(q, evaluations, iterations, kept)


def solve(problem: Problem, options: SwarmOptions) -> Answer:
    """Solve one target by DPSO."""
    return _solve(problem, options, dual=True)


def solve_single(problem: Problem, options: SwarmOptions) -> Answer:
    """Solve one target by the traditional PSO: one swarm on position and orientation together."""
    return _solve(problem, options, dual=False)


def best_branch(problem: Problem, near: Array | None, starts: int) -> Answer:
    """Return the local solution nearest to a posture among the best, or the best of all.

    "Best" is exact in the position (or as near as was found) and within 1e-3 rad of the smallest
    rotation error; for task "pose" the two count together.
    """
    first = problem.first_joint
    reference = (problem.start if near is None else np.asarray(near, dtype=np.float64)).copy()
    begin = np.clip(reference, LOWER, UPPER)
    if first == 1:
        begin[0] = problem.start[0]
    q, errors, evaluations, iterations = branches_kernel(
        problem.p, problem.R, first, problem.position_first, begin, near is not None,
        problem.seed, starts,
    )  # fmt: skip
    position, rotation = errors.T
    if problem.position_first:
        good = position <= max(EXACT_POSITION, 1.001 * position.min())
    else:
        cost = np.hypot(position, ROTATION_LENGTH * rotation)
        good = cost <= cost.min() + ROTATION_LENGTH * BRANCH_TOLERANCE
        inside = np.array([within_kernel(e_p, e_w, False) for e_p, e_w in errors])
        good = good & inside if np.any(good & inside) else good
    good &= rotation <= rotation[good].min() + BRANCH_TOLERANCE
    measure = rotation if near is None else np.linalg.norm(q[:, first:] - reference[first:], axis=1)
    chosen = int(np.argmin(np.where(good, measure, np.inf)))
    answer = q[chosen].copy()
    if not problem.position_first:
        ev, it = sharpen_kernel(problem.p, problem.R, first, answer)
        evaluations, iterations = evaluations + ev, iterations + it
    return Answer(answer, evaluations, iterations)


def attainable(problem: Problem, limits: bool, seed: int = 0) -> bool:
    """Return whether some posture meets the pose, within the joint ranges or without them.

    Without them every revolute joint turns freely, while the mast keeps its range.
    """
    q = problem.start.copy()
    free_search_kernel(problem.p, problem.R, problem.first_joint, limits, seed, q)
    position, rotation = error_kernel(q, problem.p, problem.R)
    return bool(within_kernel(position, rotation, False))
