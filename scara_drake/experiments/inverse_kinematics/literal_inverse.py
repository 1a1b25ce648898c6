"""The inverse Jacobian as equations (8) to (10) write it: J^T (J J^T)^-1, without damping.

Of the arm alone J is 6 x 5 and J J^T has no inverse; what the arithmetic makes of one is rounding.
With the mast J is square and this is Newton's method.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from scara_drake import kinematics

Array = NDArray[np.float64]

TURN = 2.0 * np.pi


def iterate(X_WE: Array, q_start: Array, joints: str, iterations: int) -> Array:
    """Return the postures (m, n, 6) after so many steps (10) towards m poses from n starts.

    A start whose J J^T has no inverse in the arithmetic stays where it is.

    Args:
        X_WE: poses (m, 4, 4).
        q_start: postures (n, 6).
        joints: "arm" keeps the mast, "full" moves all six.
        iterations: at most.
    """
    first = 1 if joints == "arm" else 0
    q = np.tile(q_start, (len(X_WE), 1, 1))
    for _ in range(iterations):
        X = kinematics.forward_kinematics(q)
        left = X_WE[:, np.newaxis, :3, :3] @ X[..., :3, :3].swapaxes(-1, -2)
        turned = Rotation.from_matrix(left.reshape(-1, 3, 3)).as_rotvec()
        moved = X_WE[:, np.newaxis, :3, 3] - X[..., :3, 3]
        dP = np.concatenate([turned.reshape(moved.shape), moved], axis=-1)
        J = kinematics.jacobian(q)[..., first:]
        JT = J.swapaxes(-1, -2)
        q[..., first:] += (JT @ _inverse(J @ JT) @ dP[..., np.newaxis])[..., 0]
        q[..., 1:] = np.remainder(q[..., 1:] + np.pi, TURN) - np.pi
    return q


def _inverse(gram: Array) -> Array:
    """Inverse (..., 6, 6), zero where the arithmetic finds none."""
    made = np.zeros_like(gram)
    for index in np.ndindex(gram.shape[:-2]):
        try:
            made[index] = np.linalg.inv(gram[index])
        except np.linalg.LinAlgError:
            continue
    return np.where(np.isfinite(made), made, 0.0)
