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
from scara_drake.ik.arrays import real_array
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
# How far an entry of R R^T may be from the identity; and how far where the numbers of R were
# rounded to four decimals, so that the nearest rotation is meant.
RIGID: Final = 1e-6
ROUNDED: Final = 1e-3
# No robot is further away, and no square of it overflows [m].
FARTHEST: Final = 1e6

# What `pose_fault_kernel` finds.
NOT_FINITE, NOT_RIGID, TOO_FAR, ROUNDED_ROTATION = 1, 2, 3, 4


@njit(cache=True)
def pose_fault_kernel(X: Array) -> int:
    """Return 0 for a rigid transform (4, 4) [m], or what is wrong with it.

    1 not finite, 2 not rigid, 3 further than 1e6 m away, 4 rigid but for rounding.
    """
    rounded = False
    for i in range(4):
        for j in range(4):
            if not np.isfinite(X[i, j]):
                return NOT_FINITE
    for i in range(3):
        if abs(X[3, i]) > 1e-9:
            return NOT_RIGID
        if abs(X[i, 3]) > FARTHEST:
            return TOO_FAR
        for j in range(i + 1):
            s = X[i, 0] * X[j, 0] + X[i, 1] * X[j, 1] + X[i, 2] * X[j, 2]
            off = abs(s - (1.0 if i == j else 0.0))
            if off > ROUNDED:
                return NOT_RIGID
            rounded = rounded or off > RIGID
    det = (
        X[0, 0] * (X[1, 1] * X[2, 2] - X[1, 2] * X[2, 1])
        - X[0, 1] * (X[1, 0] * X[2, 2] - X[1, 2] * X[2, 0])
        + X[0, 2] * (X[1, 0] * X[2, 1] - X[1, 1] * X[2, 0])
    )
    if det <= 0.0 or abs(X[3, 3] - 1.0) > 1e-9:
        return NOT_RIGID
    return ROUNDED_ROTATION if rounded else 0


def settle_pose(X: Array, fault: int, name: str) -> None:
    """Make a rounded rotation of a pose (4, 4) the nearest exact one, in place.

    Raises:
        ValueError: any other fault; one line that names the argument.
    """
    if fault == NOT_FINITE:
        raise ValueError(f"{name}: not finite, allowed finite numbers")
    if fault == TOO_FAR:
        farthest = X[int(np.argmax(np.abs(X[:3, 3]))), 3]
        raise ValueError(f"{name}: {farthest:g} m, allowed positions up to {FARTHEST:g} m")
    if fault == NOT_RIGID:
        raise ValueError(
            f"{name}: not a rigid transform, allowed a rotation (within {ROUNDED:g}; "
            "scipy.spatial.transform.Rotation.from_matrix gives the nearest) and last row 0 0 0 1"
        )
    U, _, Vt = np.linalg.svd(X[:3, :3])
    X[:3, :3] = U @ Vt


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

    A rotation whose numbers were rounded, so that R R^T is within 1e-3 of the identity, is made the
    nearest exact one.

    Raises:
        ValueError: wrong shape, no real numbers, not finite, not a rigid transform, or further than
            1e6 m away; names the argument.
    """
    X = real_array(name, X_WE.GetAsMatrix4() if hasattr(X_WE, "GetAsMatrix4") else X_WE)
    if X.shape != (4, 4):
        raise ValueError(f"{name}: shape {X.shape}, allowed (4, 4) or a RigidTransform")
    fault = pose_fault_kernel(X)
    if fault > 0:
        settle_pose(X, fault, name)
    return X


def check_seed(q_seed: ArrayLike) -> Array:
    """Return a copy (6,) of a seed posture, inside the joint ranges.

    Raises:
        ValueError: wrong shape, or outside the ranges by more than rounding; names the joint.
    """
    q = real_array("q_seed", q_seed)
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
