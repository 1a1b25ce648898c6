"""What an attack may change, as data: each field with its unit, its bounds and its meaning.

An attack is a map from names of fields to values; a field that is not in it stays as the scenario
has it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from scara_drake.channel.packets import Packets
from scara_drake.common import checks
from scara_drake.scenario import Scenario
from scara_drake.studies.parameters import Range

Attack = Mapping[str, Any]

KINDS_OF_JITTER: Final = ("gamma", "lognormal", "uniform", "normal")
SIDES: Final = ("both", "up", "down")
# What is meant where a scenario has none of its own.
SPREAD, SWING_RATE, SWEEP_RATE, OUTAGE_AT = 0.5, 1.0, 5.0, 0.3


@dataclass(kw_only=True)
class Bound(Range):
    """A field that an attack may change: a number from low to high, or one of some words.

    Attributes:
        unit: of the number.
        meaning: of the field.
        own: what a scenario has itself; None where it has no such field.
        words: the field is one of these, and low to high are their places.
        whole: the number is a whole one.
    """

    unit: str = ""
    meaning: str = ""
    own: Callable[[Scenario], float | str | None]
    words: tuple[str, ...] = ()
    whole: bool = False

    def value(self, share: float) -> float | str:
        """Return the value at a share within [0, 1] of the range."""
        at = self.at(min(max(share, 0.0), 1.0))
        if self.words:
            return self.words[round(at)]
        return round(at) if self.whole else float(f"{at:.9g}")

    def share(self, value: float | str) -> float:
        """Return where a value is in the range, as a share."""
        place = self.words.index(str(value)) if self.words else float(value)
        if self.high == self.low:
            return 0.0
        if self.scale == "log":
            floor = max(place, 1e-3 * self.low)
            return math.log(floor / self.low) / math.log(self.high / self.low)
        return (place - self.low) / (self.high - self.low)

    def shown(self, value: float | str) -> str:
        """Return a value with its unit."""
        return f"{value}" if self.words else f"{value:.4g} {self.unit}".replace(" 1", "").strip()

    def range_shown(self) -> str:
        """Return its bounds in words."""
        if self.words:
            return ", ".join(self.words)
        return f"{self.low:g} to {self.high:g} {self.unit}".removesuffix(" 1")


def _link(scenario: Scenario) -> Any:
    return scenario.channel.link("up")


def _delay(scenario: Scenario) -> float:
    link = _link(scenario)
    law = link.delay if isinstance(link, Packets) else link
    return float(law.at(0.0))


def _of_packets(get: Callable[[Packets], float | str], otherwise: float | str) -> Any:
    def own(scenario: Scenario) -> float | str:
        link = _link(scenario)
        return get(link) if isinstance(link, Packets) else otherwise

    return own


def _jitter_kind(link: Packets) -> str:
    kind = link.jitter.distribution
    return kind if kind in KINDS_OF_JITTER else KINDS_OF_JITTER[0]


def _spread(link: Packets) -> float:
    return link.jitter.std / link.jitter.mean if link.jitter.mean > 0.0 else SPREAD


def _of_hand(name: str) -> Any:
    return lambda scenario: getattr(scenario.operator, name)


def _of_wall(name: str) -> Any:
    def own(scenario: Scenario) -> float | None:
        surfaces = scenario.environment.surfaces
        return getattr(surfaces[0], name, None) if surfaces else None

    return own


def _shift(scenario: Scenario) -> float | None:
    surfaces = scenario.environment.surfaces
    movable = surfaces and hasattr(surfaces[0], "normal") and hasattr(surfaces[0], "point")
    return 0.0 if movable else None


def _number(
    name: str, unit: str, low: float, high: float, own: Any, meaning: str, scale: str = "linear"
) -> Bound:
    return Bound(paths=[name], unit=unit, low=low, high=high, scale=scale, own=own, meaning=meaning)


def _word(name: str, words: tuple[str, ...], own: Any, meaning: str) -> Bound:
    return Bound(
        paths=[name], low=0.0, high=len(words) - 1.0, words=words, own=own, meaning=meaning
    )


BOUNDS: Final[tuple[Bound, ...]] = (
    _number("channel.delay", "s", 0.0, 0.3, _delay, "of a packet, each way"),
    _number("channel.swing", "s", 0.0, 0.2, lambda s: 0.0, "amplitude of a sine beside the delay"),
    _number(
        "channel.swing_rate", "rad/s", 0.5, 50.0, lambda s: SWING_RATE, "of that sine", "log"
    ),
    _number(
        "channel.jitter", "s", 0.0, 0.05, _of_packets(lambda link: link.jitter.mean, 0.0),
        "mean of what a packet takes by chance beside the delay",
    ),
    _number(
        "channel.spread", "1", 0.05, 1.0, _of_packets(_spread, SPREAD),
        "standard deviation of the jitter over its mean",
    ),
    _word(
        "channel.distribution", KINDS_OF_JITTER, _of_packets(_jitter_kind, KINDS_OF_JITTER[0]),
        "of the jitter",
    ),
    _number(
        "channel.loss", "1", 0.0, 0.5, _of_packets(lambda link: link.loss.in_good, 0.0),
        "share of the packets that never arrive",
    ),
    _number(
        "channel.burst", "1", 1.0, 200.0, lambda s: 1.0, "mean packets lost in a row; 1 by chance",
        "log",
    ),
    _number("channel.outage", "s", 0.0, 1.0, lambda s: 0.0, "length of a time without packets"),
    _number(
        "channel.outage_at", "1", 0.0, 0.9, lambda s: OUTAGE_AT, "its start, as a share of the run"
    ),
    _number(
        "channel.send_period", "s", 1e-3, 0.02,
        _of_packets(lambda link: link.send_period, 1e-3), "from packet to packet",
    ),
    _word(
        "channel.side", SIDES, lambda s: SIDES[0], "which links have jitter, loss and the outage"
    ),
    replace(
        _number("channel.seed", "1", 0, 999, lambda s: s.seed, "of all that is drawn"), whole=True
    ),
    _number("hand.reach", "1", 0.5, 3.0, lambda s: 1.0, "factor of the hand's targets"),
    _number("hand.pace", "1", 1.0, 5.0, lambda s: 1.0, "by which the hand's times are divided"),
    _number("hand.stiffness", "N/m", 20.0, 2000.0, _of_hand("hand_stiffness"), "K", "log"),
    _number("hand.damping", "N s/m", 0.0, 40.0, _of_hand("hand_damping"), "B"),
    _number("hand.sweep", "m", 0.0, 0.03, lambda s: 0.0, "amplitude of a tremor along the press"),
    _number("hand.sweep_rate", "Hz", 0.5, 30.0, lambda s: SWEEP_RATE, "of that tremor", "log"),
    _number("wall.stiffness", "N/m", 100.0, 1e5, _of_wall("stiffness"), "of the surface", "log"),
    _number("wall.damping", "N s/m", 0.0, 500.0, _of_wall("damping"), "of the surface"),
    _number("wall.shift", "m", -0.01, 0.02, _shift, "of the surface towards the hand"),
)  # fmt: skip


def bounds_of(scenario: Scenario, changed: Sequence[str] = ()) -> list[Bound]:
    """Return the fields that a scenario has, with bounds changed by texts; see `changed_bounds`.

    A field whose own value already is where both its bounds are cannot be attacked, and is left
    out.

    Raises:
        ValueError: a text is not NAME=LOW:HIGH of a field of the scenario.
    """
    own = [bound for bound in BOUNDS if bound.own(scenario) is not None]
    return [
        bound
        for bound in changed_bounds(own, changed)
        if not (bound.low == bound.high == bound.own(scenario))
    ]


def changed_bounds(bounds: Sequence[Bound], changed: Sequence[str]) -> list[Bound]:
    """Return bounds of which some are changed.

    Args:
        bounds: all.
        changed: texts: "channel.delay=0:0.5"; "channel.loss=off" leaves a field alone, and
            "only=channel.delay,channel.jitter" all but these; of words "channel.side=up,down".

    Raises:
        ValueError: one line that names the text, the field and what is allowed.
    """
    by_name = {bound.label: bound for bound in bounds}
    for text in changed:
        name, equals, value = (part.strip() for part in text.partition("="))
        if name == "only" and equals:
            kept = [each.strip() for each in value.split(",")]
            for each in kept:
                _known(each, by_name, text)
            by_name = {label: each for label, each in by_name.items() if label in kept}
            continue
        _known(name, by_name, text)
        if value == "off":
            del by_name[name]
            continue
        bound = by_name[name]
        by_name[name] = _words(bound, value, text) if bound.words else _numbers(bound, value, text)
    if not by_name:
        raise ValueError("--bound: no field is left to attack, allowed 1 or more")
    return list(by_name.values())


def _known(name: str, by_name: Mapping[str, Bound], text: str) -> None:
    if name not in by_name:
        raise ValueError(
            f"--bound: {checks.shown(text)}, allowed NAME=LOW:HIGH with a name of "
            f"{', '.join(by_name)}{checks.nearest(name, by_name)}"
        )


def _numbers(bound: Bound, value: str, text: str) -> Bound:
    """Return a bound with other numbers; they may be wider, as far as the field itself allows."""
    try:
        low, high = (float(each) for each in value.split(":"))
    except ValueError:
        raise ValueError(
            f"--bound: {checks.shown(text)}, allowed {bound.label}=LOW:HIGH or off"
        ) from None
    floor = -math.inf if bound.low < 0.0 else checks.ABOVE_ZERO if bound.scale == "log" else 0.0
    checks.number(f"--bound {bound.label}, low", low, floor)
    checks.number(f"--bound {bound.label}, high", high, low)
    return replace(bound, low=low, high=high)


def _words(bound: Bound, value: str, text: str) -> Bound:
    words = tuple(each.strip() for each in value.split(","))
    for each in words:
        checks.choice(f"--bound {bound.label}", each, bound.words)
    return replace(bound, words=words, high=len(words) - 1.0)


def shares_of(bounds: Sequence[Bound], attack: Attack) -> np.ndarray:
    """Return where an attack is in each field's range (fields,), NaN where it leaves it alone."""
    return np.array(
        [bound.share(attack[bound.label]) if bound.label in attack else np.nan for bound in bounds]
    )
