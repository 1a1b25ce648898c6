"""What is told of an attack: as data, and the scenario that was found as a file that runs."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from scara_drake.attack.coverage import Coverage, coverage_of
from scara_drake.attack.objectives import OBJECTIVES
from scara_drake.attack.search import Plan
from scara_drake.attack.shrink import Shrunk, changed_fields
from scara_drake.attack.space import attacked
from scara_drake.attack.trial import Problem, Trial
from scara_drake.common.files import write_whole
from scara_drake.common.schema import changed_yaml
from scara_drake.scenario import Scenario


@dataclass(frozen=True)
class Report:
    """What became of an attack.

    Attributes:
        problem: what was attacked.
        plan: how.
        trials: the runs of the search, in order.
        shrunk: the smallest attack that is a breach; None where there is none.
        seconds: that the search and the shrinking took, on the wall.
    """

    problem: Problem
    plan: Plan
    trials: list[Trial]
    shrunk: Shrunk | None
    seconds: float

    @property
    def found_at(self) -> int | None:
        """The number of the first run with a breach, from 1 on."""
        breaches = (number for number, trial in enumerate(self.trials, 1) if trial.breach)
        return next(breaches, None)

    def best(self, name: str) -> tuple[float, int]:
        """Return the largest value of an objective and the number of its run, or NaN and 0."""
        values = [
            (trial.values[name], number)
            for number, trial in enumerate(self.trials, 1)
            if name in trial.values
        ]
        return max(values, key=lambda each: each[0], default=(math.nan, 0))

    def coverage(self) -> Coverage:
        """What of the space was tried."""
        return coverage_of(self.problem.bounds, self.trials)

    def left_out(self) -> dict[str, int]:
        """Return how many runs do not count, by the reason without its numbers."""
        reasons = (trial.note for trial in self.trials if not trial.counts)
        return dict(Counter(_kind(reason) for reason in reasons).most_common())

    def cut(self) -> int:
        """How many runs met what only Drake computes, and count until then."""
        return sum(trial.counts and math.isfinite(trial.left_at) for trial in self.trials)

    def smallest(self, name: str) -> Scenario:
        """Return the smallest scenario that is a breach, under a name.

        Raises:
            ValueError: there is none.
        """
        if self.shrunk is None:
            raise ValueError("attack: no breach, allowed one that was found")
        made = attacked(self.problem.scenario, self.shrunk.trial.attack)
        return replace(made, name=name, description=self.sentence()[:500])

    def sentence(self) -> str:
        """Say what the smallest scenario shows."""
        if self.shrunk is None:
            return "no breach"
        ((name, value),) = self.shrunk.trial.values.items()
        what = OBJECTIVES[name]
        changed = changed_fields(self.problem, self.shrunk.trial)
        by = ", ".join(f"{field} {shown}" for field, shown in changed.items())
        return (
            f"{what.meaning}: {value:.4g} {what.unit}, above "
            f"{self.problem.thresholds[name]:.4g} {what.unit}, with {by or 'nothing changed'}"
        )

    def data(self) -> dict[str, Any]:
        """Return all of it as numbers and words."""
        coverage = self.coverage()
        bounds = {
            bound.label: {
                "allowed": list(bound.words) or [bound.low, bound.high],
                "unit": bound.unit,
                "own": bound.own(self.problem.scenario),
                **{key: _plain(each) for key, each in asdict(coverage.fields[bound.label]).items()},
            }
            for bound in self.problem.bounds
        }
        objectives = {
            name: {
                "threshold": threshold,
                "unit": OBJECTIVES[name].unit,
                "largest": _plain(self.best(name)[0]),
                "run": self.best(name)[1],
            }
            for name, threshold in self.problem.thresholds.items()
        }
        return {
            "scenario": self.problem.scenario.name,
            "duration": self.problem.scenario.duration,
            "seed": self.plan.seed,
            "runs": len(self.trials),
            "counted": sum(trial.counts for trial in self.trials),
            "left_out": self.left_out(),
            "cut": self.cut(),
            "found_at": self.found_at,
            "objectives": objectives,
            "fields": bounds,
            "pairs_covered": _plain(coverage.pairs),
            "smallest": None if self.shrunk is None else _of_shrunk(self.shrunk),
            "seconds": round(self.seconds, 1),
        }


def save_smallest(report: Report, path: Path, command: str) -> None:
    """Write the smallest scenario, with a comment that says what it shows.

    Args:
        report: of a breach.
        path: of the file.
        command: that found it.

    Raises:
        ValueError: there is no breach.
        OSError: the file cannot be written.
    """
    scenario = report.smallest(path.stem)
    changed = changed_fields(report.problem, report.shrunk.trial) if report.shrunk else {}
    lines = [
        report.sentence(),
        f"found by: {command}",
        f"run it: scara-drake run {path}",
        *(f"changed: {name} {shown}" for name, shown in changed.items()),
    ]
    head = "".join(f"# {line}\n" for line in lines)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, head + changed_yaml(scenario))


def _of_shrunk(shrunk: Shrunk) -> dict[str, Any]:
    return {
        "attack": dict(shrunk.trial.attack),
        "values": dict(shrunk.trial.values),
        "runs": shrunk.runs,
        "harm_without": {name: _plain(harm) for name, harm in shrunk.without.items()},
    }


def _kind(reason: str) -> str:
    """Return a reason without its numbers, so that like ones count together."""
    return " ".join(word for word in reason.split() if not any(c.isdigit() for c in word))[:100]


def _plain(value: Any) -> Any:
    """Return a number as JSON has it: what is not finite is null."""
    return None if isinstance(value, float) and not math.isfinite(value) else value
