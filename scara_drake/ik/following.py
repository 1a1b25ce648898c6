"""A path behind its first point: by the inverse Jacobian, and what helps where that fails.

A point that the inverse Jacobian cannot hold is solved anew by `robust`, on the branch nearest to
the posture before; and where a path still fails or jumps, the smoothest sequence of all branches of
the closed form is taken. The answer says of each point who found it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from scara_drake.ik import robust
from scara_drake.ik.kernels.branch_path import has_jump_kernel, smoothest_path_kernel
from scara_drake.ik.kernels.errors import error_kernel, within_kernel
from scara_drake.ik.kernels.follow import Iteration, follow_kernel
from scara_drake.ik.options import PathOptions, RobustOptions
from scara_drake.ik.result import (
    CLOSED_FORM,
    FOLLOWED,
    ROBUST,
    ROTATION_LENGTH,
    Answer,
    PathAnswer,
    Problem,
)

Array = NDArray[np.float64]

# A step this many times those beside it is looked at, and is not taken.
JUMP, OBVIOUS = 1.1, 3.0
UNEVEN = 3.0  # times the median step


def follow_robustly(problems: Sequence[Problem], options: RobustOptions) -> PathAnswer:
    """Solve a path of which `robust` finds the first point, nearest to the seed if one is given."""
    near = options.nearest_to
    if near is None and problems[0].seeded:
        near = problems[0].start
    first = robust.solve(problems[0], replace(options, nearest_to=near))
    return follow_from(first, problems, options)


def follow_from(first: Answer, problems: Sequence[Problem], options: PathOptions) -> PathAnswer:
    """Solve a path from the answer to its first point."""
    p = np.array([problem.p for problem in problems])
    R = np.array([problem.R for problem in problems])
    n = len(problems)
    q, evaluations, steps = np.empty((n, 6)), np.zeros(n, np.int64), np.zeros(n, np.int64)
    q[0], evaluations[0], steps[0] = first.q, first.evaluations, first.iterations
    found_by = [first.found_by, *[FOLLOWED] * (n - 1)]
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
            rescued = _rescue(replace(problems[reached], start=q[reached - 1].copy()))
            evaluations[reached] += rescued.evaluations
            steps[reached] += rescued.iterations
            change = np.abs(rescued.q - q[reached - 1]).max()
            if change <= options.max_joint_change and _meets(problems[reached], rescued.q):
                q[reached], found_by[reached] = rescued.q, ROBUST
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
                found_by = [first.found_by if fixed else CLOSED_FORM, *[CLOSED_FORM] * (n - 1)]
                return PathAnswer(smooth, evaluations, steps, tuple(found_by))
    return PathAnswer(q, evaluations, steps, tuple(found_by))


def _is_broken(problems: Sequence[Problem], q: Array) -> bool:
    meets = all(_meets(problem, row) for problem, row in zip(problems, q, strict=True))
    changes = np.abs(np.diff(q, axis=0)).max(axis=1, initial=0.0)
    # A fold may also be taken on the wrong side without a jump: in long steps.
    uneven = changes.size > 0 and changes.max() > UNEVEN * np.median(changes)
    return not meets or uneven or bool(has_jump_kernel(q, JUMP))


def _rescue(problem: Problem) -> Answer:
    """Solve a point anew, on the branch nearest to the posture before."""
    return robust.solve(problem, RobustOptions(nearest_to=problem.start))


def _meets(problem: Problem, q: Array) -> bool:
    position, rotation = error_kernel(q, problem.p, problem.R)
    return bool(within_kernel(position, rotation, problem.position_first))
