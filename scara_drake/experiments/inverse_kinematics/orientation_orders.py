"""In which order do roll, pitch and yaw turn? Each order is tried on the postures of Table 5."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from scara_drake import ik
from scara_drake.experiments.inverse_kinematics.free_arm import best_of_free_arm
from scara_drake.experiments.inverse_kinematics.postures import (
    NUMBERS,
    ORIENTATIONS,
    home,
    targets,
)
from scara_drake.recordings.labels import labelled

Array = NDArray[np.float64]

SEQUENCES: Final = (
    "xyz", "xzy", "yxz", "yzx", "zxy", "zyx", "xyx", "xzx", "yxy", "yzy", "zxz", "zyz",
)  # fmt: skip
FRAMES: Final = ("turning", "fixed")  # axes
OURS: Final = "xyz, turning axes"  # Rx(roll) Ry(pitch) Rz(yaw)


def rotations(orders: Collection[str] | None = None) -> dict[str, Array]:
    """Return the rotations (4, 3, 3) of Table 5 by the name of each order, all or some.

    An order is three axes, about which the angles turn one after the other; they turn along, or
    stay.
    """
    made = {}
    for frame in FRAMES:
        for sequence in SEQUENCES:
            axes = sequence.upper() if frame == "turning" else sequence
            made[f"{sequence}, {frame} axes"] = Rotation.from_euler(axes, ORIENTATIONS).as_matrix()
    return {name: R for name, R in made.items() if orders is None or name in orders}


def fit(tried: Mapping[str, Array], seed: int, starts: int) -> xr.Dataset:
    """Solve Table 5 with each of the rotations.

    Args:
        tried: rotations (4, 3, 3), by the name of the order.
        seed: of the random starts.
        starts: of the search without joint ranges, for each posture.

    Returns:
        Dataset over (order, posture): errors of the arm with its mast inside Table 2, and of the
        arm alone without joint ranges.
    """
    shape = (len(tried), len(NUMBERS))
    full, free = np.empty((*shape, 2)), np.empty((*shape, 2))
    X_WE = targets()
    for i, R in enumerate(tried.values()):
        X_WE[:, :3, :3] = R
        for k, X in enumerate(X_WE):
            best = ik.solve(X, "robust", "full", q_seed=home(), seed=seed)
            full[i, k] = best.position_error, best.rotation_error
            free[i, k] = best_of_free_arm(X, seed, starts)[:2]
    dims = ("order", "posture")
    return xr.Dataset(
        {
            "order_position_error": labelled(dims, full[..., 0], "m", "with the mast"),
            "order_rotation_error": labelled(dims, full[..., 1], "rad", "with the mast"),
            "order_free_position_error": labelled(
                dims, free[..., 0], "m", "arm alone, without joint ranges"
            ),
            "order_free_rotation_error": labelled(
                dims, free[..., 1], "rad", "arm alone, without joint ranges"
            ),
        },
        coords={"order": list(tried), "posture": list(NUMBERS)},
    )
