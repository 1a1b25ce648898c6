"""One run of an attack, and what it came to."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import xarray as xr

from scara_drake.attack.bounds import Attack, Bound
from scara_drake.attack.objectives import OBJECTIVES, promise_broken
from scara_drake.attack.space import attacked
from scara_drake.engine.errors import LeftTheModelError
from scara_drake.recordings.samples import Samples
from scara_drake.scenario import Scenario, check_scenario
from scara_drake.simulation.many import one_line
from scara_drake.simulation.run import run_into
from scara_drake.simulation.steppers import COMPILED

NOTHING: Final = -math.inf  # harm of a run that does not count


@dataclass(frozen=True)
class Problem:
    """What is attacked.

    Attributes:
        scenario: of a master, which is checked.
        bounds: what may be changed.
        thresholds: of the objectives, by name.
        watched: objectives that are measured as well, and are no part of the harm.
    """

    scenario: Scenario
    bounds: Sequence[Bound]
    thresholds: Mapping[str, float]
    watched: Sequence[str] = ()

    def check(self) -> None:
        """Check the scenarios at the ends of the fields' ranges, each beside the own values.

        And that the coupling has the objectives at all.

        Raises:
            ValueError: a bound is beyond what the field itself allows; names the bound.
        """
        check_scenario(attacked(self.scenario, {}))
        for name in self.thresholds:
            OBJECTIVES[name].check(self.scenario)
        for bound in self.bounds:
            for end in bound.words or (bound.value(0.0), bound.value(1.0)):
                try:
                    check_scenario(attacked(self.scenario, {bound.label: end}))
                except ValueError as error:
                    raise ValueError(f"--bound {bound.label}: {error}") from None


@dataclass(frozen=True)
class Trial:
    """A run of an attack.

    Attributes:
        attack: what was changed.
        values: of the objectives, by name; what has none is left out.
        harm: the largest of value over threshold; above 1 is a breach.
        note: why the run does not count, or why it was cut.
        left_at: when it met what only Drake computes [s], and was cut.
    """

    attack: Attack
    values: Mapping[str, float] = field(default_factory=dict)
    harm: float = NOTHING
    note: str = ""
    left_at: float = math.inf

    @property
    def counts(self) -> bool:
        """Whether the run has a figure."""
        return self.harm > NOTHING

    @property
    def breach(self) -> bool:
        """Whether a threshold was passed."""
        return self.harm > 1.0


def tried(problem: Problem, attack: Attack) -> Trial:
    """Run an attack in the compiled engine; what fails has no harm and a note."""
    scenario = attacked(problem.scenario, attack)
    try:
        recording, left_at = _recorded(scenario)
    except (ValueError, RuntimeError, ArithmeticError) as error:
        return Trial(attack, note=one_line(error))
    if broken := promise_broken(scenario, recording):
        return Trial(attack, note=broken, left_at=left_at)
    values, missing = {}, ""
    for name in (*problem.thresholds, *problem.watched):
        try:
            value = OBJECTIVES[name].of(scenario, recording)
        except ValueError as error:
            missing = one_line(error)
            continue
        if math.isfinite(value):
            values[name] = value
    ratios = [values[name] / limit for name, limit in problem.thresholds.items() if name in values]
    harm = max(ratios, default=NOTHING)
    return Trial(attack, values, harm, missing, left_at)


def _recorded(scenario: Scenario) -> tuple[xr.Dataset, float]:
    """Return a recording, and when the run left the engine's model [s]: until then it is whole.

    Raises:
        ValueError, RuntimeError: the run failed.
    """
    try:
        return _run(scenario), math.inf
    except LeftTheModelError as error:
        until = error.time - scenario.time_step
        if until < scenario.time_step:
            raise
        short = replace(scenario)
        short.duration = until
        return _run(short), error.time


def _run(scenario: Scenario) -> xr.Dataset:
    samples = Samples()
    run_into(samples, scenario, engine=COMPILED)
    return samples.recording()
