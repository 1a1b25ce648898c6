"""What an experiment returns: its data, and what it says about each claim of the paper."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import xarray as xr

from scara_drake.common import checks

REPRODUCED: Final = "reproduced"
IN_KIND: Final = "reproduced in kind"
NOT_REPRODUCED: Final = "not reproduced"
NOT_COMPARABLE: Final = "not comparable"
VERDICTS: Final = (REPRODUCED, IN_KIND, NOT_REPRODUCED, NOT_COMPARABLE)


@dataclass(frozen=True)
class Claim:
    """One statement of the paper, and what became of it here.

    Attributes:
        statement: what the paper says, in our words.
        paper: its value, with unit.
        ours: the value found here, with unit.
        verdict: one of VERDICTS.
        reason: the criterion of the verdict, and the evidence where the two differ.
    """

    statement: str
    paper: str
    ours: str
    verdict: str
    reason: str

    def __post_init__(self) -> None:
        """Check the verdict.

        Raises:
            ValueError: not one of VERDICTS.
        """
        checks.choice("verdict", self.verdict, VERDICTS)


@dataclass(frozen=True, eq=False)
class Experiment:
    """A table or figure of the paper, run here.

    Attributes:
        name: such as "Table 8".
        data: labelled arrays; each variable has `units` and `long_name`. Those with the attribute
            `measured` are wall times, which differ from run to run; a seed fixes all the others.
        claims: of the paper, each with its verdict.
    """

    name: str
    data: xr.Dataset
    claims: list[Claim]


def judge(reproduced: bool, in_kind: bool = False) -> str:
    """Return the verdict for a criterion that is met, met by its weaker form, or not met."""
    if reproduced:
        return REPRODUCED
    return IN_KIND if in_kind else NOT_REPRODUCED


def variable(
    dims: tuple[str, ...], values: Any, units: str, long_name: str, measured: bool = False
) -> xr.Variable:
    """Return a labelled variable; `measured` marks a wall time."""
    attributes = {"units": units, "long_name": long_name}
    if measured:
        attributes["measured"] = "wall time of this machine"
    return xr.Variable(dims, values, attributes)


def span(values: Any, digits: int = 2, scale: float = 1.0) -> str:
    """Return "low to high" of some numbers, for a claim."""
    low, high = (f"{scale * float(value):.{digits}f}" for value in (min(values), max(values)))
    return low if low == high else f"{low} to {high}"
