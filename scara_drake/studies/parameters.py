"""What a study varies: fields of a scenario, and the values that they take."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, field
from statistics import NormalDist
from typing import Any, Final

import numpy as np

from scara_drake.common import checks
from scara_drake.common.checks import ABOVE_ZERO
from scara_drake.common.fields import choice, number, spec_of
from scara_drake.common.yaml_text import TAG, read_yaml

MOST_POINTS: Final = 100_000


@dataclass
class Parameter:
    """Fields of a scenario that take the same value.

    Attributes:
        paths: dotted, such as "channel.up.delay"; several get one value.
        name: of the parameter in the result; the first path if empty.
    """

    paths: list[str] = field(default_factory=lambda: [""])
    name: str = ""

    @property
    def label(self) -> str:
        """Its name in the result."""
        return self.name or self.paths[0]

    def points(self) -> list[Any]:
        """Return its values in a grid."""
        raise NotImplementedError

    def at(self, share: float) -> Any:
        """Return the value that a share within (0, 1) of its draws is below."""
        raise NotImplementedError

    def outermost(self) -> list[Any]:
        """Return values of which all have to be allowed, for all others to be."""
        raise NotImplementedError

    def check_together(self, name: str) -> None:
        """Check that it has a path.

        Raises:
            ValueError: it has none, or one twice.
        """
        words = isinstance(self.paths, list) and all(isinstance(one, str) for one in self.paths)
        if not (words and self.paths and all(self.paths)):
            shown = checks.shown(self.paths, quotes=False)
            raise ValueError(f"{name}.paths: {shown}, allowed a list of dotted paths of fields")
        if len(set(self.paths)) < len(self.paths):
            raise ValueError(f"{name}.paths: one twice, allowed each once")


@dataclass
class Values(Parameter):
    """Values that are given, numbers, words or parts such as ``!Tdpa {force_scale: 0.1}``.

    Drawn at random, each is as likely as the others.

    Attributes:
        values: any number.
        labels: what stands for them in the result; made of the values if empty.
    """

    values: list[Any] = field(default_factory=list)
    labels: list[str] = field(default_factory=list)

    def points(self) -> list[Any]:
        """Return its values in a grid."""
        return [plain(value, self.label) for value in self.values]

    def at(self, share: float) -> Any:
        """Return the value that a share within (0, 1) of its draws is below."""
        return self.points()[int(share * len(self.values))]

    def outermost(self) -> list[Any]:
        """Return values of which all have to be allowed, for all others to be."""
        return self.points()

    def shown_as(self, value: Any) -> float | str:
        """Return what stands for a value in the result."""
        points = self.points()
        if self.labels:
            return self.labels[points.index(value)]
        numbers = all(isinstance(v, int | float) and not isinstance(v, bool) for v in points)
        return float(value) if numbers else text_of(value)

    def check_together(self, name: str) -> None:
        """Check that there are values, each once, and as many labels if there are any.

        Raises:
            ValueError: otherwise.
        """
        super().check_together(name)
        if not self.values:
            raise ValueError(f"{name}.values: 0 entries, allowed 1 or more")
        if self.labels and len(self.labels) != len(self.values):
            raise ValueError(
                f"{name}.labels: {len(self.labels)} entries, allowed {len(self.values)}, or none"
            )
        shown = [self.shown_as(value) for value in self.points()]
        for value in shown:
            if shown.count(value) > 1:
                raise ValueError(f"{name}.values: {value} twice, allowed each once")


@dataclass
class Range(Parameter):
    """Numbers from low to high: evenly spaced in a grid, equally likely where they are drawn.

    Attributes:
        low: the first.
        high: the last.
        count: how many, in a grid.
        scale: in which they are even.
    """

    low: float = number(0.0, "")
    high: float = number(1.0, "")
    count: int = number(5, "", 1, MOST_POINTS)
    scale: str = choice("linear", ("linear", "log"))

    def points(self) -> list[Any]:
        """Return its values in a grid."""
        if self.count == 1:
            return [self.low]
        shares = [index / (self.count - 1) for index in range(1, self.count - 1)]
        # Rounded, so that 0.075 is found under this name.
        return [self.low, *(float(f"{self.at(share):.12g}") for share in shares), self.high]

    def at(self, share: float) -> Any:
        """Return the value that a share within (0, 1) of its draws is below."""
        if self.scale == "log":
            low, high = math.log(self.low), math.log(self.high)
            return math.exp((1.0 - share) * low + share * high)
        return (1.0 - share) * self.low + share * self.high

    def outermost(self) -> list[Any]:
        """Return values of which all have to be allowed, for all others to be."""
        return [self.low, self.high]

    def check_together(self, name: str) -> None:
        """Check that low is below high, and above zero on a logarithmic scale.

        Raises:
            ValueError: it is not.
        """
        super().check_together(name)
        if self.scale == "log":
            checks.number(f"{name}.low", self.low, ABOVE_ZERO)
        if self.high <= self.low:
            raise ValueError(f"{name}.high: {self.high:g}, allowed above {name}.low, {self.low:g}")


@dataclass
class Normal(Parameter):
    """Numbers of a normal distribution; for draws, not for a grid.

    Attributes:
        mean: of the distribution.
        deviation: its standard deviation.
    """

    mean: float = number(0.0, "")
    deviation: float = number(1.0, "", ABOVE_ZERO)

    def points(self) -> list[Any]:
        """Return its values in a grid."""
        raise ValueError(f"{self.label}: !Normal in a grid, allowed !Values or !Range")

    def at(self, share: float) -> Any:
        """Return the value that a share within (0, 1) of its draws is below."""
        tiny = np.finfo(float).tiny
        return NormalDist(self.mean, self.deviation).inv_cdf(max(share, tiny))

    def outermost(self) -> list[Any]:
        """Return values of which all have to be allowed, for all others to be."""
        return [self.mean]


def shown_as(parameter: Parameter, value: Any) -> float | str:
    """Return what stands for a value of a parameter in the result."""
    return parameter.shown_as(value) if isinstance(parameter, Values) else float(value)


def plain(value: Any, name: str) -> Any:
    """Return a value as data: a text is read as YAML, and 1e-3 is a number.

    Raises:
        ValueError: it is not YAML.
    """
    if not isinstance(value, str):
        return value
    data = read_yaml(value, name)
    try:
        return float(data) if isinstance(data, str) else data
    except ValueError:
        return data


def text_of(value: Any) -> str:
    """Return a value in a few words: a part by its tag and what it sets."""
    if isinstance(value, dict):
        fields = ", ".join(f"{key} {text_of(v)}" for key, v in value.items() if key != TAG)
        return f"{str(value.get(TAG, '')).removeprefix('!')} {fields}".strip()
    if isinstance(value, list):
        return f"[{', '.join(map(text_of, value))}]"
    return "none" if value is None else str(value)


def unit_of(scenario: Any, path: str) -> str:
    """Return the unit of a field of a scenario by its dotted path; empty where it has none."""
    *parents, last = path.split(".")
    place = scenario
    for name in parents:
        place = place[int(name)] if isinstance(place, list) else getattr(place, name, None)
    if not dataclasses.is_dataclass(place):
        return ""
    try:
        return spec_of(place, last).unit
    except ValueError:
        return ""
