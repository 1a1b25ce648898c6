"""Checks of user input: one clear line with the field, the value and what is allowed."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterable, Sequence
from itertools import islice
from typing import Any, Final

# The lowest number allowed where zero is not.
ABOVE_ZERO = math.ulp(0.0)
LONGEST_VALUE: Final = 60  # characters of a value in a message
WORD: Final = re.compile(r"\w[\w .,+=()-]{0,99}")


def shown(value: Any, longest: int = LONGEST_VALUE, quotes: bool = True) -> str:
    """Return a value as a message shows it: in one line, cut, without control characters.

    Args:
        value: anything; of a list or a map no more than its beginning is looked at.
        longest: characters.
        quotes: puts a text in quotes.
    """
    if isinstance(value, int) and abs(value) >= 10**longest:
        return f"a whole number of {value.bit_length()} bits"
    text = _beginning(value, longest)
    text = text if len(text) <= longest else f"{text[: longest - 3]}..."
    text = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    return f"'{text}'" if quotes and isinstance(value, str) else text


def _beginning(value: Any, longest: int, depth: int = 0) -> str:
    """The text of a value; of a list or map only its beginning, as an alias may make it large."""
    if not isinstance(value, dict | list | tuple | set):
        return shown(value, longest, quotes=False) if depth else str(value)
    if depth > 2 or len(value) > longest:
        return f"{type(value).__name__} of {len(value)} entries"
    parts = [_beginning(entry, longest, depth + 1) for entry in islice(value, 9)]
    if isinstance(value, dict):
        entries = islice(value.values(), 9)
        parts = [
            f"{key}: {_beginning(entry, longest, depth + 1)}"
            for key, entry in zip(parts, entries, strict=True)
        ]
        return f"{{{', '.join(parts)}}}"
    return f"[{', '.join(parts)}]"


def word(name: str, value: str) -> None:
    """Accept a name: letters, digits and " .,+=()-_", beginning with a letter or a digit.

    Raises:
        ValueError: otherwise.
    """
    if not WORD.fullmatch(value) or value != value.strip():
        raise ValueError(
            f"{name}: {shown(value)}, allowed a word of up to 100 letters, digits and ' .,+=()-_', "
            "without '/'"
        )


def nearest(value: Any, allowed: Iterable[str], form: str = "{}") -> str:
    """Return "; did you mean 'x'?" where one of the allowed words is near a value, or ""."""
    words = {each.lower(): each for each in allowed}
    found = difflib.get_close_matches(str(value)[:LONGEST_VALUE].lower(), words, 1, 0.6)
    return f"; did you mean '{form.format(words[found[0]])}'?" if found else ""


def number(name: str, value: float, low: float = -math.inf, high: float = math.inf) -> None:
    """Accept a finite number within [low, high].

    Raises:
        ValueError: otherwise.
    """
    try:
        finite = isinstance(value, int | float) and math.isfinite(value)
    except OverflowError:  # a whole number beyond all floats
        finite = False
    if not (finite and low <= value <= high):
        raise ValueError(f"{name}: {shown(value, quotes=False)}, allowed {_range(low, high)}")


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
        raise ValueError(f"{name}: {shown(str(value))}, allowed {', '.join(words)}")


def _range(low: float, high: float) -> str:
    if math.isinf(low) and math.isinf(high):
        return "any finite number"
    if math.isinf(low):
        return f"{high:g} or less, finite"
    if math.isinf(high):
        return "above 0, finite" if low == ABOVE_ZERO else f"{low:g} or more, finite"
    return f"above 0, up to {high:g}" if low == ABOVE_ZERO else f"{low:g} to {high:g}"
