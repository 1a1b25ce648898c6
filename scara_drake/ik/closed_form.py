"""Closed form: every solution of a pose, inside the limits, and the choice among them.

All is compiled and deterministic, see `kernels.solutions`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from scara_drake.common import checks
from scara_drake.ik.arrays import real_array
from scara_drake.ik.kernels.solutions import (
    MOST,
    all_kernel,
    nearest_batch_kernel,
    nearest_kernel,
)
from scara_drake.ik.options import ClosedFormOptions
from scara_drake.ik.result import Answer, PathAnswer, Problem
from scara_drake.ik.target import JOINTS, check_seed, pose_fault_kernel, settle_pose
from scara_drake.joints import HOME

Array = NDArray[np.float64]


@njit(cache=True)
def _next_fault(X: Array, begin: int) -> tuple[int, int]:
    for i in range(begin, X.shape[0]):
        fault = pose_fault_kernel(X[i])
        if fault > 0:
            return i, fault
    return X.shape[0], 0


def solve_batch(
    X_WEs: ArrayLike, joints: str = "full", q_seed: ArrayLike | None = None
) -> tuple[Array, NDArray[np.bool_]]:
    """Solve n poses (n, 4, 4) [m], each alone, by the branch nearest to q_seed (6,).

    Without q_seed, nearest to the home posture with the mast level with the pose; joints="arm"
    needs it for the mast height.

    Returns:
        q (n, 6), inside the joint ranges, and success (n,), both as `scara_drake.ik.solve` has
        them with method "closed_form".

    Raises:
        ValueError: the poses, joints or q_seed are not allowed; one line that says what is.
    """
    checks.choice("joints", joints, JOINTS)
    X = real_array("X_WEs", X_WEs)
    if X.ndim != 3 or X.shape[1:] != (4, 4):
        raise ValueError(f"X_WEs: shape {X.shape}, allowed (n, 4, 4)")
    index, fault = _next_fault(X, 0)
    while fault > 0:
        settle_pose(X[index], fault, f"X_WEs[{index}]")
        index, fault = _next_fault(X, index + 1)
    if q_seed is None and joints == "arm":
        raise ValueError('q_seed: None, allowed (6,) with joints="arm": it holds the mast height')
    near = np.array(HOME) if q_seed is None else check_seed(q_seed)
    q, success, _ = nearest_batch_kernel(
        np.ascontiguousarray(X[:, :3, 3]), np.ascontiguousarray(X[:, :3, :3]),
        1 if joints == "arm" else 0, near, q_seed is None, False,
    )  # fmt: skip
    return q, success


def solve(problem: Problem, options: ClosedFormOptions) -> Answer:
    """Solve one target: the exact solution nearest to the start, else the least error.

    Raises:
        ValueError: task is "position": the nearest orientation has no closed form.
    """
    _pose_task(problem)
    q = np.empty(6)
    _, tried = nearest_kernel(
        problem.p, problem.R, problem.first_joint, problem.start, np.empty((MOST, 6)), q
    )
    return Answer(q, tried, 0)


def follow(problems: Sequence[Problem], options: ClosedFormOptions) -> PathAnswer:
    """Solve a path, each target by the solution nearest to the one before; see `solve`."""
    _pose_task(problems[0])
    q, _, tried = nearest_batch_kernel(
        np.array([problem.p for problem in problems]),
        np.array([problem.R for problem in problems]),
        problems[0].first_joint, problems[0].start, False, True,
    )  # fmt: skip
    return PathAnswer(q, tried, np.zeros(len(q), np.int64))


def every_solution(problem: Problem) -> Array:
    """Return every solution (n, 6) inside the limits; see `scara_drake.ik.solve_all`."""
    q = all_kernel(problem.p, problem.R, problem.first_joint, problem.start[0])
    # Digits of rounding do not decide the order.
    q = q[np.lexsort(np.round(q, 9).T[::-1])]
    if problem.seeded:
        first = problem.first_joint
        distance = np.linalg.norm(q[:, first:] - problem.start[first:], axis=1)
        q = q[np.argsort(np.round(distance, 9), kind="stable")]
    return q


def _pose_task(problem: Problem) -> None:
    if problem.position_first:
        raise ValueError("task: 'position', allowed pose with method closed_form")
