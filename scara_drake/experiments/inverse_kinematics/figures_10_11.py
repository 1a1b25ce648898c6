"""Figures 10 and 11: position and orientation errors along a trajectory of 50 points."""

from __future__ import annotations

import xarray as xr

from scara_drake.experiments.claim import (
    OURS,
    PAPER,
    Claim,
    Criterion,
    Experiment,
    at_least,
    at_most,
)
from scara_drake.experiments.inverse_kinematics.paths import METHODS, follow
from scara_drake.experiments.quantity import Value, quantity
from scara_drake.experiments.reading import OpenQuestion, Reading
from scara_drake.ik.result import ROTATION_TOLERANCE

# The three that the paper compares; the position rows by themselves are shown beside its IJ.
COMPARED = ("IJ", "DPSO", "literal DPSOIJ")
OUR_ROWS = "IJ, position rows"
DEFAULT = "The same for our default, with all rows in place of (26)"
PAPER_POSITION = quantity(5.0, "mm", bound="below")
PAPER_ROTATION = quantity(0.0175, "rad", bound="below")
PAPER_IJ = (1.0, 0.048)  # errors of IJ in the figures [mm, rad]
PAPER_BAND = quantity(0.002, "rad", f"of {PAPER_IJ[1]} rad", bound="within")


def run(seed: int = 0, paths: int = 8) -> Experiment:
    """Solve some paths by each method.

    Args:
        seed: of the paths and of the swarms.
        paths: number of paths of 50 points.
    """
    data = follow(list(METHODS), seed, paths)
    return Experiment("Figures 10 and 11", data, claims(data), questions(data))


def claims(data: xr.Dataset) -> list[Claim]:
    """Judge Figures 10 and 11; see `paths.follow` for the data."""
    rotation = data.rotation_error
    return [
        _position(1e3 * data.position_error.max(["path", "point"])),
        _beyond(rotation.sel(solver="IJ"), rotation.sel(solver=OUR_ROWS)),
        _kept(rotation.sel(solver="IJ"), rotation.sel(solver=OUR_ROWS)),
        _first_point(rotation.sel(solver="IJ")),
        *(
            _orientation(rotation.sel(solver=name), statement, source)
            for name, statement, source in (
                ("DPSO", "DPSO keeps the orientation within 0.0175 rad", PAPER),
                ("literal DPSOIJ", "DPSOIJ keeps the orientation within 0.0175 rad", PAPER),
                ("default DPSOIJ", DEFAULT, OURS),
            )
        ),
    ]


def questions(data: xr.Dataset) -> tuple[OpenQuestion, ...]:
    """Show what the claims become by the position rows; see `paths.follow` for the data."""
    top, rotation = 1e3 * data.position_error.max(["path", "point"]), data.rotation_error
    meanings = {
        "IJ": "all six, (1) to (11), position and orientation together",
        OUR_ROWS: "the three of (26), which the paper brings for DPSOIJ",
    }
    readings = []
    for solver, meaning in meanings.items():
        error = rotation.sel(solver=solver)
        within = 100 * float((error <= ROTATION_TOLERANCE).mean())
        # As if this solver were the IJ of the paper.
        position = _position(top.where(top.solver != "IJ", top.sel(solver=solver)))
        found: dict[str, Value] = {
            "largest position error": quantity(top.sel(solver=solver), "mm"),
            "orientation error": quantity(error, "rad"),
            "orientation within 0.0175 rad": quantity(within, "% of the points"),
            "stays beyond 0.0175 rad": _beyond(error, rotation.sel(solver=OUR_ROWS)).verdict,
            "the first point decides": _first_point(error).verdict,
        }
        readings.append(Reading(solver, meaning, found, position.verdict, solver == "IJ"))
    question = "Which rows of the Jacobian are those of IJ?"
    return (OpenQuestion(question, position.statement, tuple(readings)),)


def _position(top: xr.DataArray) -> Claim:
    largest = quantity({name: float(top.sel(solver=name)) for name in COMPARED}, "mm")
    return Claim(
        "All three methods keep the position within 5 mm",
        PAPER_POSITION,
        (largest, quantity(top.sel(solver=OUR_ROWS), "mm", f"{OUR_ROWS}, ours")),
        Criterion(
            "every point of every path (in kind: within twice that, a factor of ours)",
            at_most(largest),
            at_most(largest, 2.0),
        ),
        "IJ solves position and orientation together, (1) to (11), and where it does not meet both "
        "it gives up some of the position; the three position rows go on to the exact one.",
    )


def _beyond(error: xr.DataArray, ours: xr.DataArray) -> Claim:
    points = quantity(error, "rad", "all points")
    share = 100 * float((error > ROTATION_TOLERANCE).mean())
    return Claim(
        "IJ stays beyond 0.0175 rad throughout",
        quantity(PAPER_ROTATION.values, "rad", bound="beyond"),
        (
            points,
            quantity(share, "%", "of the points beyond"),
            quantity(ours, "rad", f"{OUR_ROWS}, ours"),
        ),
        Criterion(
            "every point of every path (in kind: 90 % of them, a share of ours), begun at home",
            at_least(points),
            at_least(points, share=0.9),
        ),
        "The arm can follow these paths exactly, and where the iterations come upon a path from "
        "home, all rows follow it; the position rows leave whatever orientation they end with.",
    )


def _kept(error: xr.DataArray, ours: xr.DataArray) -> Claim:
    drift, other = (
        quantity(abs(e - e.isel(point=0)).max("point"), "rad", label)
        for e, label in ((error, "change"), (ours, f"{OUR_ROWS}, ours"))
    )
    return Claim(
        "IJ keeps the orientation error of its first point",
        PAPER_BAND,
        (drift, other),
        Criterion(
            "within the paper's band of the first point on every path (in kind: "
            f"{ROTATION_TOLERANCE} rad)",
            at_most(drift),
            max(drift.values) <= ROTATION_TOLERANCE,
        ),
        "A path that is met stays met. One that is not asks for another compromise at each point; "
        "and the position rows leave the orientation free, so it drifts.",
    )


def _orientation(error: xr.DataArray, statement: str, source: str) -> Claim:
    share = float((error <= ROTATION_TOLERANCE).mean())
    points = quantity(error, "rad")
    drifts = share < 0.9 and bool((error.isel(point=0) <= ROTATION_TOLERANCE).all())
    return Claim(
        statement,
        PAPER_ROTATION,
        (
            quantity(error.max(), "rad", "largest"),
            quantity(100 * share, "%", "of the points within"),
        ),
        Criterion(
            "every point of every path (in kind: 90 % of them, a share of ours)",
            at_most(points),
            at_most(points, share=0.9),
        ),
        "The first point is solved, the drift comes after it."
        if drifts
        else f"The first points are within {quantity(error.isel(point=0).max(), 'rad')}.",
        source,
    )


def _first_point(error: xr.DataArray) -> Claim:
    inside = error <= ROTATION_TOLERANCE
    good = inside.isel(point=0)
    rest = inside.isel(point=slice(1, None))
    after_good, after_bad = (100 * float(rest.where(some).mean()) for some in (good, ~good))
    return Claim(
        "The first point decides: IJ needs it solved accurately",
        "error kept from the first point on",
        quantity(
            {"after a good first point": after_good, "after a bad one": after_bad},
            "%",
            "of the points within 0.0175 rad",
        ),
        Criterion(
            "at least 95 % after a first point within 0.0175 rad, at most 5 % after another (in "
            "kind: more after a good one); both shares are ours",
            after_good >= 95 and after_bad <= 5,
            after_good > after_bad,
        ),
        "All rows of the Jacobian, begun at home: from a pose that is met, each next one is near.",
    )
