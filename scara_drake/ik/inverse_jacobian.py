"""The inverse Jacobian: as a solver from a seed, and along a path."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from scara_drake.ik.kernels.follow import Iteration, follow_kernel, iterate_kernel
from scara_drake.ik.options import InverseJacobianOptions
from scara_drake.ik.result import ROTATION_LENGTH, Answer, PathAnswer, Problem

Array = NDArray[np.float64]


def _iteration(problem: Problem, options: InverseJacobianOptions) -> Array:
    return np.array(
        Iteration(
            first_joint=problem.first_joint,
            position_first=problem.position_first,
            length=ROTATION_LENGTH if options.rows == "full" else 0.0,
            step=options.max_step,
            iterations=options.max_iterations,
        )
    )


def solve(problem: Problem, options: InverseJacobianOptions) -> Answer:
    """Solve one target from the seed: full rows, position first, or the paper's position rows."""
    q = problem.start.copy()
    history = np.empty((options.max_iterations + 1 if options.history else 0, 2))
    evaluations, iterations = iterate_kernel(
        q, problem.p, problem.R, _iteration(problem, options), history
    )
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
    iteration = _iteration(problems[0], options)
    follow_kernel(p, R, iteration, first.q, 1, q, evaluations, steps)
    return PathAnswer(q, evaluations, steps)
