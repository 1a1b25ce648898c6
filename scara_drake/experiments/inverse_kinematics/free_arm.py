"""The best posture of the 5-DOF arm alone where each joint turns freely, by random starts."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from scara_drake.experiments.inverse_kinematics.postures import REFERENCE_HEIGHT
from scara_drake.ik.kernels.errors import error_kernel
from scara_drake.ik.kernels.postures import Bounds, Goal
from scara_drake.ik.kernels.refine import Descent, refine_kernel
from scara_drake.ik.result import ROTATION_LENGTH
from scara_drake.joints import LOWER, UPPER

Array = NDArray[np.float64]

HINGES: Final = (3, 4)  # joints 4 and 5 in a posture, which turn less than once


def best_of_free_arm(X: Array, seed: int, starts: int) -> tuple[float, float, float]:
    """Return the errors [m, rad] of the best posture for a tool pose X_WE (4, 4), and its excess.

    The excess [rad] is what joint 4 or 5 lies beyond its range there.

    Args:
        X: tool pose.
        seed: of the random starts.
        starts: of the descents.
    """
    upper = np.array([UPPER[0], *[2.0 * np.pi] * 5])
    lower = np.array([LOWER[0], *[-2.0 * np.pi] * 5])
    p, R = np.ascontiguousarray(X[:3, 3]), np.ascontiguousarray(X[:3, :3])
    generator = np.random.default_rng(seed)
    found = []
    for _ in range(starts):
        q = generator.uniform(-np.pi, np.pi, 6)
        q[0] = REFERENCE_HEIGHT
        goal, descent = (
            Goal(p, R, Bounds(1, lower, upper)),
            Descent(ROTATION_LENGTH, 1.0, 200, True),
        )
        refine_kernel(q, goal, descent, np.empty((0, 2)))
        position, rotation = error_kernel(q, p, R)
        hinges = [abs(np.remainder(q[j] + np.pi, 2.0 * np.pi) - np.pi) for j in HINGES]
        excess = max(0.0, float(max(hinges)) - UPPER[HINGES[0]])
        found.append((np.hypot(position, ROTATION_LENGTH * rotation), excess, position, rotation))
    least = min(row[0] for row in found)
    # Several postures share the least error: the one that leaves the ranges least.
    _, excess, position, rotation = min(
        (row for row in found if row[0] <= least + 1e-4), key=lambda row: row[1]
    )
    return position, rotation, excess
