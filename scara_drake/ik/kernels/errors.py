"""How far a posture is from a pose, and whether that is near enough."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.scratch import scratch
from scara_drake.ik.kernels.postures import inside_kernel
from scara_drake.ik.result import POSITION_TOLERANCE, ROTATION_TOLERANCE
from scara_drake.kinematics import rotation_vector_kernel, tool_kinematics_kernel, tool_pose_kernel

Array = NDArray[np.float64]


class Linear(NamedTuple):
    """The tool and its errors, linearised at a posture; written by `linearize_kernel`.

    Attributes:
        p: tool position (3,) [m].
        R: tool rotation (3, 3).
        J: Jacobian J_WE (6, 6), rows angular then linear.
        e_p: position error (3,) [m].
        e_w: rotation error (3,), a rotation vector in W [rad].
    """

    p: Array
    R: Array
    J: Array
    e_p: Array
    e_w: Array


@njit(cache=True)
def linear_kernel() -> Linear:
    """Return room for one."""
    return Linear(np.empty(3), np.empty((3, 3)), np.empty((6, 6)), np.empty(3), np.empty(3))


@njit(cache=True)
def linearize_kernel(
    q: Array, p_desired: Array, R_desired: Array, at: Linear
) -> tuple[float, float]:
    """Write `at` for one posture (6,); return the square of |e_p| [m^2] and |e_w| [rad]."""
    tool_kinematics_kernel(q, at.p, at.R, at.J)
    rotation = rotation_vector_kernel(R_desired, at.R, at.e_w)
    square = 0.0
    for i in range(3):
        at.e_p[i] = p_desired[i] - at.p[i]
        square += at.e_p[i] * at.e_p[i]
    return square, rotation


@njit(cache=True)
def error_kernel(q: Array, p_desired: Array, R_desired: Array) -> tuple[float, float]:
    """Position [m] and rotation [rad] error of one posture (6,)."""
    p, R, w = scratch(3), scratch(3, 3), scratch(3)
    tool_pose_kernel(q, p, R)
    rotation = rotation_vector_kernel(R_desired, R, w)
    x, y, z = p_desired[0] - p[0], p_desired[1] - p[1], p_desired[2] - p[2]
    return np.sqrt(x * x + y * y + z * z), rotation


@njit(cache=True)
def within_kernel(position: float, rotation: float, position_only: bool) -> bool:
    """Whether errors [m], [rad] are within the tolerances, the rotation where it is asked for."""
    return position <= POSITION_TOLERANCE and (position_only or rotation <= ROTATION_TOLERANCE)


@njit(cache=True)
def misfit_kernel(position: float, rotation: float) -> float:
    """Sum of the squares of errors [m], [rad] in units of their tolerances."""
    return (position / POSITION_TOLERANCE) ** 2 + (rotation / ROTATION_TOLERANCE) ** 2


@njit(cache=True)
def confirm_kernel(q: Array, p: Array, R: Array, position_only: bool) -> tuple[float, float, bool]:
    """Return the errors [m], [rad] of a posture (6,) and whether it is a success."""
    position, rotation = error_kernel(q, p, R)
    success = within_kernel(position, rotation, position_only) and inside_kernel(q)
    return position, rotation, success
