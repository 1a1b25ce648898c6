"""The vectors that cross ports: poses and tool commands.

A pose is p_WE (3) [m], then the quaternion w, x, y, z of R_WE; a tool command (8) has the height of
the mast [m] after it.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydrake.math import RotationMatrix

from scara_drake import kinematics
from scara_drake.common.layout import Cell, Layout

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


class ToolCommand(NamedTuple):
    """What the operator asks of the tool.

    Attributes:
        p_WE: position (3) [m].
        quaternion: of R_WE, w, x, y, z (4).
        mast_height: d1 [m].
    """

    p_WE: Array
    quaternion: Array
    mast_height: Cell


TOOL_COMMAND = Layout(ToolCommand, p_WE=3, quaternion=4, mast_height=())
tool_command_of = TOOL_COMMAND.reader()


def held_command(centre: ArrayLike, rpy: ArrayLike, mast_height: float) -> Array:
    """Return the tool command (8,) of a point relative to the arm's base, which rides on the mast.

    Args:
        centre: (3,) [m], in W's axes.
        rpy: orientation of the tool, Rx(roll) Ry(pitch) Rz(yaw) (3,) [rad].
        mast_height: [m].
    """
    x, y, z = np.asarray(centre, dtype=np.float64)
    rotation = RotationMatrix(kinematics.rotation_from_intrinsic_xyz(rpy))
    return TOOL_COMMAND.pack(
        p_WE=[x, y, z + mast_height],
        quaternion=rotation.ToQuaternion().wxyz(),
        mast_height=mast_height,
    )
