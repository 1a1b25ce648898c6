"""What is found is made as small as it can be: delta debugging of an attack.

The smallest attack is the one with the fewest fields, and of these the one nearest to what the
scenario has itself, in shares of the fields' ranges. Without any one of the fields that remain no
threshold is passed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Final

from scara_drake.attack.bounds import Attack, Bound
from scara_drake.attack.space import DURATION
from scara_drake.attack.trial import Problem, Trial, tried
from scara_drake.common.parallel import side_by_side

HALVINGS: Final = 10  # of a field's distance from what the scenario has
REFINED: Final = 2  # bisections between the last that is a breach and the first that is none
SHORTER: Final = (0.25, 0.5, 0.75)  # shares of the duration that are tried


@dataclass
class Shrunk:
    """An attack made small.

    Attributes:
        trial: the smallest that is still a breach.
        runs: that this took.
        without: harm without each of its fields, by name: none of it is a breach.
    """

    trial: Trial
    runs: int = 0
    without: dict[str, float] = field(default_factory=dict)


def shrink(problem: Problem, trials: Sequence[Trial], jobs: int | None = None) -> Shrunk:
    """Return the smallest attack that is still a breach, of what the first breach breaches most.

    Args:
        problem: what is attacked.
        trials: of a search, one of them a breach. Where one changed a single field and was a
            breach, that is a beginning too.
        jobs: side by side; all cores if None.

    Raises:
        ValueError: none is a breach.
    """
    found = next((trial for trial in trials if trial.breach), None)
    if found is None:
        raise ValueError("trials: no breach, allowed one")
    limits = problem.thresholds
    worst = max(limits, key=lambda name: found.values.get(name, -math.inf) / limits[name])
    singles = [
        trial.attack
        for trial in trials
        if len(trial.attack) == 1 and trial.values.get(worst, -math.inf) > limits[worst]
    ]
    alone = Problem(problem.scenario, problem.bounds, {worst: limits[worst]})
    return _Shrinking(alone, jobs).shrink(found.attack, singles)


class _Shrinking:
    """The runs that make an attack smaller; none is made twice."""

    def __init__(self, problem: Problem, jobs: int | None) -> None:
        self._problem, self._jobs = problem, jobs
        self._bounds = {bound.label: bound for bound in problem.bounds}
        self._known: dict[tuple[tuple[str, object], ...], Trial] = {}

    def shrink(self, found: Attack, singles: Sequence[Attack]) -> Shrunk:
        """Return the smallest of the parts of an attack, and of some of a single field."""
        attack = self._shorter(self._fewest(found, singles))
        while True:
            names = [name for name in attack if name != DURATION]
            others = self._try([_without(attack, name) for name in names])
            held = [other.attack for other in others if other.breach]
            if not held:
                break
            attack = min(held, key=self._distance)
        without = {name: other.harm for name, other in zip(names, others, strict=True)}
        return Shrunk(self._try([attack])[0], len(self._known), without)

    def _fewest(self, attack: Attack, singles: Sequence[Attack]) -> Attack:
        """Return the smallest attack of fields of this one, or of the singles."""
        if self._breaches({}):
            return {}
        parts = [{name: attack[name]} for name in attack]
        held = [each.attack for each in self._try([*parts, *singles]) if each.breach]
        if held:
            return min((self._nearest(each) for each in held), key=self._distance)
        while True:
            fewer = [_without(attack, name) for name in attack]
            held = [each.attack for each in self._try(fewer) if each.breach]
            if not held:
                return self._nearest(attack)
            # Of what may go, that goes which is farthest from the scenario.
            attack = min(held, key=self._distance)

    def _nearest(self, attack: Attack) -> Attack:
        """Return an attack on the same fields, each as near to the scenario's own as it can be."""
        for name in attack:
            if not self._bounds[name].words:
                attack = self._nearer(attack, self._bounds[name])
        return attack

    def _nearer(self, attack: Attack, bound: Bound) -> Attack:
        name = bound.label
        own = bound.share(self._own(bound))
        far, near = bound.share(attack[name]), own
        for _ in range(HALVINGS):
            middle = 0.5 * (far + own)
            if not self._breaches({**attack, name: _rounded(bound, middle)}):
                near = middle
                break
            far = middle
        for _ in range(REFINED if near != own else 0):
            middle = 0.5 * (far + near)
            if self._breaches({**attack, name: _rounded(bound, middle)}):
                far = middle
            else:
                near = middle
        smaller = {**attack, name: _rounded(bound, far)}
        return smaller if self._breaches(smaller) else attack

    def _shorter(self, attack: Attack) -> Attack:
        """Return the attack in the shortest run that is still a breach."""
        scenario = self._problem.scenario
        runs = [
            {**attack, DURATION: round(math.ceil(share * scenario.duration / 0.01) * 0.01, 2)}
            for share in SHORTER
        ]
        # What is placed by the duration of the scenario stays where it is.
        held = [each.attack for each in self._try(runs) if each.breach and not each.note]
        return held[0] if held else attack

    def _distance(self, attack: Attack) -> float:
        """Return how far an attack is from the scenario, in shares of the ranges."""
        total = 0.0
        for name, value in attack.items():
            if name == DURATION:
                continue
            bound = self._bounds[name]
            own = self._own(bound)
            way = abs(bound.share(value) - bound.share(own))
            total += float(value != own) if bound.words else way
        return total

    def _own(self, bound: Bound) -> float | str:
        own = bound.own(self._problem.scenario)
        if own is None:
            raise ValueError(f"{bound.label}: not a field of the scenario")
        return bound.words[0] if bound.words and own not in bound.words else own

    def _breaches(self, attack: Attack) -> bool:
        return self._try([attack])[0].breach

    def _try(self, attacks: Sequence[Attack]) -> list[Trial]:
        new = {_key(attack): attack for attack in attacks if _key(attack) not in self._known}
        made = side_by_side(partial(tried, self._problem), list(new.values()), self._jobs)
        self._known.update(zip(new, made, strict=True))
        return [self._known[_key(attack)] for attack in attacks]


def _key(attack: Attack) -> tuple[tuple[str, object], ...]:
    return tuple(sorted(attack.items()))


def _without(attack: Attack, name: str) -> Attack:
    return {each: value for each, value in attack.items() if each != name}


def _rounded(bound: Bound, share: float) -> float:
    """Return the value at a share, in two digits."""
    return float(f"{bound.at(share):.2g}")


def changed_fields(problem: Problem, trial: Trial) -> dict[str, str]:
    """Return what an attack changed, in words with units, by the names of the fields."""
    bounds = {bound.label: bound for bound in problem.bounds}
    return {
        name: f"{value:g} s" if name == DURATION else bounds[name].shown(value)
        for name, value in trial.attack.items()
    }
