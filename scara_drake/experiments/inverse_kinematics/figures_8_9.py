"""Figures 8 and 9: how PSO and DPSO converge on the four desired postures."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from scara_drake import ik
from scara_drake.experiments.claim import Claim, Criterion, Experiment, within_factor
from scara_drake.experiments.inverse_kinematics.postures import (
    NUMBERS,
    REFERENCE_HEIGHT,
    home,
    targets,
)
from scara_drake.experiments.quantity import Quantity, quantity
from scara_drake.ik.options import PAPER
from scara_drake.recordings.labels import labelled

Array = NDArray[np.float64]

# One pass of the paper's structure; of several draws, the first that succeeds is shown.
SOLVERS: Final[dict[str, tuple[str, dict[str, Any]]]] = {
    "PSO": ("pso", {"parameters": "paper"}),
    "DPSO": ("dpso", {"parameters": "paper", "polish": False}),
}
# The single swarm's inertia as it would stay without (53).
UNDAMPED: Final = PAPER._replace(single=PAPER.single._replace(inertia_damping=1.0))
PAPER_ITERATIONS = {"PSO": quantity(66, "iterations"), "DPSO": quantity(52, "iterations")}


def run(seed: int = 0, draws: int = 30) -> Experiment:
    """Keep the errors of the best particle at each iteration, for the first draw that succeeds.

    Args:
        seed: of the first draw; draw k has seed + k.
        draws: tried at most; also for the success without the damping (53).
    """
    histories: dict[tuple[str, int], Array] = {}
    damped = undamped = 0
    for name, (method, options) in SOLVERS.items():
        for number, X in zip(NUMBERS, targets(), strict=True):
            for k in range(draws):
                answer = ik.solve(X, method, q_seed=home(), seed=seed + k, history=True, **options)
                if answer.success:
                    break
            histories[name, number] = np.asarray(answer.history)
    for X in targets():
        for k in range(draws):
            arguments: dict[str, Any] = {"q_seed": home(), "seed": seed + k}
            damped += ik.solve(X, "pso", parameters="paper", **arguments).success
            # One pass, as the named set has it.
            undamped += ik.solve(X, "pso", parameters=UNDAMPED, **arguments).success
    length = max(len(rows) for rows in histories.values())
    errors = np.full((len(SOLVERS), len(NUMBERS), length, 2), np.nan)
    for i, name in enumerate(SOLVERS):
        for k, number in enumerate(NUMBERS):
            rows = histories[name, number]
            errors[i, k, : len(rows)] = rows
    dims = ("solver", "posture", "iteration")
    data = xr.Dataset(
        {
            "position_error": labelled(dims, errors[..., 0], "m", "of the best particle"),
            "rotation_error": labelled(dims, errors[..., 1], "rad", "of the best particle"),
            "damped_success": labelled(
                (), damped / (4 * draws), "1", "share of the draws of PSO, with (53)"
            ),
            "undamped_success": labelled(
                (), undamped / (4 * draws), "1", "share of the draws of PSO, inertia constant"
            ),
        },
        coords={
            "solver": list(SOLVERS),
            "posture": list(NUMBERS),
            "iteration": np.arange(length),
        },
        attrs={"seed": seed, "mast_height": REFERENCE_HEIGHT},
    )
    return Experiment("Figures 8 and 9", data, claims(data))


def claims(data: xr.Dataset) -> list[Claim]:
    """Judge Figures 8 and 9; see `run` for the data."""
    count = data.position_error.notnull().sum("iteration")
    return [
        *(_mean(count.sel(solver=name), name, paper) for name, paper in PAPER_ITERATIONS.items()),
        _damping(100 * float(data.damped_success), 100 * float(data.undamped_success)),
    ]


def _mean(rows: xr.DataArray, name: str, paper: Quantity) -> Claim:
    mean = quantity(rows.mean(), paper.unit)
    each = {f"posture {n}": int(rows.sel(posture=n)) for n in rows.posture.values}
    return Claim(
        f"{name} converges in so many iterations (mean)",
        paper,
        (mean, quantity(each)),
        Criterion(
            "within a factor of 1.5 (in kind: of 3), first successful draw at each posture, the "
            "stages of DPSO added",
            within_factor(mean, 1.5),
            within_factor(mean, 3.0),
        ),
        "The coefficients are assumed, those of the paper being lost.",
    )


def _damping(damped: float, undamped: float) -> Claim:
    return Claim(
        "PSO converges only once its inertia is damped, (53)",
        "not without",
        quantity({"without": undamped, "with": damped}, "%", "of the draws"),
        Criterion(
            "no draw succeeds without damping, some do with it (in kind: fewer)",
            undamped == 0.0 < damped,
            undamped < damped,
        ),
        "With its inertia constant the swarm goes on flying past its best particle.",
    )
