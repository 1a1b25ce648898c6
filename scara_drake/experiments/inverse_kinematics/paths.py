"""Planned trajectories of 50 points, solved by each method; the paper does not give its own.

Each path is a cubic of the joints through four postures near a random centre, with the mast at
rest, so that the arm can follow all of it exactly within the joint ranges.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any, Final, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from scara_drake import ik, kinematics
from scara_drake.experiments.inverse_kinematics.postures import REFERENCE_HEIGHT, home
from scara_drake.joints import JOINT_NAMES, LOWER, UPPER
from scara_drake.recordings.labels import labelled

Array = NDArray[np.float64]

POINTS: Final = 50
SPREAD: Final = 0.4  # of the postures around the centre [rad]


class Method(NamedTuple):
    """How `ik.solve_path` is called."""

    name: str
    task: str
    options: dict[str, Any]


# "IJ" is that of equations (1) to (11), with all six rows of the Jacobian; the three of (26) belong
# to DPSOIJ in the paper, and by themselves they are ours.
# "DPSO" and the first point of "literal DPSOIJ" begin again where a pass fails, because the paper
# has them inside the tolerance. "DPSO" has the paper's structure with tuned coefficients, those of
# the paper being lost.
METHODS: Final[dict[str, Method]] = {
    "IJ": Method("inverse_jacobian", "pose", {"rows": "full"}),
    "IJ, position rows": Method("inverse_jacobian", "position", {"rows": "position"}),
    "DPSO": Method("dpso", "pose", {"polish": False}),
    "literal DPSOIJ": Method("dpsoij", "pose", {"variant": "paper", "budget": 400_000}),
    "default DPSOIJ": Method("dpsoij", "pose", {}),
}


def joint_paths(seed: int, paths: int) -> Array:
    """Joint paths (paths, 50, 6) within the joint ranges, the mast at the reference height."""
    generator = np.random.default_rng(seed)
    q = np.empty((paths, POINTS, 6))
    s = np.linspace(0.0, 3.0, POINTS)
    for path in q:
        centre = 0.8 * generator.uniform(LOWER, UPPER)
        centre += 0.1 * (LOWER + UPPER)
        knots = centre + generator.uniform(-SPREAD, SPREAD, (4, 6))
        cubics = [np.polyval(np.polyfit(range(4), knot, 3), s) for knot in knots.T]
        path[:] = np.clip(np.column_stack(cubics), LOWER, UPPER)
    q[:, :, 0] = REFERENCE_HEIGHT
    return q


def follow(methods: Sequence[str], seed: int, paths: int) -> xr.Dataset:
    """Solve the paths by some of METHODS, all from the home posture.

    Returns:
        Dataset over (solver, path, point, joint); see its variables.
    """
    q_path = joint_paths(seed, paths)
    X_WE = kinematics.forward_kinematics(q_path)
    shape = (len(methods), paths, POINTS)
    q, wall_time = np.empty((*shape, 6)), np.empty(shape[:2])
    evaluations = np.empty(shape, dtype=np.int64)
    for i, name in enumerate(methods):
        method = METHODS[name]
        arguments = {"joints": "arm", "task": method.task, "q_seed": home(), **method.options}
        ik.solve_path(X_WE[0, :2], method.name, seed=seed, **arguments)  # compiles
        for k in range(paths):
            start = time.perf_counter()
            # A swarm draws anew for each point; the paths' draws are apart.
            answer = ik.solve_path(X_WE[k], method.name, seed=seed + k * POINTS, **arguments)
            wall_time[i, k] = time.perf_counter() - start
            q[i, k], evaluations[i, k] = answer.q, answer.evaluations
    X = kinematics.forward_kinematics(q)
    position, rotation = kinematics.pose_error(X_WE, X)
    cosine = (X_WE[..., :3, 2] * X[..., :3, 2]).sum(axis=-1)
    points, units = ("solver", "path", "point"), "m for d1, rad for the others"
    return xr.Dataset(
        {
            "q": labelled((*points, "joint"), q, units, "answers"),
            "q_path": labelled(
                ("path", "point", "joint"), q_path, units, "joints that the path was made from"
            ),
            "position_error": labelled(points, position, "m", "distance to the target"),
            "rotation_error": labelled(points, rotation, "rad", "angle to the target rotation"),
            "tool_axis_error": labelled(
                points,
                np.arccos(np.clip(cosine, -1.0, 1.0)),
                "rad",
                "angle between the tool axis and its target, which joint 6 cannot change",
            ),
            "evaluations": labelled(points, evaluations, "1", "forward kinematics spent"),
            "wall_time": labelled(points[:2], wall_time, "s", "of the whole path", measured=True),
        },
        coords={
            "solver": list(methods),
            "path": np.arange(paths),
            "point": np.arange(1, POINTS + 1),
            "joint": list(JOINT_NAMES),
        },
        attrs={"seed": seed, "mast_height": REFERENCE_HEIGHT},
    )


def steps(q: xr.DataArray, joints: Sequence[str], turns: bool = True) -> xr.DataArray:
    """Largest change (...) of some joints between neighbouring points [rad].

    Args:
        q: joints over (..., point, joint).
        joints: which of them.
        turns: count whole turns, as a drive has to; without them it is at most half a turn.
    """
    change = q.sel(joint=list(joints)).diff("point")
    if not turns:
        change = (change + np.pi) % (2.0 * np.pi) - np.pi
    return abs(change).max(["joint", "point"])
