"""Table 5: which of the four desired postures the arm, and the arm with its mast, can reach."""

from __future__ import annotations

import numpy as np
import xarray as xr

from scara_drake import ik, kinematics
from scara_drake.experiments.claim import Claim, Criterion, Experiment, at_least
from scara_drake.experiments.inverse_kinematics.postures import (
    NUMBERS,
    POSITIONS,
    REFERENCE_HEIGHT,
    WHO,
    home,
    targets,
)
from scara_drake.experiments.quantity import quantity
from scara_drake.ik.kernels.errors import error_kernel
from scara_drake.ik.kernels.postures import Bounds, Goal
from scara_drake.ik.kernels.refine import Descent, refine_kernel
from scara_drake.ik.result import POSITION_TOLERANCE, ROTATION_LENGTH, ROTATION_TOLERANCE
from scara_drake.joints import LOWER, UPPER
from scara_drake.recordings.labels import labelled

JOINTS = ("arm", "full")
PAPER_SOLVED = quantity(4, "of 4 postures")
HINGES = (3, 4)  # joints 4 and 5 in a posture, which turn less than once


def run(seed: int = 0, starts: int = 64) -> Experiment:
    """Look for the best posture for each target, within the joint ranges and, arm alone, without.

    Args:
        seed: of the random starts.
        starts: of the search without joint ranges.
    """
    X_WE, shape = targets(), (len(JOINTS), len(NUMBERS))
    position, rotation, exact = np.empty(shape), np.empty(shape), np.empty(shape)
    reason = np.empty(shape, dtype="<U32")
    for i, joints in enumerate(JOINTS):
        for k, X in enumerate(X_WE):
            best = ik.solve(X, "dpso", joints, q_seed=home(), seed=seed)
            position[i, k], rotation[i, k] = best.position_error, best.rotation_error
            reason[i, k] = best.reason
            point = ik.solve(X, "dpso", joints, task="position", q_seed=home(), seed=seed)
            exact[i, k] = point.rotation_error if point.success else np.nan
    free = np.array([_without_ranges(X, seed, starts) for X in X_WE])
    short = np.array([_short_of(p) for p in POSITIONS])
    dims = ("joints", "posture")
    data = xr.Dataset(
        {
            "position_error": labelled(dims, position, "m", "of the best posture found"),
            "rotation_error": labelled(dims, rotation, "rad", "of the best posture found"),
            "rotation_error_at_position": labelled(
                dims, exact, "rad", "best with the position met exactly; NaN if out of reach"
            ),
            "reason": labelled(dims, reason, "1", "why no posture meets the target"),
            "distance": labelled(
                ("posture",), np.linalg.norm(POSITIONS, axis=1), "m", "|P_d| from the arm's base"
            ),
            "out_of_reach": labelled(
                ("posture",), short, "m", "what the arm lacks to touch P_d, its beam horizontal"
            ),
            "free_position_error": labelled(
                ("posture",), free[:, 0], "m", "arm alone, without joint ranges"
            ),
            "free_rotation_error": labelled(
                ("posture",), free[:, 1], "rad", "arm alone, without joint ranges"
            ),
            "free_excess": labelled(
                ("posture",), free[:, 2], "rad", "how far joint 4 or 5 is beyond its range there"
            ),
        },
        coords={"joints": list(JOINTS), "posture": list(NUMBERS)},
        attrs={"seed": seed, "mast_height": REFERENCE_HEIGHT},
    )
    return Experiment("Table 5", data, claims(data))


def claims(data: xr.Dataset) -> list[Claim]:
    """Judge that the postures can be reached; see `run` for the data."""
    inside = (data.position_error <= POSITION_TOLERANCE) & (
        data.rotation_error <= ROTATION_TOLERANCE
    )
    return [_solved(data, inside, joints, who) for joints, who in WHO.items()]


def _solved(data: xr.Dataset, inside: xr.DataArray, joints: str, who: str) -> Claim:
    met = inside.sel(joints=joints)
    count = quantity(int(met.sum()), PAPER_SOLVED.unit)
    return Claim(
        f"The four desired postures can be solved (Table 8), by {who}",
        PAPER_SOLVED,
        count,
        Criterion(
            "all four within 5 mm and 0.0175 rad inside Table 2 (in kind: three)",
            at_least(count),
            at_least(count, 0.75),
        ),
        _evidence(data, joints, met),
    )


def _evidence(data: xr.Dataset, joints: str, met: xr.DataArray) -> str:
    parts = []
    for number in data.posture.values[~met.values]:
        row = data.sel(posture=number, joints=joints)
        if joints == "arm" and row.out_of_reach > 0.0:
            parts.append(
                f"posture {number} lies {1e3 * float(row.distance):.0f} mm from the arm's base, "
                f"beyond its length of {1e3 * kinematics.REACH:.0f} mm, and "
                f"{1e3 * float(row.out_of_reach):.0f} mm beyond its reach at that height"
            )
        elif joints == "arm" and row.free_rotation_error <= ROTATION_TOLERANCE:
            parts.append(
                f"posture {number} is met to {float(row.free_rotation_error):.3f} rad only with "
                f"joint 4 or 5 {float(row.free_excess):.2f} rad beyond its range of Table 2, else "
                f"to {float(row.rotation_error):.2f} rad"
            )
        else:
            parts.append(
                f"posture {number} is met to {1e3 * float(row.position_error):.1f} mm and "
                f"{float(row.rotation_error):.3f} rad at best"
            )
    if joints == "full":
        parts.append(
            f"the mast height of Table 5 is not given: {REFERENCE_HEIGHT:g} m here, which leaves "
            "the mast the travel it needs"
        )
    text = "; ".join(parts)
    return text[0].upper() + text[1:] + "." if parts else "All lie inside the joint ranges."


def _short_of(p: tuple[float, float, float]) -> float:
    # The beam stays horizontal; forearm and tool must bridge what is left from its end.
    left = np.hypot(np.hypot(p[0], p[1]) - kinematics.D3, p[2])
    return max(0.0, float(left) - kinematics.A4 - kinematics.D6)


def _without_ranges(X: np.ndarray, seed: int, starts: int) -> tuple[float, float, float]:
    """Errors of the best posture of the arm where each joint turns freely, and its excess."""
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
