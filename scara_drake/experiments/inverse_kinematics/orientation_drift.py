"""Section III-C-2: after an accurate first point, does DPSOIJ keep the orientation?"""

from __future__ import annotations

import xarray as xr

from scara_drake import joints
from scara_drake.experiments.claim import OURS, PAPER, Claim, Criterion, Experiment
from scara_drake.experiments.inverse_kinematics.paths import follow, steps
from scara_drake.experiments.quantity import quantity
from scara_drake.ik.result import ROTATION_TOLERANCE

JOINTS, JUMP = ("theta3", "theta4"), 0.5  # [rad]
LIMITS = (joints.LOWER, joints.UPPER)


def run(seed: int = 0, paths: int = 20) -> Experiment:
    """Follow some paths by the literal DPSOIJ and by our default.

    Args:
        seed: of the paths and of the swarms.
        paths: number of paths of 50 points.
    """
    data = follow(["literal DPSOIJ", "default DPSOIJ"], seed, paths)
    return Experiment("Section III-C-2, drift", data, claims(data))


def drift(error: xr.DataArray) -> xr.DataArray:
    """Return the largest growth of an error beyond that of the first point."""
    return (error - error.isel(point=0)).max("point")


def why(rows: xr.Dataset) -> str:
    """Say what the drifting paths of one solver have in common."""
    moved = abs(rows.q.sel(joint="theta6").diff("point")).max()
    if moved == 0.0:
        tilt = drift(rows.tool_axis_error)
        return (
            "Joint 6 does not move the tool point, so (26) never turns it; but the axis of the "
            f"tool alone drifts by {quantity(tilt, 'rad')} too."
        )
    lost = drift(rows.rotation_error) > ROTATION_TOLERANCE
    jumped = steps(rows.q, JOINTS) > JUMP
    lower, upper = (xr.DataArray(x, coords={"joint": rows.joint}) for x in LIMITS)
    stopped = ((rows.q <= lower) | (rows.q >= upper)).any(["point", "joint"]) & lost
    return (
        f"Of {lost.size} paths, {int(lost.sum())} lose the orientation ({int(stopped.sum())} where"
        f" a joint meets its range) and {int(jumped.sum())} jump."
    )


def claims(data: xr.Dataset) -> list[Claim]:
    """Judge the drift; see `paths.follow` for the data."""
    return [
        _kept(
            data.sel(solver="literal DPSOIJ"),
            "DPSOIJ keeps the orientation of an accurate first point",
            PAPER,
        ),
        _kept(
            data.sel(solver="default DPSOIJ"),
            "The same for our default, with all rows in place of (26)",
            OURS,
        ),
    ]


def _kept(rows: xr.Dataset, statement: str, source: str) -> Claim:
    grown = drift(rows.rotation_error)
    largest = steps(rows.q, JOINTS)
    kept = (grown <= ROTATION_TOLERANCE) & (largest <= JUMP)
    return Claim(
        statement,
        "no drift",
        (
            quantity(grown, "rad"),
            quantity(grown.median(), "rad", "median"),
            quantity(largest.max(), "rad", "largest step"),
        ),
        Criterion(
            f"on every path the error grows by no more than {ROTATION_TOLERANCE} rad and joints 3 "
            f"and 4 take no step above {JUMP} rad (in kind: on half of the paths); the "
            "step is ours",
            bool(kept.all()),
            bool(kept.mean() >= 0.5),
        ),
        why(rows),
        source,
    )
