"""The engine beside Drake's Diagram, Drake's plant alone, and other simulators' bare robot.

Whole scenarios run with all signals recorded; the plant alone and the peers do nothing but step the
robot. Every round runs each case for a short stretch, in random order, so that what else the
machine does falls on all alike; a ratio is the median of the ratios within the rounds. Run it on a
machine that rests, with the extra `benchmarks` for the peers::

    python benchmarks/engine_speed.py
    python benchmarks/engine_speed.py --save  # also to benchmarks/results/engine_speed.md
"""

from __future__ import annotations

import argparse
import os
import platform
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from peers import peer_steps
from pydrake.systems.analysis import Simulator
from rich.box import MARKDOWN
from rich.console import Console
from rich.progress import track
from rich.table import Table
from simulation_speed import TIME_STEP, plant_alone

from scara_drake import Scenario, load_scenario, make_diagram, simulate
from scara_drake.engine.stepper import CompiledStepper
from scara_drake.simulation.steppers import compiled_stepper

Array = NDArray[np.float64]

RESULTS = Path(__file__).parent / "results" / "engine_speed.md"
SCENARIOS = ("teleoperation", "bilateral")
PLANT, THREADS = "Drake's plant alone", "two threads"
MUJOCO = "MuJoCo, bare robot, its loop in C"


@dataclass
class Case:
    """Something that is advanced by a stretch of simulated time [s].

    Attributes:
        name: in the table.
        advance: advances it.
    """

    name: str
    advance: Callable[[float], None]

    def measure(self, seconds: float) -> float:
        """Advance it; return the wall time of a simulated millisecond [µs]."""
        begin = time.perf_counter()
        self.advance(seconds)
        return 1e6 * (time.perf_counter() - begin) / (1e3 * seconds)


@dataclass(frozen=True)
class Criterion:
    """A ratio between two cases that is asked for.

    Attributes:
        text: what is asked for.
        of: name of a case.
        to: name of the case that it is divided by.
        bound: of the ratio.
        at_least: it is a lower bound, else an upper one.
        factor: of the ratio.
    """

    text: str
    of: str
    to: str
    bound: float
    at_least: bool = False
    factor: float = 1.0


def engine(name: str) -> str:
    """Return the name of a scenario's case in the engine."""
    return f"engine, {name}"


def diagram(name: str) -> str:
    """Return the name of a scenario's case in Drake."""
    return f"Drake's Diagram, {name}"


CRITERIA = (
    Criterion("teleoperation in the engine / the plant alone", engine(SCENARIOS[0]), PLANT, 0.3),
    Criterion(
        "teleoperation: Drake's Diagram / the engine",
        diagram(SCENARIOS[0]),
        engine(SCENARIOS[0]),
        12.0,
        at_least=True,
    ),
    Criterion("bilateral in the engine / the plant alone", engine(SCENARIOS[1]), PLANT, 0.35),
    Criterion("two threads / one, runs in a time", engine(SCENARIOS[0]), THREADS, 1.8, True, 2.0),
    Criterion(
        "teleoperation in the engine / MuJoCo's bare step", engine(SCENARIOS[0]), MUJOCO, 1.0
    ),
)


def compiled(scenario: Scenario) -> CompiledStepper:
    """Return a scenario in the engine, begun; it is compiled here where it is not yet."""
    stepper = compiled_stepper(make_diagram(scenario), scenario)
    stepper.begin()
    return stepper


def run_on(stepper: CompiledStepper) -> Callable[[float], None]:
    """Return what advances a scenario in the engine and takes its samples."""
    reached = 0.0

    def advance(seconds: float) -> None:
        nonlocal reached
        reached += seconds
        stepper.advance_to(reached)
        stepper.drain()

    return advance


def drake(simulator: Simulator) -> Callable[[float], None]:
    """Return what advances a Diagram."""
    simulator.Initialize()

    def advance(seconds: float) -> None:
        simulator.AdvanceTo(simulator.get_context().get_time() + seconds)

    return advance


def side_by_side(ways: list[Callable[[float], None]]) -> Callable[[float], None]:
    """Return what advances several at once, a thread each."""

    def advance(seconds: float) -> None:
        threads = [threading.Thread(target=way, args=(seconds,)) for way in ways]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()

    return advance


def stepped(steps: Callable[[int], None]) -> Callable[[float], None]:
    """Return what advances a peer."""
    return lambda seconds: steps(round(seconds / TIME_STEP))


def cases(duration: float) -> tuple[list[Case], dict[str, float]]:
    """Return all cases, for so much simulated time [s], and how far the peers are from Drake."""
    found = [Case(PLANT, drake(Simulator(plant_alone())))]
    for name in SCENARIOS:
        scenario = load_scenario(name, {"duration": duration})
        found.append(Case(engine(name), run_on(compiled(scenario))))
        found.append(Case(diagram(name), drake(Simulator(make_diagram(scenario)))))
    scenario = load_scenario(SCENARIOS[0], {"duration": duration})
    found.append(Case(THREADS, side_by_side([run_on(compiled(scenario)) for _ in range(2)])))
    peers = peer_steps(TIME_STEP)
    found += [Case(name, stepped(steps)) for name, (steps, _) in peers.items()]
    return found, {name: far for name, (_, far) in peers.items()}


def measure(found: list[Case], seconds: float, rounds: int) -> Array:
    """Return the wall times [µs per simulated ms] (rounds, cases)."""
    rng = np.random.default_rng(0)
    times = np.zeros((rounds + 1, len(found)))
    for row in track(times, "measuring", console=Console(stderr=True)):
        for index in rng.permutation(len(found)):
            row[index] = found[index].measure(seconds)
    return times[1:]  # the first round warms up


def time_table(names: list[str], times: Array) -> Table:
    """Tabulate the cases beside the first."""
    table = Table(box=MARKDOWN)
    for heading in ("case", "median", "quartiles", "/ plant", "x real time"):
        table.add_column(heading, justify="left" if heading == "case" else "right", no_wrap=True)
    ratios = np.median(times / times[:, :1], axis=0)
    low, median, high = np.quantile(times, (0.25, 0.5, 0.75), axis=0)
    for index, name in enumerate(names):
        table.add_row(
            f"{name}, both" if name == THREADS else name,
            f"{median[index]:.2f}",
            f"{low[index]:.2f} to {high[index]:.2f}",
            f"{ratios[index]:.3f}",
            f"{1e3 / median[index]:.0f}",
        )
    return table


def verdicts(names: list[str], times: Array) -> Table:
    """Tabulate what was asked for, and what was measured."""
    table = Table(box=MARKDOWN)
    for heading in ("ratio", "measured", "asked for", "met"):
        table.add_column(heading, justify="left" if heading == "ratio" else "right", no_wrap=True)
    for one in CRITERIA:
        if one.of not in names or one.to not in names:
            table.add_row(one.text, "not measured", f"{one.bound:g}", "")
            continue
        of, to = times[:, names.index(one.of)], times[:, names.index(one.to)]
        ratio = float(np.median(one.factor * of / to))
        met = ratio >= one.bound if one.at_least else ratio <= one.bound
        sign = "at least" if one.at_least else "at most"
        table.add_row(one.text, f"{ratio:.2f}", f"{sign} {one.bound:g}", "met" if met else "missed")
    return table


def whole_call() -> str:
    """Return what `simulate` takes for a scenario as it is shipped, building and all."""
    scenario = load_scenario(SCENARIOS[0])
    walls = []
    for _ in range(3):
        begin = time.perf_counter()
        simulate(scenario, engine="compiled")
        walls.append(time.perf_counter() - begin)
    return (
        f"A whole call of `simulate`, {scenario.duration:g} s of {SCENARIOS[0]}: "
        f"{np.median(walls):.2f} s, with the building of the Diagram and the recording."
    )


def main(arguments: list[str] | None = None) -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("--seconds", type=float, default=5.0, help="simulated, a case and round")
    parser.add_argument("--rounds", type=int, default=12)
    parser.add_argument("--save", action="store_true", help=f"to {RESULTS.name}, too")
    options = parser.parse_args(arguments)
    if not (options.seconds > 0.0 and options.rounds > 0):
        parser.error(f"--seconds {options.seconds}, --rounds {options.rounds}: allowed above 0")
    found, far = cases((options.rounds + 2) * options.seconds)
    times = measure(found, options.seconds, options.rounds)
    names = [case.name for case in found]
    console = Console(record=True, width=120)
    console.print("# Speed of the engine\n")
    console.print(
        f"Wall time per simulated millisecond [µs] at {1.0 / TIME_STEP:.0f} Hz. Scenarios with all "
        "signals recorded; the plant alone and the peers only step the robot.\n",
        soft_wrap=True,
    )
    console.print(time_table(names, times))
    console.print(verdicts(names, times))
    console.print(f"\n{whole_call()}\n", soft_wrap=True)
    for name, distance in far.items():
        console.print(f"{name}: accelerations within {distance:.1g} of Drake's.\n")
    load = os.getloadavg()[0]
    console.print(
        f"{options.rounds} rounds of {options.seconds:g} s, {platform.machine()}, "
        f"{os.cpu_count()} cores, load {load:.1f}."
    )
    if options.save:
        RESULTS.write_text(console.export_text())


if __name__ == "__main__":
    main()
