"""Dual particle swarm optimisation, and the traditional PSO beside it; see `kernels`.

With `polish` the swarms run to the tolerances as without, and least squares then gives their answer
the digits that are left. Where no pass converges within the budget, `robust` answers, and is named
as the finder.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from scara_drake.ik import robust
from scara_drake.ik.kernels.dpso import (
    dual_search_kernel,
    position_search_kernel,
    single_search_kernel,
)
from scara_drake.ik.kernels.postures import Bounds, Goal, nearest_turns_kernel
from scara_drake.ik.kernels.swarm_branches import swarm_branches_kernel
from scara_drake.ik.options import RobustOptions, SwarmOptions
from scara_drake.ik.result import ROBUST, Answer, Problem
from scara_drake.joints import LOWER, UPPER

Array = NDArray[np.float64]

HISTORY_ROWS = 20_000  # a longer history is cut
DPSO, PSO = "dpso", "pso"
# Passes that are compared where a branch or the best orientation is asked for.
PASSES: Final = 16


def solve(problem: Problem, options: SwarmOptions) -> Answer:
    """Solve one target by DPSO."""
    return _solve(problem, options, DPSO)


def solve_single(problem: Problem, options: SwarmOptions) -> Answer:
    """Solve one target by the traditional PSO: one swarm on position and orientation together."""
    return _solve(problem, options, PSO)


def _solve(problem: Problem, options: SwarmOptions, name: str) -> Answer:
    compares = problem.position_first or options.nearest_to is not None
    polish = (name == DPSO or compares) if options.polish is None else options.polish
    history = np.empty((HISTORY_ROWS if options.history else 0, 2))
    if polish:
        passes = options.starts or (PASSES if compares else 1)
        return _polished(problem, options, name, passes, history)
    p, R, first_joint, seed = problem.p, problem.R, problem.first_joint, problem.seed
    parameters, q = options.parameter_set(), problem.start.copy()
    if problem.position_first:
        # As the paper's live experiment does. Each target is drawn anew, so that neighbouring
        # targets may get answers far apart.
        evaluations, iterations, written = position_search_kernel(
            parameters, p, R, first_joint, seed, history, q
        )
    else:
        search = dual_search_kernel if name == DPSO else single_search_kernel
        evaluations, iterations, written = search(parameters, p, R, first_joint, seed, history, q)
        nearest_turns_kernel(q, problem.start)
    kept = history[:written].copy() if options.history else None
    return Answer(q, evaluations, iterations, kept, found_by=name)


def _polished(
    problem: Problem, options: SwarmOptions, name: str, passes: int, history: Array
) -> Answer:
    """Return the branch asked for, of those that so many passes find; or `robust`'s answer."""
    goal = Goal(problem.p, problem.R, Bounds(problem.first_joint, LOWER.copy(), UPPER.copy()))
    near = robust.reference_posture(problem, options)
    q, errors, evaluations, iterations, written = swarm_branches_kernel(
        options.parameter_set(), name == DPSO, problem.position_first, goal, near, problem.seed,
        passes, history,
    )  # fmt: skip
    kept = history[:written].copy() if options.history else None
    if len(q) == 0:
        fallback = robust.solve(problem, RobustOptions(nearest_to=options.nearest_to))
        evaluations += fallback.evaluations
        return Answer(fallback.q, evaluations, iterations, kept, found_by=ROBUST)
    if problem.position_first or options.nearest_to is not None:
        answer = robust.choose_branch(problem, options.nearest_to, q, errors)
    else:
        answer = q[0].copy()  # of the leader; its mirror was not asked for
    ev, _ = robust.sharpen(problem, answer)
    return Answer(answer, evaluations + ev, iterations, kept, found_by=name)
