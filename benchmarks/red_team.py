"""A long attack on TDPA: how near a hand, a channel and a wall come to its invariant.

::

    python benchmarks/red_team.py --runs 10000 --jobs 2

Half of the runs search for a breach of the invariant, half for energy made in all; both measure
both, at every tick, on each axis and at both ends. An end may give out what came in at the other
end when the packet in use was sent, and its reserve E0: a ratio (given out - told) / E0 above 1 is
a breach.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Sequence
from functools import partial

import numpy as np
import xarray as xr

from scara_drake import load_scenario
from scara_drake.attack.bounds import bounds_of
from scara_drake.attack.coverage import coverage_of
from scara_drake.attack.objectives import (
    OBJECTIVES,
    ROUNDING,
    Objective,
    energy_accounts,
    thresholds_of,
)
from scara_drake.attack.search import BATCH, Plan, search
from scara_drake.attack.space import shortened
from scara_drake.attack.trial import Problem, Trial
from scara_drake.scenario import Scenario
from scara_drake.simulation.processes import processes

ENDS = ("slave", "master")
SEARCHED = ("invariant", "energy")


def ratio(end: int, axis: int, scenario: Scenario, recording: xr.Dataset) -> float:
    """Largest (given out - told) / E0 of an end and an axis, over the ticks."""
    spent, told = energy_accounts(recording, scenario.time_step)[end]
    return float(np.max(spent[:, axis] - told[:, axis]) / scenario.coupling.reserve)


def turning(scenario: Scenario, recording: xr.Dataset) -> float:
    """Fastest change of the device's velocity, over the `turn` for which the bound holds."""
    change = np.diff(recording.v_master.transpose("time", "axis").values, axis=0)
    return float(np.abs(change).max() / scenario.time_step / scenario.coupling.turn)


def told(trials: list[Trial], name: str) -> tuple[float, float, float]:
    """Largest, 99th and 50th percentile of a figure over the runs that count."""
    values = [trial.values[name] for trial in trials if name in trial.values]
    return max(values), *np.quantile(values, [0.99, 0.5])  # type: ignore[return-value]


def add_figures() -> list[str]:
    """Add the figures of this script to the objectives; return their names."""
    names = []
    for end, name in enumerate(ENDS):
        for axis, letter in enumerate("xyz"):
            names.append(f"ratio {name} {letter}")
            figure = partial(ratio, end, axis)
            OBJECTIVES[names[-1]] = Objective("1", "of the reserve", figure, lambda scenario: 1.0)
    OBJECTIVES["turn"] = Objective("1", "of `turn`", turning, lambda scenario: 1.0)
    return [*names, "turn"]


def attack(part: tuple[str, int], runs: int, duration: float) -> list[Trial]:
    """Return the runs of a search for an objective, by its name and a seed."""
    objective, seed = part
    scenario = pressed(duration)
    watched = [*add_figures(), *(each for each in SEARCHED if each != objective)]
    bounds, thresholds = bounds_of(scenario), thresholds_of(scenario, [objective])
    problem = Problem(scenario, bounds, thresholds, watched)

    def show(trials: Sequence[Trial]) -> None:
        if len(trials) % 200 < BATCH:
            most = [max(t.values.get(name, -math.inf) for t in trials) for name in SEARCHED]
            print(f"{objective}, seed {seed}: {len(trials)} runs, at most {most} J", flush=True)

    return search(problem, Plan(runs, seed, 1), show)


def pressed(duration: float) -> Scenario:
    """Return the press that is attacked."""
    return shortened(load_scenario("bilateral", {"coupling": "!Tdpa {}"}), duration)


def main() -> None:
    """Search, and print what came near."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--runs", type=int, default=10_000, help="in all")
    parser.add_argument("--seed", type=int, default=0, help="of the first search")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument("--duration", type=float, default=3.0, help="of a run [s]")
    options = parser.parse_args()
    begin = time.perf_counter()
    parts = [(name, options.seed + index) for index, name in enumerate(SEARCHED * 2)]
    one = partial(attack, runs=options.runs // len(parts), duration=options.duration)
    with processes(options.jobs) as pool:
        trials = [trial for part in pool.map(one, parts) for trial in part]
    print(f"\n{len(trials)} runs in {time.perf_counter() - begin:.0f} s, seed {options.seed}")
    tell(trials, options.duration)


def tell(trials: list[Trial], duration: float) -> None:
    """Print the largest figures, what was covered, and the breaches."""
    counted = [trial for trial in trials if trial.counts]
    cut = sum(math.isfinite(trial.left_at) for trial in counted)
    print(f"{len(counted)} count, {cut} of them until they left the engine's model")
    for reason in sorted({trial.note[:80] for trial in trials if not trial.counts})[:10]:
        print(f"left out, as: {reason}")
    print("\n| figure | largest | 99 % | median |\n|---|---|---|---|")
    for name in (*add_figures(), *SEARCHED):
        most, high, median = told(counted, name)
        print(f"| {name} [{OBJECTIVES[name].unit}] | {most:.15g} | {high:.6g} | {median:.6g} |")
    coverage = coverage_of(bounds_of(pressed(duration)), trials)
    print("\n| field | reached | median | largest gap | attacked |\n|---|---|---|---|---|")
    for name, each in coverage.fields.items():
        print(
            f"| {name} | {each.low} to {each.high} | {each.median} | {each.gap:.2%} | "
            f"{each.attacked:.0%} |"
        )
    print(f"\npairs of fields: {coverage.pairs:.2%} of the cells of ten by ten have a run")
    breaches = [trial for trial in counted if trial.values["invariant"] > ROUNDING]
    print(f"breaches of the invariant, above {ROUNDING:g} J: {len(breaches)}")
    for trial in breaches[:5]:
        print(dict(trial.attack), trial.values["invariant"])


if __name__ == "__main__":
    main()
