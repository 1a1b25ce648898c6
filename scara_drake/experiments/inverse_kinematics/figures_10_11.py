"""Figures 10 and 11: position and orientation errors along a trajectory of 50 points."""

from __future__ import annotations

import xarray as xr

from scara_drake.experiments.claim import Claim, Experiment, judge, span
from scara_drake.experiments.inverse_kinematics.paths import METHODS, follow
from scara_drake.ik.result import POSITION_TOLERANCE, ROTATION_TOLERANCE

# The three that the paper compares.
COMPARED = ("IJ", "DPSO", "literal DPSOIJ")
PAPER_START, PAPER_BAND = 0.048, 0.002  # [rad], orientation error of IJ


def run(seed: int = 0, paths: int = 8) -> Experiment:
    """Solve some paths by each method.

    Args:
        seed: of the paths and of the swarms.
        paths: number of paths of 50 points.
    """
    data = follow(list(METHODS), seed, paths)
    return Experiment("Figures 10 and 11", data, claims(data))


def claims(data: xr.Dataset) -> list[Claim]:
    """Judge Figures 10 and 11; see `paths.follow` for the data."""
    position = data.position_error.sel(solver=list(COMPARED)).max(["path", "point"])
    jacobian = data.rotation_error.sel(solver="IJ")
    start = jacobian.isel(point=0)
    drift = abs(jacobian - start).max("point")
    found = [
        Claim(
            "All three methods keep the position within 5 mm",
            "below 5 mm",
            ", ".join(
                f"{name} {1e3 * float(position.sel(solver=name)):.1f} mm" for name in COMPARED
            ),
            judge(
                bool((position <= POSITION_TOLERANCE).all()),
                bool((position <= 2 * POSITION_TOLERANCE).all()),
            ),
            "Criterion: every point of every path (in kind: within 10 mm).",
        ),
        Claim(
            "IJ stays beyond 0.0175 rad throughout",
            "0.048 rad",
            f"smallest {float(jacobian.min()):.2f} rad",
            judge(
                bool((jacobian > ROTATION_TOLERANCE).all()),
                bool((jacobian > ROTATION_TOLERANCE).mean() >= 0.9),
            ),
            "Criterion: every point of every path (in kind: 90 % of them), begun at home.",
        ),
        Claim(
            "IJ keeps the orientation error of its first point",
            f"{PAPER_START} ± {PAPER_BAND} rad",
            f"changes by {span(drift.values)} rad",
            judge(bool((drift <= PAPER_BAND).all()), bool((drift <= ROTATION_TOLERANCE).all())),
            "Criterion: within 0.002 rad of the first point on every path (in kind: 0.0175 rad). "
            "The position rows (26) leave the orientation free, so it drifts; it stays only where "
            "the path happens to ask for no turn.",
        ),
    ]
    found.append(_first_point(data.rotation_error.sel(solver="IJ, all rows")))
    for name, statement in (
        ("DPSO", "DPSO keeps the orientation within 0.0175 rad"),
        ("literal DPSOIJ", "DPSOIJ keeps the orientation within 0.0175 rad"),
        ("default DPSOIJ", "The same for our default, with all rows in place of (26)"),
    ):
        error = data.rotation_error.sel(solver=name)
        share = float((error <= ROTATION_TOLERANCE).mean())
        found.append(
            Claim(
                statement,
                "below 0.0175 rad",
                f"largest {float(error.max()):.2g} rad, {100 * share:.0f} % of the points within",
                judge(share == 1.0, share >= 0.9),
                "Criterion: every point of every path (in kind: 90 % of them)."
                + (
                    " The first point is solved, the drift comes after it."
                    if share < 0.9 and bool((error.isel(point=0) <= ROTATION_TOLERANCE).all())
                    else ""
                ),
            )
        )
    return found


def _first_point(error: xr.DataArray) -> Claim:
    inside = error <= ROTATION_TOLERANCE
    good = inside.isel(point=0)
    rest = inside.isel(point=slice(1, None))
    after_good, after_bad = (100 * float(rest.where(some).mean()) for some in (good, ~good))
    return Claim(
        "The first point decides: IJ needs it solved accurately",
        "error kept from the first point on",
        f"{after_good:.0f} % of the points within 0.0175 rad after a good first point, "
        f"{after_bad:.0f} % after a bad one",
        judge(after_good >= 95 and after_bad <= 5, after_good > after_bad),
        "Criterion: all rows of the Jacobian, begun at home; at least 95 % after a first point "
        "within 0.0175 rad, at most 5 % after another (in kind: more after a good one).",
    )
