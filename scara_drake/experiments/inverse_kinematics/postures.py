"""The four desired postures of Table 5, and the orientation error as the paper writes it."""

from __future__ import annotations

from typing import Final

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from scara_drake import joints, kinematics
from scara_drake.ik.result import POSITION_TOLERANCE, ROTATION_TOLERANCE

Array = NDArray[np.float64]

# P_d [m], relative to the arm's base, and O_d = roll, pitch, yaw [rad] of Rx Ry Rz.
POSITIONS: Final = (
    (-0.990, 0.642, -1.140),
    (-0.600, 0.425, -0.284),
    (-0.002, 0.820, -0.250),
    (1.620, 1.620, -0.500),
)
ORIENTATIONS: Final = (
    (-2.35, -0.82, -1.74),
    (-1.43, 0.87, -3.03),
    (1.57, 1.57, 0.0),
    (-1.57, 0.78, 0.78),
)
NUMBERS: Final = (1, 2, 3, 4)
# Which joints take part, and how claims call them.
WHO: Final = {"full": "the arm with its mast", "arm": "the 5-DOF arm alone"}
MOVES: Final = {
    "full": "the mast moves by what a posture needs, from a height that is not given",
    "arm": "the mast stands, and five joints have to meet six numbers",
}
# What E_o may be, and the variable that has it.
ANGLE: Final = "angle"
E_O: Final = {ANGLE: "rotation_error", "difference": "angle_difference"}
E_O_MEANINGS: Final = {
    ANGLE: "angle of the rotation that is left, defined in every posture",
    "difference": "length of the difference of roll, pitch and yaw, (25), by whole turns",
}
# Mast height at which the arm's base stands for these positions [m]. The paper does not give it;
# this one leaves travel both ways when the mast takes part.
REFERENCE_HEIGHT: Final = 6.0


def targets() -> Array:
    """Desired tool poses X_WE (4, 4, 4)."""
    X_WE = np.tile(np.eye(4), (len(NUMBERS), 1, 1))
    X_WE[:, :3, :3] = kinematics.rotation_from_intrinsic_xyz(ORIENTATIONS)
    X_WE[:, :3, 3] = np.add(POSITIONS, [0.0, 0.0, REFERENCE_HEIGHT])
    return X_WE


def success(data: xr.Dataset) -> xr.DataArray:
    """Return whether each answer is inside both tolerances."""
    return inside(data.position_error, data.rotation_error)


def inside(position: xr.DataArray, rotation: xr.DataArray) -> xr.DataArray:
    """Return whether errors [m], [rad] are inside both tolerances."""
    return (position <= POSITION_TOLERANCE) & (rotation <= ROTATION_TOLERANCE)


def home() -> Array:
    """Home posture (6,) with the mast at the reference height."""
    q = np.array(joints.HOME)
    q[0] = REFERENCE_HEIGHT
    return q


def angle_difference(X_desired: ArrayLike, X: ArrayLike) -> Array:
    """Length (...) [rad] of the difference of roll, pitch and yaw, as in (25), by whole turns.

    Beside the angle of the rotation between the two, because at a pitch of ±π/2 it means little.
    """
    desired, actual = (
        kinematics.intrinsic_xyz_from_rotation(np.asarray(pose)[..., :3, :3])
        for pose in (X_desired, X)
    )
    difference = np.remainder(desired - actual + np.pi, 2.0 * np.pi) - np.pi
    return np.linalg.norm(difference, axis=-1)
