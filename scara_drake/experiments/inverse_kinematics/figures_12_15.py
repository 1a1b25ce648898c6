"""Figures 12 to 15: joints 3 and 4 along a trajectory, by DPSO and by DPSOIJ."""

from __future__ import annotations

import xarray as xr

from scara_drake.experiments.claim import Claim, Experiment, judge, span
from scara_drake.experiments.inverse_kinematics.paths import follow, steps

JOINTS = ("theta3", "theta4")
PAPER_JUMP = 3.0  # [rad], "up to"
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
    largest = steps(data.q, JOINTS)
    asked = steps(data.q_path, JOINTS)
    jumps, turned = (steps(data.q, JOINTS, turns).sel(solver="DPSO") for turns in (False, True))
    top, some = float(jumps.max()), int((jumps > JUMP).sum())
    found = [
        Claim(
            "DPSO at every point jumps between neighbouring points",
            f"up to {PAPER_JUMP:g} rad",
            f"up to {top:.1f} rad, on {some} of {jumps.size} paths",
            judge(PAPER_JUMP / 1.5 <= top <= 1.5 * PAPER_JUMP, top > JUMP),
            "Criterion: the largest step of joints 3 and 4 without whole turns within a factor of "
            f"1.5 (in kind: above 0.5 rad); with whole turns {float(turned.max()):.1f} rad. A tool "
            "pose has a mirrored posture, half a turn of joint 3 away; DPSO jumps on the paths "
            "where both lie inside the joint ranges.",
        )
    ]
    for name, who in (("literal DPSOIJ", "DPSOIJ"), ("default DPSOIJ", "Our default DPSOIJ")):
        ratio = largest.sel(solver=name) / asked
        found.append(
            Claim(
                f"{who} gives smooth paths of joints 3 and 4",
                "smooth",
                f"steps up to {float(largest.sel(solver=name).max()):.2f} rad, "
                f"{span(ratio.values, 1)} times those of the path",
                judge(bool((ratio <= 2.0).all()), bool((largest.sel(solver=name) <= JUMP).all())),
                "Criterion: on every path no step beyond twice the largest that the path asks for "
                f"({float(asked.max()):.2f} rad at most; in kind: none above 0.5 rad).",
            )
        )
    return found
