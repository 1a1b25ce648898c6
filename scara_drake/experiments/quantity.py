"""Measured and published quantities as data, and the one place where they are written out."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Quantity:
    """Numbers with a unit; `quantity` makes one.

    Attributes:
        values: the numbers.
        unit: theirs, as it is written: "mm", "%", "of 4 postures"; may be empty.
        label: what they are, or where, such as "median".
        bound: what they bound, such as "below" or "up to"; may be empty.
        names: of the values, joints or solvers, each written with its name; empty where they are
            one number or a range.
        missing: what is written for a value that is not finite.
        clock: whether it was measured by the clock, so that it differs from run to run.
    """

    values: tuple[float, ...]
    unit: str = ""
    label: str = ""
    bound: str = ""
    names: tuple[str, ...] = ()
    missing: str = "none"
    clock: bool = False

    def __post_init__(self) -> None:
        """Check the names.

        Raises:
            ValueError: not as many as there are values.
        """
        if self.names and len(self.names) != len(self.values):
            raise ValueError(f"names: {len(self.names)}, allowed {len(self.values)}")

    def __str__(self) -> str:
        """Return it as a text: its numbers with three digits, or the range of them."""
        if self.names:
            pairs = zip(self.names, self.values, strict=True)
            numbers = ", ".join(f"{name} {self._one(value)}" for name, value in pairs)
        else:
            known = [value for value in self.values if math.isfinite(value)]
            low, high = (number(end(known)) if known else "" for end in (min, max))
            spread = low != high and len(known) > 1
            numbers = self._one(known[0]) if known else self.missing
            if spread:
                numbers = f"{low} to {high}{self._unit()}"
        text = f"{self.bound} {numbers}" if self.bound else numbers
        return f"{text} ({self.label})" if self.label else text

    def scaled(self, factor: float, which: int | None = None) -> Quantity:
        """Return it with its values, or one of them, multiplied."""
        values = [
            value * factor if which in (None, index) else value
            for index, value in enumerate(self.values)
        ]
        return replace(self, values=tuple(values))

    def _one(self, value: float) -> str:
        return number(value) + self._unit() if math.isfinite(value) else self.missing

    def _unit(self) -> str:
        return f" {self.unit}" if self.unit else ""


# A word, a quantity, or several of them.
Value = str | Quantity | tuple[str | Quantity, ...]


def quantity(
    values: Mapping[str, Any] | Any,
    unit: str = "",
    label: str = "",
    bound: str = "",
    missing: str = "none",
    clock: bool = False,
) -> Quantity:
    """Return a quantity of a number, of an array of them, or of numbers by name."""
    named = isinstance(values, Mapping)
    numbers = np.asarray(list(values.values()) if named else values, dtype=np.float64).ravel()
    # One object for what is not a number, so that equal quantities compare equal.
    kept = tuple(math.nan if math.isnan(one) else float(one) for one in numbers)
    names = tuple(map(str, values)) if named else ()
    return Quantity(kept, unit, label, bound, names, missing, clock)


def number(value: float) -> str:
    """Return a number with three digits, and all of those before the point."""
    if abs(value) >= 1e3 or value == round(value):
        return f"{value + 0.0:.0f}"
    return f"{float(f'{value:.3g}'):g}"


def parts(value: Value | None) -> tuple[str | Quantity, ...]:
    """Return the words and quantities of a value, none of None."""
    if value is None:
        return ()
    return value if isinstance(value, tuple) else (value,)


def text(value: Value | None, missing: str = "not given", clock: bool = True) -> str:
    """Return a value as a text, and `missing` for None.

    Args:
        value: words, quantities, or both.
        missing: what stands for None.
        clock: writes what was measured by the clock, too, which differs from run to run.
    """
    if value is None:
        return missing
    hidden = "by the clock, which differs from run to run"
    return "; ".join(
        hidden if isinstance(one, Quantity) and one.clock and not clock else str(one)
        for one in parts(value)
    )
