"""Closed form: every solution of a pose, inside the limits, and the choice among them.

`closed_form_arm` and `closed_form_mast` find the solutions modulo whole turns; here theta2, theta3
and theta6 are turned and the limits applied. All is compiled and deterministic.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from scara_drake.common import checks
from scara_drake.ik.kernels.branches import LOWER, UPPER
from scara_drake.ik.kernels.closed_form_arm import EXACT, arm_branches_kernel, arm_solutions_kernel
from scara_drake.ik.kernels.closed_form_mast import mast_branches_kernel
from scara_drake.ik.kernels.refine import error_kernel, nearest_turns_kernel
from scara_drake.ik.options import ClosedFormOptions
from scara_drake.ik.result import ROTATION_LENGTH, Answer, PathAnswer, Problem
from scara_drake.ik.target import JOINTS, check_seed, confirm_kernel, pose_fault_kernel
from scara_drake.joints import HOME
from scara_drake.kinematics import D6

Array = NDArray[np.float64]


MOST = 24  # solutions modulo whole turns
TURNED = 27  # postures that one of them becomes by whole turns of three joints
LIMIT_SLACK = 1e-10  # a joint this far outside its range is at the limit, by rounding


@njit(cache=True)
def solutions_kernel(p: Array, R: Array, first_joint: int, mast_height: float, q: Array) -> int:
    """Write the solutions q (24, 6) modulo whole turns, limits not applied; return their number."""
    if first_joint == 1:
        return arm_solutions_kernel(p, R, mast_height, q)
    return mast_branches_kernel(p, R, q)


@njit(cache=True)
def clip_kernel(q: Array, lower: Array, upper: Array) -> float:
    """Clip q (6,) to the limits; return by how much it was outside [m], [rad]."""
    outside = 0.0
    for j in range(6):
        inside = min(max(q[j], lower[j]), upper[j])
        outside = max(outside, abs(q[j] - inside))
        q[j] = inside
    return outside


@njit(cache=True)
def nearest_inside_kernel(q: Array, near: Array, lower: Array, upper: Array) -> bool:
    """Turn q (6,) by whole turns to lie nearest to a posture inside the limits.

    Returns whether it is inside; otherwise it is clipped.
    """
    nearest_turns_kernel(q, near, lower, upper)
    return clip_kernel(q, lower, upper) <= LIMIT_SLACK


@njit(cache=True)
def nearest_kernel(
    p: Array, R: Array, first_joint: int, near: Array, lower: Array, upper: Array,
    work: Array, q: Array,
) -> tuple[bool, int]:  # fmt: skip
    """Write the exact solution inside the limits that is nearest to a posture.

    Without one, the candidate with the least error, clipped to the limits; an arm that moves its
    mast then also tries the mast at its limits, and level with the wrist and the tool.

    Args:
        p: target (3,) [m].
        R: target (3, 3).
        first_joint: 0 or 1; with 1 the mast stays at near[0].
        near: posture (6,).
        lower: joint limits (6,).
        upper: joint limits (6,).
        work: (24, 6).
        q: result (6,), not `near` itself.

    Returns:
        Whether q is exact, and how many candidates were looked at.
    """
    n = solutions_kernel(p, R, first_joint, near[0], work)
    least = np.inf
    for k in range(n):
        if nearest_inside_kernel(work[k], near, lower, upper):
            distance = 0.0
            for j in range(first_joint, 6):
                distance += (work[k, j] - near[j]) ** 2
            if distance < least:
                least = distance
                q[:] = work[k]
    if least < np.inf:
        return True, n
    residual = np.empty(4)
    heights = (near[0], lower[0], upper[0], p[2], p[2] - D6 * R[2, 2])
    tried = n
    for i in range(6 if first_joint == 0 else 2):
        # The solutions outside the limits first, then the candidates at each height.
        if i > 0:
            height = min(max(heights[i - 1], lower[0]), upper[0])
            n = arm_branches_kernel(p, R, height, work, residual)
            tried += n
        for k in range(n):
            nearest_inside_kernel(work[k], near, lower, upper)
            position, rotation = error_kernel(work[k], p, R)
            error = np.hypot(position, ROTATION_LENGTH * rotation)
            if error < least:
                least = error
                q[:] = work[k]
    return False, tried


@njit(cache=True)
def nearest_batch_kernel(
    p: Array, R: Array, first_joint: int, near: Array, level: bool, follow: bool,
    lower: Array, upper: Array, q: Array, success: NDArray[np.bool_], tried: NDArray[np.int64],
) -> None:  # fmt: skip
    """Solve n targets p (n, 3), R (n, 3, 3) into q (n, 6), success (n,) and tried (n,).

    The posture `near` (6,) is that of the last success where `follow`; its mast height is that of
    the target where `level`.
    """
    work, near = np.empty((MOST, 6)), near.copy()
    for i in range(p.shape[0]):
        if level:
            near[0] = min(max(p[i, 2], lower[0]), upper[0])
        success[i], tried[i] = nearest_kernel(
            p[i], R[i], first_joint, near, lower, upper, work, q[i]
        )
        if not success[i]:
            _, _, success[i] = confirm_kernel(q[i], p[i], R[i], False)
        if follow and success[i]:
            near[:] = q[i]


@njit(cache=True)
def all_kernel(
    p: Array, R: Array, first_joint: int, mast_height: float, lower: Array, upper: Array, q: Array
) -> int:
    """Write every solution inside the limits, by whole turns too, q (648, 6); their number."""
    work, row, turns = np.empty((MOST, 6)), np.empty(6), 2.0 * np.pi
    n = 0
    for k in range(solutions_kernel(p, R, first_joint, mast_height, work)):
        for i in range(TURNED):
            row[:] = work[k]
            row[1] += turns * (i // 9 - 1)
            row[2] += turns * (i // 3 % 3 - 1)
            row[5] += turns * (i % 3 - 1)
            if clip_kernel(row, lower, upper) <= LIMIT_SLACK:
                position, rotation = error_kernel(row, p, R)
                if position <= EXACT and rotation <= EXACT:
                    q[n] = row
                    n += 1
    return n


@njit(cache=True)
def _first_fault(X: Array) -> tuple[int, int]:
    for i in range(X.shape[0]):
        fault = pose_fault_kernel(X[i])
        if fault > 0:
            return i, fault
    return 0, 0


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
    X = np.array(X_WEs, dtype=np.float64, order="C", ndmin=1)
    if X.ndim != 3 or X.shape[1:] != (4, 4):
        raise ValueError(f"X_WEs: shape {X.shape}, allowed (n, 4, 4)")
    index, fault = _first_fault(X)
    if fault > 0:
        raise ValueError(
            f"X_WEs[{index}]: not {'finite' if fault == 1 else 'a rigid transform'}, "
            "allowed finite numbers, a rotation and last row 0 0 0 1"
        )
    if q_seed is None and joints == "arm":
        raise ValueError('q_seed: None, allowed (6,) with joints="arm": it holds the mast height')
    near = np.array(HOME) if q_seed is None else check_seed(q_seed)
    q, success, _ = _nearest(
        np.ascontiguousarray(X[:, :3, 3]), np.ascontiguousarray(X[:, :3, :3]),
        1 if joints == "arm" else 0, near, level=q_seed is None, follow=False,
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
        problem.p, problem.R, problem.first_joint, problem.start, LOWER, UPPER,
        np.empty((MOST, 6)), q,
    )  # fmt: skip
    return Answer(q, tried, 0)


def follow(problems: Sequence[Problem], options: ClosedFormOptions) -> PathAnswer:
    """Solve a path, each target by the solution nearest to the one before; see `solve`."""
    _pose_task(problems[0])
    q, _, tried = _nearest(
        np.array([problem.p for problem in problems]),
        np.array([problem.R for problem in problems]),
        problems[0].first_joint, problems[0].start, level=False, follow=True,
    )  # fmt: skip
    return PathAnswer(q, tried, np.zeros(len(q), np.int64))


def every_solution(problem: Problem) -> Array:
    """Return every solution (n, 6) inside the limits; see `scara_drake.ik.solve_all`."""
    q = np.empty((MOST * TURNED, 6))
    n = all_kernel(
        problem.p, problem.R, problem.first_joint, problem.start[0], LOWER, UPPER, q
    )  # fmt: skip
    # Digits of rounding do not decide the order.
    q = q[:n][np.lexsort(np.round(q[:n], 9).T[::-1])]
    if problem.seeded:
        first = problem.first_joint
        distance = np.linalg.norm(q[:, first:] - problem.start[first:], axis=1)
        q = q[np.argsort(np.round(distance, 9), kind="stable")]
    return q


def _nearest(
    p: Array, R: Array, first_joint: int, near: Array, level: bool, follow: bool
) -> tuple[Array, NDArray[np.bool_], NDArray[np.int64]]:
    n = len(p)
    q, success, tried = np.empty((n, 6)), np.empty(n, np.bool_), np.empty(n, np.int64)
    nearest_batch_kernel(
        p, R, first_joint, near, level, follow, LOWER, UPPER, q, success, tried
    )  # fmt: skip
    return q, success, tried


def _pose_task(problem: Problem) -> None:
    if problem.position_first:
        raise ValueError("task: 'position', allowed pose with method closed_form")
