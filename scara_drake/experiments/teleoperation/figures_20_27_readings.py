"""What Figures 20 to 27 become by other readings of the delay and of the units."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np
import xarray as xr

from scara_drake import kinematics
from scara_drake.experiments.claim import Claim, Criterion, at_most
from scara_drake.experiments.quantity import Quantity, Value, parts, quantity
from scara_drake.experiments.reading import OpenQuestion, Reading
from scara_drake.experiments.teleoperation.delay_readings import DELAYS
from scara_drake.experiments.teleoperation.tool_error import PARTS, rms, tool_errors
from scara_drake.recordings.labels import labelled
from scara_drake.scenario import load_scenario
from scara_drake.simulation.run import simulate

ALL: Final = "in all"
MM: Final = "mast in mm and N"
UNITS: Final = {
    "normalised": (
        "acceleration",
        "m/s², times the nominal inertia; the integral holds the weight",
    ),
    MM: ("mm and N", "the mast's positions in mm, and u in N"),
}


def over_each_delay(scenario: str, seed: int, duration: float, start: float) -> xr.DataArray:
    """RMS error (delay, cause) of the tool [m] over each channel that the paper's delay may be.

    Args:
        scenario: its name.
        seed: of it.
        duration: [s].
        start: from when on the error counts [s].
    """
    rows = []
    for reading in DELAYS.values():
        changed = load_scenario(scenario, {**reading.overrides, "seed": seed})
        one = simulate(changed, duration=duration)
        reference = kinematics.forward_kinematics(one.q_desired)[:, :3, 3]
        one["p_WE_reference"] = one.p_WE_desired.copy(data=reference)
        errors = tool_errors(one).sel(time=slice(start, None))
        rows.append([1e-3 * value for value in (*(rms(errors, p) for p in PARTS), rms(errors))])
    values = labelled(("delay", "cause"), np.array(rows), "m", "RMS error of the tool by its cause")
    return xr.DataArray(values, coords={"delay": list(DELAYS), "cause": [*PARTS, ALL]})


def delay(errors: xr.DataArray, small: Claim, allowed: Quantity) -> OpenQuestion:
    """Show the tool's error over each delay.

    Args:
        errors: of `over_each_delay`.
        small: the claim that the error is small, channel and controller left out.
        allowed: what is small.
    """
    own = next(one for one in parts(small.measured) if isinstance(one, Quantity))
    found: dict[str, Value] = {
        "by the channel": "none",
        "judged": quantity(own.values[0], "mm", "RMS"),
    }
    meaning = "as the paper draws them, before it brings in a delay, and without the robot"
    readings = [Reading("no delay", meaning, found, small.verdict, chosen=True)]
    for name, reading in DELAYS.items():
        error = 1e3 * errors.sel(delay=name)
        whole = quantity(error.sel(cause=ALL), "mm", "RMS, in all")
        found = {
            "by the channel": quantity(error.sel(cause="channel"), "mm", "RMS"),
            "judged": whole,
        }
        verdict = Criterion("", at_most(whole)).verdict(allowed)
        readings.append(Reading(reading.name, reading.meaning, found, verdict))
    question = "Is there a delay in Figures 20 and 21, and which?"
    return OpenQuestion(question, small.statement, tuple(readings))


def units(mast: Callable[[str], Claim]) -> OpenQuestion:
    """Show the mast's error in each unit.

    Args:
        mast: makes the claim about the mast, judged by the run of that name.
    """
    readings = []
    for run, (name, meaning) in UNITS.items():
        claim = mast(run)
        rest, rising = parts(claim.measured)[:2]
        found = {"at rest": rest, "while rising": rising}
        readings.append(Reading(name, meaning, found, claim.verdict, run == MM))
    return OpenQuestion("In which units is u of the mast?", claim.statement, tuple(readings))
