"""The gains of a controller that a search may choose: their ranges, and how they obey the rule.

Every entry above zero of every list of gains is a parameter of its own, on a logarithmic scale
around its start value and within the bounds of its field. A part with a boundary layer `phi` and a
rule about its sampling has the parameter `margin` in its place: phi is the smallest layer that
the rule bears, over the margin.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from typing import Any, Final

from optuna.distributions import FloatDistribution

from scara_drake.common.fields import Spec, spec_of

FACTOR: Final = 4.0  # a gain is searched from its start value over this to it times this
LAYER: Final = "phi"
MARGIN: Final = "margin"
# How far a candidate goes from the start (0) to what was drawn (1), until the rule bears it.
SHRINKING: Final = (1.0, 0.75, 0.5, 0.25, 0.0)
WIDEST: Final = 1e6  # of the boundary layer, times the one given
STEPS: Final = (4.0, 1.05)  # of the search of the smallest layer, coarse and fine


def search_space(part: Any, period: float) -> dict[str, FloatDistribution]:
    """Return the ranges of the parameters of a controller part, by name, such as ``c[0]``.

    Args:
        part: the start, a dataclass; every list of numbers in it that may not be negative is a
            list of gains.
        period: [s].
    """
    space = {
        name: FloatDistribution(*_range(part, name, value), log=True)
        for name, value in _parameters(part)
    }
    if _has_layer(part):
        lowest = min(1.0, _start_margin(part, period)) / FACTOR
        space[MARGIN] = FloatDistribution(lowest, 1.0, log=True)
    return space


def start_point(part: Any, period: float) -> dict[str, float]:
    """Return the parameters of the start; of a start outside the rule, those at its border."""
    point = dict(_parameters(part))
    if _has_layer(part):
        point[MARGIN] = min(1.0, _start_margin(part, period))
    return point


def candidate(part: Any, parameters: dict[str, float], period: float) -> Any:
    """Return the controller part of these parameters; it is within its rule of sampling.

    Gains that no boundary layer would do for are moved back towards the start.

    Args:
        part: the start.
        parameters: of every name in `search_space`.
        period: [s].

    Raises:
        ValueError: the rule bears not even the start.
    """
    strict = _strict(part)
    for share in SHRINKING:
        gains = {name: list(getattr(part, name)) for name in _gain_fields(part)}
        for name, start in _parameters(part):
            field, _, index = name.removesuffix("]").partition("[")
            gains[field][int(index)] = start * (parameters[name] / start) ** share
        drawn = dataclasses.replace(strict, **gains)
        if not _has_layer(part):
            if _is_inside(drawn, period):
                return drawn
        elif math.isfinite(factor := smallest_layer(drawn, period)):
            return _with_layer(drawn, factor / parameters[MARGIN])
    raise ValueError("controller: the start gains chatter, allowed gains within the rule")


def smallest_layer(part: Any, period: float) -> float:
    """Factor of phi (to 5 %) that just meets the part's rule at a period [s]; infinite if none."""

    def inside(factor: float) -> bool:
        return _is_inside(_with_layer(part, factor), period)

    if not inside(WIDEST):
        return math.inf
    factor = 1.0
    while not inside(factor):
        factor *= STEPS[0]
    for step in STEPS:
        while factor * WIDEST > 1.0 and inside(factor / step):
            factor /= step
    return factor


def _range(part: Any, name: str, value: float) -> tuple[float, float]:
    """Return the lowest and the highest value of a gain, such as ``c[0]``, from its start value."""
    spec = _spec(part, name.partition("[")[0])
    return max(value / FACTOR, spec.low), min(value * FACTOR, spec.high)


def _gain_fields(part: Any) -> list[str]:
    """Return the fields that are lists of numbers which may not be negative."""
    names = [field.name for field in dataclasses.fields(part)]
    return [name for name in names if (spec := _spec(part, name)).size != 0 and spec.low >= 0.0]


def _spec(part: Any, name: str) -> Spec:
    """Return what a field was declared to be, or what its value looks like."""
    try:
        return spec_of(part, name)
    except ValueError:
        numbers = _is_list_of_numbers(getattr(part, name))
        return Spec(low=0.0, size=None if numbers else 0)


def _is_list_of_numbers(value: Any) -> bool:
    if not (isinstance(value, list) and value):
        return False
    return all(isinstance(entry, int | float) and not isinstance(entry, bool) for entry in value)


def _parameters(part: Any) -> Iterator[tuple[str, float]]:
    """Yield the names and start values of the gains that are searched themselves."""
    for field in _gain_fields(part):
        if field == LAYER and _has_layer(part):
            continue
        for index, value in enumerate(getattr(part, field)):
            if value > 0.0:
                yield f"{field}[{index}]", float(value)


def _has_layer(part: Any) -> bool:
    return hasattr(part, "check_sampling") and LAYER in _gain_fields(part)


def _start_margin(part: Any, period: float) -> float:
    """Return the margin of the start; above 1 it is outside the rule."""
    return smallest_layer(_strict(part), period)


def _strict(part: Any) -> Any:
    """Return the part without its leave to break the rule."""
    if hasattr(part, "allow_chatter"):
        return dataclasses.replace(part, allow_chatter=False)
    return part


def _with_layer(part: Any, factor: float) -> Any:
    return dataclasses.replace(part, **{LAYER: [factor * float(phi) for phi in part.phi]})


def _is_inside(part: Any, period: float) -> bool:
    if not hasattr(part, "check_sampling"):
        return True
    try:
        part.check_sampling("controller", period)
    except ValueError:
        return False
    return True
