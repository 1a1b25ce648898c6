"""What an experiment returns: its data, and what it says about each claim of the paper.

A claim is data. Its values are quantities, its criterion is one or two rules, and its verdict
follows from them; the sentences are made by `report`. A rule that compares with the paper's number
is given that number when the verdict is asked for, so that another number may give another verdict.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from scara_drake.common import checks
from scara_drake.experiments.quantity import Quantity, Value, parts
from scara_drake.experiments.reading import OpenQuestion

Array = NDArray[np.float64]

REPRODUCED: Final = "reproduced"
IN_KIND: Final = "reproduced in kind"
NOT_REPRODUCED: Final = "not reproduced"
NOT_COMPARABLE: Final = "not comparable"
VERDICTS: Final = (REPRODUCED, IN_KIND, NOT_REPRODUCED, NOT_COMPARABLE)

PAPER: Final = "paper"
OURS: Final = "ours"
SOURCES: Final = (PAPER, OURS)


@dataclass(frozen=True)
class Rule:
    """A comparison of what was measured with the paper's number, made when that is given.

    Attributes:
        compare: of the measured values, the paper's, and `by`; which of the measured ones comply.
        measured: what is compared, in the unit of the paper's number.
        by: how far the two may be apart, see the functions that make rules.
        share: of the measured values that must comply.
        units: whether both must have the same unit.
    """

    compare: Callable[[Array, Array, float], Any]
    measured: Quantity
    by: float = 1.0
    share: float = 1.0
    units: bool = True

    def __call__(self, paper: Value | None) -> bool:
        """Return whether enough of the measured values comply with the paper's number.

        Raises:
            ValueError: the paper has no number in that unit, or its names are others.
        """
        for one in parts(paper):
            if isinstance(one, Quantity) and self._suits(one):
                measured, wanted = np.array(self.measured.values), np.array(one.values)
                return bool(np.mean(self.compare(measured, wanted, self.by)) >= self.share)
        raise ValueError(f"paper: {paper}, allowed a number in {self.measured.unit or 'numbers'}")

    def _suits(self, paper: Quantity) -> bool:
        same = self.measured.unit == paper.unit or not self.units
        return same and (not paper.names or paper.names == self.measured.names)


@dataclass(frozen=True)
class AnyOf:
    """A rule that is met where one of some is."""

    conditions: tuple[Condition, ...]

    def __call__(self, paper: Value | None) -> bool:
        """Return whether one of the conditions is met."""
        return any(_holds(condition, paper) for condition in self.conditions)


# A tuple is met where all of its members are.
Condition = bool | np.bool_ | Rule | AnyOf | tuple["Condition", ...]


def _holds(condition: Condition, paper: Value | None) -> bool:
    if isinstance(condition, tuple):
        return all(_holds(one, paper) for one in condition)
    if isinstance(condition, (Rule, AnyOf)):
        return condition(paper)
    return bool(condition)


def within(measured: Quantity, share: float) -> Rule:
    """Rule: each value differs from the paper's by no more than a share of it."""
    return Rule(_near, measured, share)


def within_factor(measured: Quantity, factor: float) -> Rule:
    """Rule: no value is more than so many times the paper's, nor less than that part of it."""
    return Rule(_alike, measured, factor)


def inside(measured: Quantity) -> Rule:
    """Rule: each value lies between the paper's smallest and its largest."""
    return Rule(_between, measured)


def at_most(measured: Quantity, times: float = 1.0, share: float = 1.0) -> Rule:
    """Rule: a share of the values is no more than so many times the paper's largest."""
    return Rule(_below, measured, times, share)


def at_least(measured: Quantity, times: float = 1.0, share: float = 1.0) -> Rule:
    """Rule: a share of the values is no less than so many times the paper's smallest."""
    return Rule(_above, measured, times, share)


def ordered(measured: Quantity) -> Rule:
    """Rule: the named values are in the order of the paper's, which may be in another unit."""
    return Rule(_sorted_alike, measured, units=False)


def _near(measured: Array, paper: Array, share: float) -> Any:
    return np.abs(measured / paper - 1.0) <= share


def _alike(measured: Array, paper: Array, factor: float) -> Any:
    return (paper / factor <= measured) & (measured <= factor * paper)


def _between(measured: Array, paper: Array, _: float) -> Any:
    return (measured >= paper.min()) & (measured <= paper.max())


def _below(measured: Array, paper: Array, times: float) -> Any:
    return measured <= times * paper.max()


def _above(measured: Array, paper: Array, times: float) -> Any:
    return measured >= times * paper.min()


def _sorted_alike(measured: Array, paper: Array, _: float) -> Any:
    rank = np.argsort(paper)
    return np.all(measured[rank][:-1] < measured[rank][1:])


@dataclass(frozen=True)
class Criterion:
    """What decides a verdict.

    Attributes:
        text: the rule in words.
        met: its strict form: true or false, or a rule that is given the paper's number.
        in_kind: its weaker form.
    """

    text: str
    met: Condition
    in_kind: Condition = False

    def verdict(self, paper: Value | None) -> str:
        """Return the verdict, given the paper's value."""
        if _holds(self.met, paper):
            return REPRODUCED
        return IN_KIND if _holds(self.in_kind, paper) else NOT_REPRODUCED


@dataclass(frozen=True)
class Claim:
    """One statement, and what became of it here.

    Attributes:
        statement: what is said, in our words.
        paper: the paper's value; None where it gives none.
        measured: the value found here.
        criterion: what decides; None where there is nothing to compare with.
        reason: why it is so, a sentence.
        source: of the statement and its criterion, one of SOURCES: the paper, or we ourselves.
    """

    statement: str
    paper: Value | None
    measured: Value
    criterion: Criterion | None
    reason: str
    source: str = PAPER

    def __post_init__(self) -> None:
        """Check the source.

        Raises:
            ValueError: not one of SOURCES.
        """
        checks.choice("source", self.source, SOURCES)

    @property
    def verdict(self) -> str:
        """One of VERDICTS, by the criterion."""
        return self.criterion.verdict(self.paper) if self.criterion else NOT_COMPARABLE

    def _repr_html_(self) -> str:
        from scara_drake.experiments.cards import of_claim

        return of_claim(self)


@dataclass(frozen=True, eq=False)
class Experiment:
    """A table or figure of the paper, run here.

    Attributes:
        name: such as "Table 8".
        data: labelled arrays; each variable has `units` and `long_name`. Those with the attribute
            `measured` are wall times, which differ from run to run; a seed fixes all the others.
        claims: of the paper and our own, each with its verdict.
        questions: what the paper leaves open and a verdict hangs on, with each reading of it.
    """

    name: str
    data: xr.Dataset
    claims: list[Claim]
    questions: tuple[OpenQuestion, ...] = ()

    def _repr_html_(self) -> str:
        from scara_drake.experiments.cards import of_experiment

        return of_experiment(self)
