"""Poses as the vectors that cross ports: p_WE (3) [m], then the quaternion w, x, y, z of R_WE."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydrake.math import RotationMatrix

from scara_drake import kinematics

Array = NDArray[np.float64]

# Entries of `joystick_axes`, in order.
STICK_NAMES: Final = ("x", "y", "z", "mast_axis", "mast_hat")
# Of `servo_state`, the entry of the status.
SERVO_STATUS: Final = 15


def pose_vector(q: ArrayLike) -> Array:
    """Return the tool pose of a configuration (6,) as a vector (7,)."""
    X_WE = kinematics.forward_kinematics(q)
    quaternion = RotationMatrix(X_WE[:3, :3]).ToQuaternion().wxyz()
    return np.concatenate([X_WE[:3, 3], quaternion])


def pose_matrix(vector: ArrayLike) -> Array:
    """Return the pose (4, 4) of a vector whose first entries are p_WE and the quaternion."""
    values = np.array(vector, dtype=np.float64)
    X_WE, R_WE = np.eye(4), np.empty((3, 3))
    kinematics.rotation_from_quaternion_kernel(values[3:7], R_WE)
    X_WE[:3, :3], X_WE[:3, 3] = R_WE, values[:3]
    return X_WE
