"""Targets of the inverse kinematics benchmark, and a check that shares no code with the package.

The forward kinematics here is the plain product of the paper's Denavit-Hartenberg rows.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Rows of Table 1: d [m], a [m], alpha [rad]; the mast adds q[0] to d of the first.
DH: Final = np.array(
    [
        [0.0, 0.0, 0.0],
        [0.0, 0.0, -np.pi / 2],
        [0.75, 0.0, np.pi / 2],
        [0.0, 0.82, 0.0],
        [0.0, 0.0, np.pi / 2],
        [0.73, 0.0, 0.0],
    ]
)
# Table 2, [m] and [rad].
LOWER: Final = np.array([2.5, -2 * np.pi, -2 * np.pi, -0.75 * np.pi, -0.75 * np.pi, -2 * np.pi])
UPPER: Final = np.array([10.0, 2 * np.pi, 2 * np.pi, 0.75 * np.pi, 0.75 * np.pi, 2 * np.pi])
POSITION_TOLERANCE, ROTATION_TOLERANCE = 5e-3, 0.0175  # [m], [rad], of the paper
LIMIT_SLACK = 1e-6  # TRAC-IK keeps the limits in single precision
TIME_ALLOWED = 0.25  # [s] for one pose, of the paper

MAST = 5.0  # height that the arm alone keeps [m]
POSITION_NOISE, ROTATION_NOISE = 4e-3, 0.014  # [m], [rad]
POINTS = 50  # of a path
WAYPOINT_SPREAD = 0.4  # of the four waypoints of a path around its centre [rad], [m]


@dataclass(frozen=True)
class Targets:
    """Poses to reach.

    Attributes:
        name: short, for files.
        title: what they are.
        X_WE: poses (n, 4, 4), or (n, points, 4, 4) where they are paths.
        q: the posture (n, 6) that made each pose, or the start of each path.
        seeds: postures (n, 6) where local methods may begin.
        arm: the mast keeps the height MAST.
    """

    name: str
    title: str
    X_WE: Array
    q: Array
    seeds: Array
    arm: bool

    @property
    def paths(self) -> bool:
        """Whether each target is a path."""
        return self.X_WE.ndim == 4

    def __len__(self) -> int:
        return len(self.X_WE)


def forward_kinematics(q: Array) -> Array:
    """Tool poses (..., 4, 4) of postures (..., 6): the product of the rows of Table 1."""
    X = np.broadcast_to(np.eye(4), (*q.shape[:-1], 4, 4))
    for joint, (d, a, alpha) in enumerate(DH):
        theta = np.zeros(q.shape[:-1]) if joint == 0 else q[..., joint]
        lift = q[..., 0] if joint == 0 else np.full(q.shape[:-1], d)
        c, s = np.cos(theta), np.sin(theta)
        ca, sa = np.full_like(c, np.cos(alpha)), np.full_like(c, np.sin(alpha))
        zero, one = np.zeros_like(c), np.ones_like(c)
        rows = [
            [c, -s * ca, s * sa, a * c],
            [s, c * ca, -c * sa, a * s],
            [zero, sa, ca, lift],
            [zero, zero, zero, one],
        ]
        X = X @ np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
    return X


def errors(X_WE: Array, q: Array) -> tuple[Array, Array]:
    """Distance [m] and rotation angle [rad] (...) that postures (..., 6) leave to poses."""
    X = forward_kinematics(q)
    distance = np.linalg.norm(X[..., :3, 3] - X_WE[..., :3, 3], axis=-1)
    turn = np.swapaxes(X_WE[..., :3, :3], -1, -2) @ X[..., :3, :3]
    cosine = 0.5 * (np.trace(turn, axis1=-2, axis2=-1) - 1.0)
    skew = turn - np.swapaxes(turn, -1, -2)
    sine = np.linalg.norm(skew, axis=(-2, -1)) / np.sqrt(8.0)
    return distance, np.arctan2(sine, cosine)


def reached(targets: Targets, q: Array) -> NDArray[np.bool_]:
    """Whether postures, NaN where there is none, are in the ranges and meet the tolerances."""
    distance, angle = errors(targets.X_WE, q)
    good = np.all((q >= LOWER - LIMIT_SLACK) & (q <= UPPER + LIMIT_SLACK), axis=-1)
    good &= (distance <= POSITION_TOLERANCE) & (angle <= ROTATION_TOLERANCE)
    if targets.arm:
        good &= q[..., 0] == MAST
    return good


def make_targets(n: int) -> list[Targets]:
    """Draw the four sets, n poses each and n / 10 paths."""
    return [
        _reachable("arm", f"arm alone, poses that it reaches (mast at {MAST:g} m)", n, True, 1),
        _reachable("mast", "arm and mast, poses that they reach", n, False, 2),
        _disturbed(n),
        _paths(max(1, n // 10)),
    ]


def _postures(n: int, arm: bool, random: np.random.Generator) -> Array:
    q = random.uniform(LOWER, UPPER, (n, 6))
    if arm:
        q[:, 0] = MAST
    return q


def _reachable(name: str, title: str, n: int, arm: bool, seed: int) -> Targets:
    random = np.random.default_rng(seed)
    q = _postures(n, arm, random)
    return Targets(name, title, forward_kinematics(q), q, _postures(n, arm, random), arm)


def _disturbed(n: int) -> Targets:
    """Poses that the arm misses by less than the tolerance: five joints rarely reach six numbers.

    The posture that made the pose stays an answer.
    """
    random = np.random.default_rng(3)
    q = _postures(n, True, random)
    X = forward_kinematics(q)
    X[:, :3, 3] += POSITION_NOISE * _in_ball(n, random)
    for pose, vector in zip(X, ROTATION_NOISE * _in_ball(n, random), strict=True):
        pose[:3, :3] = _rotation(vector) @ pose[:3, :3]
    title = f"arm alone, poses moved by up to {1e3 * POSITION_NOISE:g} mm and {ROTATION_NOISE} rad"
    return Targets("disturbed", title, X, q, _postures(n, True, random), True)


def _paths(n: int) -> Targets:
    """Smooth paths of the arm: joint cubics through four waypoints around a random centre."""
    random = np.random.default_rng(4)
    margin = 2.0 * WAYPOINT_SPREAD  # a cubic swings beyond its waypoints, by less than that
    centre = random.uniform(LOWER + margin, UPPER - margin, (n, 1, 6))
    waypoints = centre + random.uniform(-WAYPOINT_SPREAD, WAYPOINT_SPREAD, (n, 4, 6))
    nodes, s = np.linspace(0.0, 1.0, 4), np.linspace(0.0, 1.0, POINTS)
    basis = np.vander(s, 4) @ np.linalg.inv(np.vander(nodes, 4))  # (points, 4)
    q = basis @ waypoints
    q[..., 0] = MAST
    title = f"arm alone, paths of {POINTS} points (times a point)"
    return Targets("paths", title, forward_kinematics(q), q[:, 0], q[:, 0], True)


def _in_ball(n: int, random: np.random.Generator) -> Array:
    direction = random.normal(size=(n, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    return direction * random.uniform(size=(n, 1)) ** (1.0 / 3.0)


def _rotation(vector: Array) -> Array:
    """Rodrigues' formula."""
    angle = np.linalg.norm(vector)
    x, y, z = vector / angle
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    rotation: Array = np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * K @ K
    return rotation
