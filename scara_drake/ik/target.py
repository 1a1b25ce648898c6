"""What a caller asks for, checked; and the answer, confirmed by forward kinematics.

The checks are kernels: a solve takes microseconds, and numpy's own tests of one 4x4 array would
take ten times as long.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from scara_drake.common import checks
from scara_drake.ik.kernels.errors import confirm_kernel
from scara_drake.ik.result import Problem
from scara_drake.joints import HOME, LOWER, UPPER, check_configuration

Array = NDArray[np.float64]

JOINTS: Final = ("full", "arm")
TASKS: Final = ("pose", "position")

# A seed this far outside the joint ranges is rounding of a loop, not a mistake; it is clipped.
SEED_SLACK: Final = 1e-6
# Seeds are taken modulo this plus one: the kernels hold them in 64 bits.
LARGEST_SEED: Final = 2**63 - 1
# How far R R^T may be from the identity.
RIGID: Final = 1e-6


@njit(cache=True)
def pose_fault_kernel(X: Array) -> int:
    """Return 0 for a rigid transform (4, 4), 1 if not finite, 2 if not rigid."""
    for i in range(4):
        for j in range(4):
            if not np.isfinite(X[i, j]):
                return 1
    for i in range(3):
        if abs(X[3, i]) > 1e-9:
            return 2
        for j in range(i + 1):
            s = X[i, 0] * X[j, 0] + X[i, 1] * X[j, 1] + X[i, 2] * X[j, 2]
            if abs(s - (1.0 if i == j else 0.0)) > RIGID:
                return 2
    det = (
        X[0, 0] * (X[1, 1] * X[2, 2] - X[1, 2] * X[2, 1])
        - X[0, 1] * (X[1, 0] * X[2, 2] - X[1, 2] * X[2, 0])
        + X[0, 2] * (X[1, 0] * X[2, 1] - X[1, 1] * X[2, 0])
    )
    return 0 if det > 0.0 and abs(X[3, 3] - 1.0) <= 1e-9 else 2


@njit(cache=True)
def clip_seed_kernel(q: Array) -> bool:
    """Clip a seed (6,) that is outside the ranges by rounding; return whether it is inside."""
    for j in range(6):
        if not LOWER[j] - SEED_SLACK <= q[j] <= UPPER[j] + SEED_SLACK:  # also refuses NaN
            return False
        q[j] = min(max(q[j], LOWER[j]), UPPER[j])
    return True


def check_pose(X_WE: Any, name: str) -> Array:
    """Return a copy (4, 4) of a pose given as an array or as a RigidTransform.

    Raises:
        ValueError: wrong shape, not finite, or not a rigid transform; names the argument.
    """
    matrix = X_WE.GetAsMatrix4() if hasattr(X_WE, "GetAsMatrix4") else X_WE
    X = np.array(matrix, dtype=np.float64, order="C")
    if X.shape != (4, 4):
        raise ValueError(f"{name}: shape {X.shape}, allowed (4, 4) or a RigidTransform")
    fault = pose_fault_kernel(X)
    if fault == 1:
        raise ValueError(f"{name}: not finite, allowed finite numbers")
    if fault == 2:
        raise ValueError(f"{name}: not a rigid transform, allowed a rotation and last row 0 0 0 1")
    return X


def check_seed(q_seed: ArrayLike) -> Array:
    """Return a copy (6,) of a seed posture, inside the joint ranges.

    Raises:
        ValueError: wrong shape, or outside the ranges by more than rounding; names the joint.
    """
    q = np.array(q_seed, dtype=np.float64)
    if q.shape == (6,) and clip_seed_kernel(q):
        return q
    return check_configuration("q_seed", q)


def make_problem(
    X_WE: Any, name: str, joints: str, task: str, q_seed: ArrayLike | None, seed: int
) -> Problem:
    """Check one target and what goes with it; see `scara_drake.ik.solve`.

    Raises:
        ValueError: one line that names the argument and what is allowed.
    """
    checks.choice("joints", joints, JOINTS)
    checks.choice("task", task, TASKS)
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer):
        raise ValueError(f"seed: {seed}, allowed a whole number")
    X = check_pose(X_WE, name)
    if q_seed is not None:
        start = check_seed(q_seed)
    elif joints == "arm":
        raise ValueError('q_seed: None, allowed (6,) with joints="arm": it holds the mast height')
    else:
        start = np.array(HOME)
        start[0] = min(max(X[2, 3], LOWER[0]), UPPER[0])
    return Problem(
        p=X[:3, 3].copy(),
        R=X[:3, :3].copy(),
        first_joint=1 if joints == "arm" else 0,
        position_first=task == "position",
        start=start,
        seeded=q_seed is not None,
        seed=int(seed) & LARGEST_SEED,
    )


def confirm(q: Array, problems: Sequence[Problem]) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Errors and success (n,) of answers q (n, 6), by forward kinematics and nothing else."""
    rows = [
        confirm_kernel(row, problem.p, problem.R, problem.position_first)
        for row, problem in zip(q, problems, strict=True)
    ]
    position, rotation, success = (np.array(column) for column in zip(*rows, strict=True))
    return position, rotation, success
