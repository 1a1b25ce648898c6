"""What Table 8 becomes by other readings: without the mast, and by another orientation error."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

import numpy as np
import xarray as xr

from scara_drake import ik
from scara_drake.experiments.claim import Claim
from scara_drake.experiments.inverse_kinematics.postures import (
    ANGLE,
    E_O,
    E_O_MEANINGS,
    MOVES,
    NUMBERS,
    WHO,
    home,
    success,
    targets,
)
from scara_drake.experiments.quantity import Quantity, quantity
from scara_drake.experiments.reading import OpenQuestion, Reading
from scara_drake.recordings.labels import labelled

Judge = Callable[..., Claim]
Solvers = Mapping[str, tuple[str, dict[str, Any]]]

ARM_SOLVERS: Final = ("PSO, tuned", "DPSO, tuned", "DPSO, polished")  # tried without the mast


def arm_alone(seed: int, draws: int, solvers: Solvers) -> xr.Dataset:
    """Return errors and evaluations of ARM_SOLVERS with the mast at rest.

    Args:
        seed: of the first draw.
        draws: for each posture.
        solvers: method and options, by name.
    """
    X_WE, shape = targets(), (len(ARM_SOLVERS), len(NUMBERS), draws)
    found = np.empty((3, *shape))
    for i, name in enumerate(ARM_SOLVERS):
        method, options = solvers[name]
        for k, d in np.ndindex(shape[1:]):
            one = ik.solve(X_WE[k], method, "arm", q_seed=home(), seed=seed + d, **options)
            found[:, i, k, d] = one.position_error, one.rotation_error, one.evaluations
    dims = ("arm_solver", "posture", "arm_draw")
    names = {"position_error": "m", "rotation_error": "rad", "evaluations": "1"}
    columns = {
        f"arm_{name}": labelled(dims, values, unit, f"{name} of the arm alone")
        for (name, unit), values in zip(names.items(), found, strict=True)
    }
    return xr.Dataset(columns, coords={"arm_solver": list(ARM_SOLVERS), "posture": list(NUMBERS)})


def questions(
    data: xr.Dataset, within_tolerance: Judge, small_errors: Judge
) -> tuple[OpenQuestion, ...]:
    """Show what the claims become without the mast, and by another E_o.

    Args:
        data: of `table_8.run`.
        within_tolerance: makes the claim that the tolerances are met.
        small_errors: makes the claim that the errors are small.
    """
    return _who(data, within_tolerance), _measure(data, small_errors)


def _who(data: xr.Dataset, judge: Judge) -> OpenQuestion:
    arm = data[[f"arm_{name}" for name in ("position_error", "rotation_error", "evaluations")]]
    arm = arm.rename({name: name.removeprefix("arm_") for name in map(str, [*arm, *arm.dims])})
    readings = []
    for joints, rows in (("full", data), ("arm", arm)):
        rows = rows.sel(solver=list(ARM_SOLVERS))
        claim = judge(rows, success(rows), "tuned")
        errors = {
            "success, worst posture": claim.measured,
            **{f"best of {name}": _best(rows.sel(solver=name)) for name in ARM_SOLVERS[1:]},
        }
        readings.append(
            Reading(WHO[joints], MOVES[joints], errors, claim.verdict, joints == "full")
        )
    return OpenQuestion("Does the mast take part?", claim.statement, tuple(readings))


def _best(rows: xr.Dataset) -> tuple[Quantity, Quantity]:
    """Smallest errors (posture) over the draws."""
    position, rotation = rows.position_error.min("draw"), rows.rotation_error.min("draw")
    return quantity(1e3 * position.round(6), "mm"), quantity(rotation.round(6), "rad")


def _measure(data: xr.Dataset, judge: Judge) -> OpenQuestion:
    readings = []
    for name, variable in E_O.items():
        rows = data.assign(rotation_error=data[variable])
        good = success(rows)
        claim = judge(rows, good, "DPSO, tuned", "unpolished")
        hits = rows.where(good).sel(solver="DPSO, tuned")
        errors = {
            "E_o, medians": quantity(hits.rotation_error.median("draw"), "rad"),
            "within both tolerances": quantity(
                100 * float(good.sel(solver="DPSO, tuned").mean()), "% of the draws"
            ),
        }
        readings.append(Reading(name, E_O_MEANINGS[name], errors, claim.verdict, name == ANGLE))
    return OpenQuestion("What is E_o?", claim.statement, tuple(readings))
