"""One pose robustly, and a path: its first point, then the inverse Jacobian for those that follow.

The paper solves the first point by DPSO and then keeps the position rows (26) alone, which loses
the orientation along the way: that is the variant "paper". The default uses all rows (or the
position first, for that task). A point that the inverse Jacobian cannot hold is solved anew, on the
branch nearest to the posture before; and where a path still fails or jumps, the smoothest sequence
of all branches is taken.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.ik import dpso
from scara_drake.ik.kernels.branch_path import has_jump_kernel, smoothest_path_kernel
from scara_drake.ik.kernels.errors import error_kernel, within_kernel
from scara_drake.ik.kernels.follow import Iteration, follow_kernel
from scara_drake.ik.kernels.least_squares import cholesky_kernel, substitute_kernel
from scara_drake.ik.options import DpsoijOptions
from scara_drake.ik.result import POSITION_TOLERANCE, ROTATION_LENGTH, Answer, PathAnswer, Problem
from scara_drake.ik.robust import robust_kernel
from scara_drake.joints import LOWER, UPPER
from scara_drake.kinematics import tool_kinematics_kernel

Array = NDArray[np.float64]

# A step this many times those beside it is looked at, and is not taken.
JUMP, OBVIOUS = 1.1, 3.0
UNEVEN = 3.0  # times the median step


def solve(problem: Problem, options: DpsoijOptions) -> Answer:
    """Solve one target: a path of one point."""
    if options.variant == "paper":
        return dpso.solve(problem, replace(options, parameters="paper", polish=False))
    if problem.position_first or options.asks_for_swarm():
        return dpso.solve(problem, options)
    near = problem.start
    if options.nearest_to is not None:
        near = np.clip(np.asarray(options.nearest_to, dtype=np.float64), LOWER, UPPER)
        if problem.first_joint == 1:
            near[0] = problem.start[0]
    q = np.empty(6)
    return Answer(
        q, *robust_kernel(problem.p, problem.R, problem.first_joint, near, problem.seed, q)
    )


def follow(problems: Sequence[Problem], options: DpsoijOptions) -> PathAnswer:
    """Solve a path without jumps, from the branch nearest to the seed where one is given.

    The variant "paper" is `_follow_literally`.
    """
    if options.variant == "paper":
        return _follow_literally(problems, options)
    near = options.nearest_to
    if near is None and problems[0].seeded:
        near = problems[0].start
    first = solve(problems[0], replace(options, nearest_to=near))
    p = np.array([problem.p for problem in problems])
    R = np.array([problem.R for problem in problems])
    n = len(problems)
    q, evaluations, steps = np.empty((n, 6)), np.zeros(n, np.int64), np.zeros(n, np.int64)
    q[0], evaluations[0], steps[0] = first.q, first.evaluations, first.iterations
    begin = 1
    iteration = np.array(
        Iteration(
            first_joint=problems[0].first_joint,
            position_first=problems[0].position_first,
            length=ROTATION_LENGTH,
            step=options.max_step,
            iterations=options.max_iterations,
            max_change=options.max_joint_change,
            stop=True,
        )
    )
    # A failed first point or a failed rescue is followed as near as the joints allow.
    while begin < n:
        reached = follow_kernel(p, R, iteration, q[begin - 1], begin, q, evaluations, steps)
        if reached < n:
            rescued = _rescue(replace(problems[reached], start=q[reached - 1].copy()), options)
            evaluations[reached] += rescued.evaluations
            steps[reached] += rescued.iterations
            change = np.abs(rescued.q - q[reached - 1]).max()
            if change <= options.max_joint_change and _meets(problems[reached], rescued.q):
                q[reached] = rescued.q
        begin = reached + 1
    if not problems[0].position_first and _is_broken(problems, q):
        # Followed point by point it fails or jumps: look at all branches of all points, and leave
        # the first answer only where no continuous way begins there.
        for fixed in (True, False):
            smooth = np.empty_like(q)
            first_joint = problems[0].first_joint
            largest = smoothest_path_kernel(p, R, first_joint, q[0], fixed, smooth)
            evaluations += 1
            if largest <= options.max_joint_change and not has_jump_kernel(smooth, OBVIOUS):
                return PathAnswer(smooth, evaluations, steps)
    return PathAnswer(q, evaluations, steps)


def _is_broken(problems: Sequence[Problem], q: Array) -> bool:
    meets = all(_meets(problem, row) for problem, row in zip(problems, q, strict=True))
    changes = np.abs(np.diff(q, axis=0)).max(axis=1, initial=0.0)
    # A fold may also be taken on the wrong side without a jump: in long steps.
    uneven = changes.size > 0 and changes.max() > UNEVEN * np.median(changes)
    return not meets or uneven or bool(has_jump_kernel(q, JUMP))


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
    return PathAnswer(q, evaluations, steps)


@njit(cache=True)
def pseudo_inverse_kernel(q: Array, p_desired: Array, first_joint: int, iterations: int) -> int:
    """Iterate q (6,) <- q + J⁺ (p_d - p), (1) with the J of (26), in place; return the count.

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


def _rescue(problem: Problem, options: DpsoijOptions) -> Answer:
    """Solve a point anew, on the branch nearest to the posture before."""
    if problem.position_first:
        return dpso.best_branch(problem, problem.start, options.starts or 256)
    return solve(problem, replace(options, nearest_to=None))


def _meets(problem: Problem, q: Array) -> bool:
    position, rotation = error_kernel(q, problem.p, problem.R)
    return bool(within_kernel(position, rotation, problem.position_first))
