"""Checks of user input: one clear line with the field, the value and what is allowed."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

# The lowest number allowed where zero is not.
ABOVE_ZERO = math.ulp(0.0)


def number(name: str, value: float, low: float = -math.inf, high: float = math.inf) -> None:
    """Accept a finite number within [low, high].

    Raises:
        ValueError: otherwise.
    """
    finite = isinstance(value, int | float) and math.isfinite(value)
    if not (finite and low <= value <= high):
        raise ValueError(f"{name}: {value}, allowed {_range(low, high)}")


def vector(
    name: str,
    values: Sequence[float],
    size: int,
    low: float = -math.inf,
    high: float = math.inf,
) -> None:
    """Accept `size` finite numbers, each within [low, high].

    Raises:
        ValueError: otherwise; names the entry.
    """
    if len(values) != size:
        raise ValueError(f"{name}: {len(values)} entries, allowed {size}")
    for index, value in enumerate(values):
        number(f"{name}[{index}]", value, low, high)


def choice(name: str, value: str, allowed: Iterable[str]) -> None:
    """Accept one of the allowed words.

    Raises:
        ValueError: otherwise; lists the words.
    """
    words = list(allowed)
    if value not in words:
        raise ValueError(f"{name}: '{value}', allowed {', '.join(words)}")


def _range(low: float, high: float) -> str:
    if math.isinf(low) and math.isinf(high):
        return "any finite number"
    if math.isinf(low):
        return f"{high:g} or less, finite"
    if math.isinf(high):
        return "above 0, finite" if low == ABOVE_ZERO else f"{low:g} or more, finite"
    return f"above 0, up to {high:g}" if low == ABOVE_ZERO else f"{low:g} to {high:g}"
