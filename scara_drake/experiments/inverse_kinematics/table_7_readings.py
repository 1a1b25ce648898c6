"""The readings that the swarms' text leaves open, beside each other as the search found them."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import xarray as xr

from scara_drake.experiments.inverse_kinematics.swarm_statements import COUNTS, STAGES
from scara_drake.experiments.quantity import quantity
from scara_drake.experiments.reading import OpenQuestion, Reading

CLAIM: Final = "One set of coefficients agrees with all that is reported of the swarms"
# By the field of Law: the question, and each value with its name and meaning.
ASKED: Final[dict[str, tuple[str, dict[int, tuple[str, str]]]]] = {
    "literal": (
        "What is rand in (18)?",
        {
            0: ("in [0, 1)", "the velocity is bounded by v_max"),
            1: ("in [-v_max, v_max]", "as printed: half of the pulls push away from the best"),
        },
    ),
    "millimetres": (
        "Which unit has the position in (25)?",
        {
            0: ("m", "a metre weighs as much as a radian"),
            1: ("mm", "a millimetre weighs as much as a radian"),
        },
    ),
    "angles": (
        "What is |O_d - O| in (25)?",
        {
            0: ("angle of the rotation", "the same wherever the tool points"),
            1: ("difference of roll, pitch, yaw", "as printed: undefined at a pitch of 90°"),
        },
    ),
    "one_turn": (
        "Where is the first draw?",
        {
            0: ("in the whole range", "joints 2, 3 and 6 within two turns"),
            1: ("within ±pi", "each joint within one turn"),
        },
    ),
    "at_once": (
        "When does a new best lead?",
        {
            0: ("from the next iteration", "all particles move, then are ranked"),
            1: ("at once", "each is ranked as it has moved, as in the usual loop"),
        },
    ),
    "particles": (
        "How many particles has PSO-1?",
        {
            40: ("40", "(20) with five joints"),
            48: ("48", "(20) with six joints"),
            80: ("80", "the mean population of the trajectory"),
        },
    ),
}


def questions(data: xr.Dataset) -> tuple[OpenQuestion, ...]:
    """Show what the search found under each reading; see `table_7.run` for the data."""
    best = data.law.isel(candidate=0)
    by_law = [
        OpenQuestion(
            question,
            CLAIM,
            tuple(
                _reading(
                    data,
                    (data.law.sel(reading=name) == value).values,
                    (*words, int(best.sel(reading=name)) == value),
                )
                for value, words in values.items()
            ),
        )
        for name, (question, values) in ASKED.items()
    ]
    stops = data.candidates.sel(coefficient="after").values == 0
    stop = OpenQuestion(
        "Does a swarm stop at its first particle inside the tolerances?",
        CLAIM,
        tuple(
            _reading(data, stops == value, (*words, bool(stops[0]) == value))
            for value, words in {
                True: ("it stops", "Steps 6 and 9: the errors lie just inside the tolerances"),
                False: ("it runs on", "up to 100 iterations more"),
            }.items()
        ),
    )
    counted = np.array([STAGES.index(COUNTS[k].stages) for k in data.count_reading.values])
    counting = OpenQuestion(
        "Whose iterations are the 52 of DPSO?",
        CLAIM,
        tuple(
            _reading(data, counted == k, (name, meaning, counted[0] == k))
            for k, (name, meaning) in enumerate(
                zip(
                    STAGES,
                    (
                        "with those of the fallback",
                        "of the runs that need no fallback",
                        "PSO-1 and PSO-2, or the fallback alone",
                    ),
                    strict=True,
                )
            )
        ),
    )
    return (*by_law, stop, counting)


def _reading(data: xr.Dataset, which: Any, words: tuple[str, str, Any]) -> Reading:
    name, meaning, chosen = words
    rows = data.isel(candidate=np.flatnonzero(which))
    nearest = float(rows.distance.min()) if rows.sizes["candidate"] else np.nan
    most = int(rows.most_met.max()) if rows.sizes["candidate"] else 0
    return Reading(
        name,
        meaning,
        {
            "candidates": quantity(rows.sizes["candidate"]),
            "smallest misfit": quantity(nearest),
            "most statements at once": quantity(most),
            "posterior": quantity(100.0 * float(rows.weight.sum() / data.weight.sum()), "%"),
        },
        chosen=bool(chosen),
    )
