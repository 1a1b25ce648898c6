"""One pose by DPSO, and a path: its first point by DPSO, then the inverse Jacobian.

The paper solves the first point by DPSO and then keeps the position rows (26) alone, which loses
the orientation along the way: that is the variant "paper". The default uses all rows (or the
position first, for that task), see `following`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.ik import dpso
from scara_drake.ik.following import follow_from
from scara_drake.ik.kernels.least_squares import cholesky_kernel, substitute_kernel
from scara_drake.ik.options import DpsoijOptions
from scara_drake.ik.result import FOLLOWED, POSITION_TOLERANCE, Answer, PathAnswer, Problem
from scara_drake.joints import LOWER, UPPER
from scara_drake.kinematics import tool_kinematics_kernel

Array = NDArray[np.float64]


def solve(problem: Problem, options: DpsoijOptions) -> Answer:
    """Solve one target, a path of one point, by DPSO.

    The default takes the branch nearest to `nearest_to`, or else to the start.
    """
    if options.variant == "paper":
        return dpso.solve(problem, replace(options, parameters="paper", polish=False))
    if options.nearest_to is None and options.polish is not False:
        options = replace(options, nearest_to=problem.start)
    return dpso.solve(problem, options)


def follow(problems: Sequence[Problem], options: DpsoijOptions) -> PathAnswer:
    """Solve a path without jumps, from the branch nearest to the seed where one is given.

    The variant "paper" is `_follow_literally`.
    """
    if options.variant == "paper":
        return _follow_literally(problems, options)
    return follow_from(solve(problems[0], options), problems, options)


def _follow_literally(problems: Sequence[Problem], options: DpsoijOptions) -> PathAnswer:
    """The paper's DPSOIJ: only the position is followed, and joint 6 never moves."""
    first = solve(problems[0], options)
    n = len(problems)
    q = np.tile(first.q, (n, 1))
    evaluations = np.full(n, first.evaluations, dtype=np.int64)
    steps = np.full(n, first.iterations, dtype=np.int64)
    for k in range(1, n):
        q[k] = q[k - 1]
        steps[k] = pseudo_inverse_kernel(
            q[k], problems[k].p, problems[k].first_joint, options.max_iterations
        )
        evaluations[k] = steps[k] + 1
    found_by = (first.found_by, *(FOLLOWED,) * (n - 1))
    return PathAnswer(q, evaluations, steps, found_by)


@njit(cache=True)
def pseudo_inverse_kernel(q: Array, p_desired: Array, first_joint: int, iterations: int) -> int:
    r"""Iterate the pseudo-inverse of the position rows from q (6,), in place; return the count.

    Equation (1), with the Jacobian of (26) and the right inverse of (8):

    .. math::

        q \leftarrow q + J^\top (J J^\top)^{-1}\,(p_d - p)

    It ends within the tolerance of 5 mm; a joint that would leave its range stops there.
    """
    p, R, J = np.empty(3), np.empty((3, 3)), np.empty((6, 6))
    G, y = np.empty((3, 3)), np.empty(3)
    for iteration in range(iterations):
        tool_kinematics_kernel(q, p, R, J)
        square = 0.0
        for i in range(3):
            y[i] = p_desired[i] - p[i]
            square += y[i] * y[i]
        if square <= POSITION_TOLERANCE * POSITION_TOLERANCE:
            return iteration
        for i in range(3):
            for k in range(i + 1):
                G[i, k] = 1e-12 if i == k else 0.0
                for j in range(first_joint, 6):
                    G[i, k] += J[3 + i, j] * J[3 + k, j]
        cholesky_kernel(G, 3)
        substitute_kernel(G, y, 3)
        for j in range(first_joint, 6):
            step = J[3, j] * y[0] + J[4, j] * y[1] + J[5, j] * y[2]
            q[j] = min(max(q[j] + step, LOWER[j]), UPPER[j])
    return iterations
