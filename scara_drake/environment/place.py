"""Where surfaces stand: frames along a direction, corners, and distances with rounded edges."""

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydrake.math import RigidTransform, RotationMatrix

Array = NDArray[np.float64]


def facing(direction: list[float]) -> RotationMatrix:
    """R_WS with z along a direction, x level; y up, or along the world's y if z is upright."""
    z = np.array(direction) / np.linalg.norm(direction)
    x = np.cross([0.0, 1.0, 0.0] if abs(z[2]) > 0.99 else [0.0, 0.0, 1.0], z)
    x /= np.linalg.norm(x)
    return RotationMatrix(np.column_stack([x, np.cross(z, x), z]))


def corners_of(X_WS: RigidTransform, half: list[float]) -> Array:
    """Corners (n, 3) in W [m] of a block with half its sides (3,) [m]; a side of zero is flat."""
    signs = np.stack(np.meshgrid(*[(-h, h) if h > 0.0 else (0.0,) for h in half]), axis=-1)
    corners: Array = (X_WS @ signs.reshape(-1, 3).T).T
    return corners


@njit(cache=True)
def rounded_distance(p: Array, half: Array, edge: float, gradient: Array) -> float:
    """Signed distance [m] of p (n,) from the box |p_k| <= half_k with rounded edges.

    Writes the unit gradient (n,). Outside, and up to `edge` below a rounded edge, it is continuous;
    deeper it jumps where two faces are equally near.
    """
    outside, nearest, face = 0.0, -np.inf, 0
    for k in range(half.size):
        beyond = abs(p[k]) - (half[k] - edge)  # of the core, which the rounding surrounds
        outside += max(beyond, 0.0) ** 2
        if beyond > nearest:
            nearest, face = beyond, k
    if outside == 0.0:
        gradient[: half.size] = 0.0
        gradient[face] = 1.0 if p[face] >= 0.0 else -1.0
        return nearest - edge
    length = np.sqrt(outside)
    for k in range(half.size):
        beyond = max(abs(p[k]) - (half[k] - edge), 0.0)
        gradient[k] = (beyond if p[k] >= 0.0 else -beyond) / length
    return length - edge
