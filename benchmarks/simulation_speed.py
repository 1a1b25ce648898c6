"""Wall time per simulated millisecond: the plant alone, and the whole Diagrams.

Every round runs every case once, from its start, so that what else the machine does falls on all
alike; a ratio is the median of the ratios within the rounds. Nobody looks at the Meshcat scene. Run
it on a machine that rests::

    python benchmarks/simulation_speed.py --seconds 5 --parts
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import Meshcat
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlantConfig
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, Diagram, DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource
from rich.console import Console
from rich.progress import track
from rich.table import Table

from scara_drake import joints, robot
from scara_drake.diagram import make_diagram
from scara_drake.environment import Environment
from scara_drake.operator.joint_motion import JointMotion
from scara_drake.scenario import Logging, Scenario, load_scenario, scenario_names

Array = NDArray[np.float64]

PLANT, WHOLE = "the plant alone", "teleoperation"
TIME_STEP = 1e-3  # [s]


@dataclass
class Case:
    """One Diagram, and its state at t = 0."""

    name: str
    simulator: Simulator
    start: Context

    def measure(self, seconds: float) -> float:
        """Run it from its start; return the wall time of a simulated millisecond [µs]."""
        self.simulator.reset_context(self.start.Clone())
        self.simulator.Initialize()
        begin = time.perf_counter()
        self.simulator.AdvanceTo(seconds + 0.5 * TIME_STEP)  # half a tick: rounding skips none
        return 1e6 * (time.perf_counter() - begin) / (1e3 * seconds)


def make_case(name: str, diagram: Diagram) -> Case:
    """Prepare a Diagram, and run it for a moment so that everything is compiled."""
    case = Case(name, Simulator(diagram), diagram.CreateDefaultContext())
    case.measure(0.1)
    return case


def plant_alone() -> Diagram:
    """Build the URDF, its SceneGraph and collision filters; constant efforts carry its weight."""
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlant(MultibodyPlantConfig(time_step=TIME_STEP), builder)
    robot.add_scara(plant)
    plant.Finalize()
    plant.SetDefaultPositions(joints.HOME)
    weight = -plant.CalcGravityGeneralizedForces(plant.CreateDefaultContext())
    effort = builder.AddSystem(ConstantVectorSource(weight))
    builder.Connect(effort.get_output_port(), plant.get_actuation_input_port())
    return builder.Build()


def cases() -> list[Case]:
    """Return the plant alone, the scenarios, and `teleoperation` as it is drawn."""
    whole = load_scenario(WHOLE)
    others = [name for name in scenario_names() if name != WHOLE]
    return [
        make_case(PLANT, plant_alone()),
        make_case(WHOLE, make_diagram(whole)),
        make_case(f"{WHOLE}, drawn in Meshcat", make_diagram(whole, Meshcat())),
        *(make_case(name, make_diagram(load_scenario(name))) for name in others),
    ]


# What a part costs is what its Diagram costs less without it.
Without = Callable[[Scenario], Scenario]
PARTS: dict[str, Without] = {
    "recorder (one sample a second instead)": lambda whole: replace(
        whole, logging=Logging(period=1.0)
    ),
    "contact, downlink, haptics": lambda whole: replace(whole, environment=Environment()),
    "joystick to references, and the way back: a JointMotion instead": lambda whole: replace(
        whole, environment=Environment(), operator=JointMotion()
    ),
}


def part_cases() -> list[Case]:
    """Return `teleoperation` without one part each."""
    whole = load_scenario(WHOLE)
    return [make_case(part, make_diagram(without(whole))) for part, without in PARTS.items()]


def measure(cases: list[Case], seconds: float, rounds: int) -> Array:
    """Return the wall times [µs per simulated ms] (rounds, cases)."""
    return np.array(
        [
            [case.measure(seconds) for case in cases]
            for _ in track(range(rounds), "measuring", console=Console(stderr=True))
        ]
    )


def time_table(names: list[str], times: Array) -> Table:
    """Tabulate the cases; the first is what the others are compared with."""
    table = Table(title="Wall time per simulated millisecond", title_justify="left")
    for heading in ("case", "median [µs]", "quartiles [µs]", "ratio to the first", "real time"):
        table.add_column(heading, justify="left" if heading == "case" else "right")
    ratios = np.median(times / times[:, :1], axis=0)
    low, median, high = np.quantile(times, (0.25, 0.5, 0.75), axis=0)
    for index, name in enumerate(names):
        table.add_row(
            name,
            f"{median[index]:.1f}",
            f"{low[index]:.1f} to {high[index]:.1f}",
            f"{ratios[index]:.2f}",
            f"{1e3 / median[index]:.1f} x",
        )
    return table


def parts_table(names: list[str], whole: Array, without: Array) -> Table:
    """Tabulate what each part costs: the whole less the whole without it, round by round."""
    table = Table(title=f"Cost of the parts of {WHOLE}", title_justify="left")
    for heading in ("part", "median [µs]", "share"):
        table.add_column(heading, justify="left" if heading == "part" else "right")
    costs = whole[:, np.newaxis] - without
    shares = costs / whole[:, np.newaxis]
    for index, name in enumerate(names):
        cost, share = np.median(costs[:, index]), np.median(shares[:, index])
        table.add_row(name, f"{cost:.1f}", f"{100 * share:.0f} %")
    return table


def main(arguments: list[str] | None = None) -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("--seconds", type=float, default=5.0, help="simulated, a case and round")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--parts", action="store_true", help="also what each part costs")
    options = parser.parse_args(arguments)
    if not (options.seconds > 0.0 and options.rounds > 0):
        parser.error(f"--seconds {options.seconds}, --rounds {options.rounds}: allowed above 0")
    wholes = cases()
    parts = part_cases() if options.parts else []
    times = measure([*wholes, *parts], options.seconds, options.rounds)
    console = Console()
    console.print(time_table([case.name for case in wholes], times[:, : len(wholes)]))
    if parts:
        whole = times[:, [case.name for case in wholes].index(WHOLE)]
        console.print(parts_table([case.name for case in parts], whole, times[:, len(wholes) :]))


if __name__ == "__main__":
    main()
