"""The place on a line from which on something holds, by bisection."""

from __future__ import annotations

from collections.abc import Callable


def bracket(
    beyond: Callable[[float], bool], low: float, high: float, close: float, least: float = 0.0
) -> tuple[float, float]:
    """Return the ends of the interval in which something begins to hold.

    Unlike `scipy.optimize.bisect` it asks for yes or no, and takes the ends as given.

    Args:
        beyond: whether it holds; taken not to at `low`, and to at `high`.
        low: end of the interval.
        high: the other, above it.
        close: width of the interval over its high end that is narrow enough.
        least: high end from which downwards the interval is narrow enough in any case.
    """
    while high - low > close * high and high > least:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if beyond(middle) else (middle, high)
    return low, high
