"""What a channel of eight signals costs, beside the plant alone.

Each Diagram is the plant and one channel that nobody reads, at 1 kHz and at the simulator's
fastest. What a channel adds is its Diagram's wall time less the plant's, over the plant's, within
every round. At most 0.5 is asked for, with a delay of 2 s as with a short one. Run it on a machine
that rests::

    python benchmarks/channel_cost.py --seconds 5
"""

from __future__ import annotations

import argparse

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlantConfig
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table
from simulation_speed import PLANT, TIME_STEP, Case, make_case, measure, plant_alone

from scara_drake import joints, robot
from scara_drake.channel.delays import ConstantDelay, SineDelay
from scara_drake.channel.impairments import Jitter, Loss
from scara_drake.channel.links import Link
from scara_drake.channel.packets import Packets

Array = NDArray[np.float64]

SIGNALS = 8
LONGEST = (0.2, 2.0)  # delays [s]
ALLOWED = 0.5  # share of the plant's cost


def links(longest: float) -> dict[str, Link]:
    """Return the channels whose delay goes up to `longest` [s]."""
    jitter = Jitter("gamma", 0.05 * longest, 0.025 * longest)
    return {
        "SignalDelay, constant": ConstantDelay(longest),
        "SignalDelay, sine": SineDelay(0.5 * longest, 0.5 * longest),
        "PacketChannel, constant": Packets(ConstantDelay(longest), longest=longest),
        "PacketChannel, jitter and loss": Packets(
            ConstantDelay(0.8 * longest), jitter, Loss(0.01, 0.5, 0.001, 0.1), longest=longest
        ),
    }


def plant_and_channel(link: Link) -> Diagram:
    """Build the plant of `plant_alone`, and a channel beside it."""
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlant(MultibodyPlantConfig(time_step=TIME_STEP), builder)
    robot.add_scara(plant)
    plant.Finalize()
    plant.SetDefaultPositions(joints.HOME)
    weight = -plant.CalcGravityGeneralizedForces(plant.CreateDefaultContext())
    effort = builder.AddSystem(ConstantVectorSource(weight))
    builder.Connect(effort.get_output_port(), plant.get_actuation_input_port())
    sent = builder.AddSystem(ConstantVectorSource(np.linspace(0.0, 1.0, SIGNALS)))
    channel = builder.AddSystem(link.make_system(np.zeros(SIGNALS), TIME_STEP, 0))
    builder.Connect(sent.get_output_port(), channel.GetInputPort("signal_sent"))
    return builder.Build()


def cost_table(names: list[str], times: Array) -> Table:
    """Tabulate what each case adds to the first; times [µs per simulated ms] (rounds, cases)."""
    title = f"{SIGNALS} signals: wall time per simulated millisecond [µs]"
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD, padding=(0, 1, 0, 0))
    for heading in ("case", "median", "added", "/ plant", "allowed", "met"):
        table.add_column(heading, justify="left" if heading == "case" else "right", no_wrap=True)
    plant = times[:, 0]
    table.add_row(names[0], f"{np.median(plant):.1f}")
    for index, name in enumerate(names[1:], start=1):
        added = times[:, index] - plant
        ratio = float(np.median(added / plant))
        table.add_row(
            name,
            f"{np.median(times[:, index]):.1f}",
            f"{np.median(added):.1f}",
            f"{ratio:.2f}",
            f"{ALLOWED:g}",
            "yes" if ratio <= ALLOWED else "no",
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
    cases: list[Case] = [make_case(PLANT, plant_alone())]
    for longest in LONGEST:
        for name, link in links(longest).items():
            cases.append(make_case(f"{name}, {longest:g} s", plant_and_channel(link)))
    times = measure(cases, options.seconds, options.rounds)
    Console().print(cost_table([case.name for case in cases], times))


if __name__ == "__main__":
    main()
