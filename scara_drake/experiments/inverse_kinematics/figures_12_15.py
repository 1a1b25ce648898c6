"""Figures 12 to 15: joints 3 and 4 along a trajectory, by DPSO and by DPSOIJ."""

from __future__ import annotations

import numpy as np
import xarray as xr

from scara_drake.experiments.claim import OURS, PAPER, Claim, Criterion, Experiment, within_factor
from scara_drake.experiments.inverse_kinematics.paths import follow, steps
from scara_drake.experiments.quantity import quantity

JOINTS = ("theta3", "theta4")
PAPER_JUMP = quantity(3.0, "rad", bound="up to")
JUMP = 0.5  # [rad]: a change that no 50-point path asks for


def run(seed: int = 0, paths: int = 8) -> Experiment:
    """Solve some paths by DPSO at each point, and by DPSOIJ, literal and default.

    Args:
        seed: of the paths and of the swarms.
        paths: number of paths of 50 points.
    """
    data = follow(["DPSO", "literal DPSOIJ", "default DPSOIJ"], seed, paths)
    return Experiment("Figures 12 to 15", data, claims(data))


def claims(data: xr.Dataset) -> list[Claim]:
    """Judge Figures 12 to 15; see `paths.follow` for the data."""
    return [
        _jumps(data.q.sel(solver="DPSO")),
        _smooth(data, "literal DPSOIJ", "DPSOIJ", PAPER),
        _smooth(data, "default DPSOIJ", "Our default DPSOIJ", OURS),
    ]


def _jumps(q: xr.DataArray) -> Claim:
    jumps, wrapped = (steps(q, JOINTS, turns) for turns in (True, False))
    top = quantity(jumps.max(), "rad", bound="up to")
    some = quantity(int((jumps > JUMP).sum()), f"of {jumps.size} paths")
    return Claim(
        "DPSO at every point jumps between neighbouring points",
        PAPER_JUMP,
        (top, some),
        Criterion(
            "the largest step of joints 3 and 4, as the drives would have to take it, within a "
            f"factor of 1.5 (in kind: above {JUMP} rad); both are ours",
            within_factor(top, 1.5),
            top.values[0] > JUMP,
        ),
        f"Without whole turns the largest is {float(wrapped.max()):.1f} rad, where no more than "
        f"{np.pi:.2f} is possible. A tool pose has a mirrored posture, half a turn of joint 3 away;"
        " DPSO jumps on the paths where both lie inside the joint ranges.",
    )


def _smooth(data: xr.Dataset, solver: str, who: str, source: str) -> Claim:
    largest = steps(data.q.sel(solver=solver), JOINTS)
    asked = steps(data.q_path, JOINTS)
    ratio = largest / asked
    return Claim(
        f"{who} gives smooth paths of joints 3 and 4",
        "smooth",
        (
            quantity(largest.max(), "rad", "largest step"),
            quantity(ratio, "times those of the path"),
        ),
        Criterion(
            "on every path no step beyond twice the largest that the path asks for (in kind: none "
            f"above {JUMP} rad); both bounds are ours",
            bool((ratio <= 2.0).all()),
            bool((largest <= JUMP).all()),
        ),
        f"The paths ask for {float(asked.max()):.2f} rad at most, and the Jacobian goes on from "
        "the point before.",
        source,
    )
