"""The candidates of the search for Table 7 as a file, which the experiment reads."""

from __future__ import annotations

import csv
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np

from scara_drake.experiments.inverse_kinematics.swarm_law import Coefficients, Law
from scara_drake.experiments.inverse_kinematics.swarm_reported import STATEMENTS
from scara_drake.experiments.inverse_kinematics.swarm_search import Candidate
from scara_drake.experiments.inverse_kinematics.swarm_statements import COUNTS

FILE: Final = Path(__file__).with_name("table_7.csv")
DIGITS: Final = 4


class Found(NamedTuple):
    """A row of the file.

    Attributes:
        law: reading of the swarm.
        coefficients: of it, to DIGITS digits.
        counting: number of COUNTS under which it is nearest to all statements.
        phase: of the search that ran it: "first" or "ended", "search", "posterior", the name of a
            statement that was searched for alone, or "package", under the package's reading.
        distance: sum of its misfits under that count.
        weight: in the posterior, else 0.
        met: sets of statements met under one of the counts, none within another.
        check: distance on the seeds of the check; NaN where it was not checked.
    """

    law: Law
    coefficients: Coefficients
    counting: int
    phase: str
    distance: float
    weight: float
    met: tuple[frozenset[str], ...]
    check: float


def found(one: Candidate, phase: str, check: float = np.nan) -> Found:
    """Return the row of a candidate."""
    names = np.array(list(STATEMENTS))
    sets = {frozenset(map(str, names[row == 0.0])) for row in one.misfits}
    largest = sorted((s for s in sets if not any(s < other for other in sets)), key=_bits)
    weight = one.weight if phase == "posterior" else 0.0
    numbers: dict[str, Any] = {
        name: value if isinstance(value, int) else float(f"{value:.{DIGITS}g}")
        for name, value in one.coefficients._asdict().items()
    }
    distance = float(one.misfits[one.nearest].sum())
    return Found(
        one.law, Coefficients(**numbers), one.nearest, phase, round(distance, DIGITS),
        float(f"{weight:.{DIGITS}g}"), tuple(largest), round(check, DIGITS),
    )  # fmt: skip


def _bits(names: Iterable[str]) -> int:
    chosen = set(names)
    return sum(1 << k for k, name in enumerate(STATEMENTS) if name in chosen)


def write(rows: Iterable[Found], path: Path = FILE) -> None:
    """Write rows; a set of statements is a hexadecimal number with a bit for each."""
    with path.open("w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(
            [*Law._fields, *Coefficients._fields, "count", "phase", "distance", "weight", "met",
             "check"]
        )  # fmt: skip
        for row in rows:
            met = ".".join(f"{_bits(names):x}" for names in row.met)
            law = [int(value) for value in row.law]
            out.writerow(
                [*law, *row.coefficients, row.counting, row.phase, row.distance, row.weight, met,
                 row.check]
            )  # fmt: skip


def read(path: Path = FILE) -> list[Found]:
    """Read the rows of a file.

    Raises:
        ValueError: the count of a row is none of COUNTS.
    """
    with path.open(newline="") as file:
        return [_row(values) for values in csv.DictReader(file)]


def _row(values: dict[str, str]) -> Found:
    law: dict[str, Any] = {name: bool(int(values[name])) for name in Law._fields}
    law["particles"] = int(values["particles"])
    numbers: dict[str, Any] = {name: float(values[name]) for name in Coefficients._fields}
    numbers |= {name: int(values[name]) for name in ("after", "patience")}
    count = int(values["count"])
    if not 0 <= count < len(COUNTS):
        raise ValueError(f"count: {count}, allowed 0 to {len(COUNTS) - 1}")
    met = tuple(
        frozenset(name for k, name in enumerate(STATEMENTS) if int(bits, 16) >> k & 1)
        for bits in values["met"].split(".")
    )
    return Found(
        Law(**law), Coefficients(**numbers), count, values["phase"], float(values["distance"]),
        float(values["weight"]), met, float(values["check"]),
    )  # fmt: skip
