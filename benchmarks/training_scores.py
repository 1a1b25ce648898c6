"""Scores of the scripted operators: each task, skill and delay over seeds, as tables.

python benchmarks/training_scores.py --seeds 30
python benchmarks/training_scores.py --seeds 10 --skills good --round-trips 0 0.25 0.5 1
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from collections.abc import Iterator
from typing import Any

import numpy as np
import xarray as xr

import scara_drake as sd
from scara_drake.common.shipped import training_names
from scara_drake.operator.skills import SKILLS
from scara_drake.operator.trainee import Trainee
from scara_drake.scenario import Scenario
from scara_drake.simulation.many import Failed, each_run

Case = tuple[str, str, float, int]


def trained(task: str, skill: str, round_trip: float, seed: int, duration: float) -> Scenario:
    """A task, done by a scripted operator over a constant delay [s], half of it each way."""
    half = f"!ConstantDelay {{delay: {round_trip / 2}}}"
    changes = {"duration": duration, "seed": seed, "channel.up": half, "channel.down": half}
    scenario = sd.load_scenario(task, changes | {"logging.period": 0.005})
    operator: Any = scenario.operator  # a training scene's is a joystick
    scenario.operator = Trainee(skill, mapping=operator.mapping)
    return scenario


def scored(scenario: Scenario, recording: xr.Dataset) -> tuple[float, float, float]:
    """Total, share done and seconds of a run."""
    found = sd.metrics.score(recording)
    assert found is not None  # a training scene has a task
    return found.total, found.share, found.seconds


def measure(options: argparse.Namespace) -> Iterator[tuple[Case, tuple[float, float, float]]]:
    """Yield each case with its score."""
    cases = [
        (task, skill, round_trip, seed)
        for task in options.tasks
        for round_trip in options.round_trips
        for skill in options.skills
        for seed in range(options.seeds)
    ]
    runs = ((number, trained(*case, options.duration)) for number, case in enumerate(cases))
    for number, result in each_run(runs, scored, options.jobs, options.engine):
        if isinstance(result, Failed):
            print(f"{cases[number]}: {result.reason}", flush=True)
        else:
            yield cases[number], result


def main() -> None:
    """Measure, and print a row for each task, delay and skill as soon as all its seeds have run."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tasks", nargs="+", default=training_names())
    parser.add_argument("--skills", nargs="+", default=[*SKILLS])
    parser.add_argument("--round-trips", nargs="+", type=float, default=[0.1])
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--duration", type=float, default=120.0)
    parser.add_argument("--engine", default="auto", help="compiled leaves out what needs Drake")
    parser.add_argument("--jobs", type=int, default=1)
    options = parser.parse_args()
    print("| task | round trip [s] | skill | score, mean ± SD | least | done | time, median [s] |")
    print("|---|---|---|---|---|---|---|", flush=True)
    found: dict[tuple[str, str, float], list[tuple[float, float, float]]] = defaultdict(list)
    for (task, skill, round_trip, _), result in measure(options):
        rows = found[task, skill, round_trip]
        rows.append(result)
        if len(rows) == options.seeds:
            total, _, seconds = np.array(rows).T
            done = int(np.isfinite(seconds).sum())
            median = f"{np.nanmedian(seconds):.1f}" if done else "-"
            spread = total.std(ddof=1) if len(total) > 1 else 0.0
            print(
                f"| {task} | {round_trip:g} | {skill} | {total.mean():.1f} ± {spread:.1f} "
                f"| {total.min():.1f} | {done} of {len(rows)} | {median} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
