"""What a controller of the six joints costs, beside the plant alone.

Each Diagram is the plant with a constant reference at its start posture, so that nothing but the
controller is added: a moving reference is a system of its own. The simulator runs at its fastest,
and a controller's added cost is its Diagram's wall time less the plant's, over the plant's, within
every round. At most 0.7 is asked for. Run it on a machine that rests::

    python benchmarks/control_cost.py --seconds 5
"""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlantConfig
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table
from simulation_speed import PLANT, TIME_STEP, make_case, measure, plant_alone

from scara_drake import joints, robot
from scara_drake.control.integral_sliding_mode import IntegralSlidingMode
from scara_drake.control.inverse_dynamics import InverseDynamics
from scara_drake.control.observer_sliding_mode import ObserverSlidingMode
from scara_drake.control.pid import Pid
from scara_drake.control.sliding_mode import SlidingMode

Array = NDArray[np.float64]

ALLOWED = 0.7  # of the cost of the plant alone
CONTROLLERS: dict[str, Any] = {
    "IntegralSlidingMode": IntegralSlidingMode(),
    "the same, with feedforwards": IntegralSlidingMode(
        acceleration_feedforward=True, gravity_compensation=True
    ),
    "SlidingMode": SlidingMode(),
    "Pid": Pid(),
    "ObserverSlidingMode": ObserverSlidingMode(),
    "InverseDynamics": InverseDynamics(),
}


def controlled_plant(part: Any) -> Diagram:
    """Build the plant of `plant_alone`, held by a controller where it starts."""
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlant(MultibodyPlantConfig(time_step=TIME_STEP), builder)
    robot.add_scara(plant)
    plant.Finalize()
    plant.SetDefaultPositions(joints.HOME)
    reference = builder.AddSystem(ConstantVectorSource(np.concatenate([joints.HOME, np.zeros(6)])))
    controller = builder.AddSystem(part.make_system(TIME_STEP))
    builder.Connect(reference.get_output_port(), controller.GetInputPort("state_desired"))
    builder.Connect(plant.get_state_output_port(), controller.GetInputPort("state"))
    builder.Connect(controller.GetOutputPort("actuation"), plant.get_actuation_input_port())
    return builder.Build()


def cost_table(names: list[str], times: Array) -> Table:
    """Tabulate what each case adds to the first; times [µs per simulated ms] (rounds, cases)."""
    title = "Wall time per simulated millisecond"
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD, padding=(0, 1, 0, 0))
    for heading in ("case", "median [µs]", "added [µs]", "added / plant", "allowed"):
        table.add_column(heading, justify="left" if heading == "case" else "right", no_wrap=True)
    added = times - times[:, :1]
    ratios = np.median(added / times[:, :1], axis=0)
    for index, name in enumerate(names):
        median = f"{np.median(times[:, index]):.1f}"
        if index == 0:
            table.add_row(name, median, "", "", "")
            continue
        table.add_row(
            name,
            median,
            f"{np.median(added[:, index]):.1f}",
            f"{ratios[index]:.2f}",
            "yes" if ratios[index] <= ALLOWED else "no",
        )
    return table


def main(arguments: list[str] | None = None) -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("--seconds", type=float, default=5.0, help="simulated, a case and round")
    parser.add_argument("--rounds", type=int, default=9)
    options = parser.parse_args(arguments)
    if not (options.seconds > 0.0 and options.rounds > 0):
        parser.error(f"--seconds {options.seconds}, --rounds {options.rounds}: allowed above 0")
    cases = [
        make_case(PLANT, plant_alone()),
        *(make_case(name, controlled_plant(part)) for name, part in CONTROLLERS.items()),
    ]
    times = measure(cases, options.seconds, options.rounds)
    Console().print(cost_table([case.name for case in cases], times))


if __name__ == "__main__":
    main()
