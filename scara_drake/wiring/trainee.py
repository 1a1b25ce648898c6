"""The wiring of a scripted operator: a joystick's, closed by what comes back over the downlink.

::

    joystick -> mapping -> uplink -> inverse_kinematics -> (controller)
     ^    ^
     |    '--- view <----- tool_position <- (plant)      tool_seen
     '-------- downlink <- (contact)                     f_haptic
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import DiagramBuilder, OutputPort

from scara_drake.kinematics import forward_kinematics
from scara_drake.operator.trainee import ToolPosition, TraineeSource
from scara_drake.tasks.plans import plan_for
from scara_drake.wiring import Signals, chain, outputs
from scara_drake.wiring.joystick import add_mapping, add_remote

if TYPE_CHECKING:
    from scara_drake.operator.trainee import Trainee
    from scara_drake.scenario import Scenario

Array = NDArray[np.float64]

SEEDS: Final = 2**62  # those of the scenario's other streams are below


def add_trainee(
    builder: DiagramBuilder, scenario: Scenario, q_start: Array, signals: Signals
) -> Signals:
    """Add the scripted operator, his view, and what a joystick's signal passes."""
    operator: Trainee = scenario.operator  # type: ignore[assignment]  # the table has chosen it
    plan = plan_for(scenario.task, scenario.environment, operator.first_command()[:3])
    source = TraineeSource(operator, plan, SEEDS + scenario.seed % SEEDS)
    joystick = builder.AddNamedSystem("joystick", source)
    signals = signals | dict(outputs(joystick))
    signals = add_mapping(builder, operator.mapping, scenario.time_step, signals)
    signals = add_remote(builder, scenario, operator.first_command(), q_start, signals)
    signals["tool_seen"] = add_view(builder, scenario, q_start, signals)
    for name in ("tool_seen", "f_haptic"):
        if name in signals:
            builder.Connect(signals[name], joystick.GetInputPort(name))
    return signals


def add_view(
    builder: DiagramBuilder, scenario: Scenario, q_start: Array, signals: Signals
) -> OutputPort:
    """Lead the tool's position back over a link of its own, by the downlink's law."""
    position = chain(builder, "tool_position", ToolPosition(), signals["state"])
    first = forward_kinematics(q_start)[:3, 3]
    link = scenario.channel.link("down")
    view = link.make_system(first, scenario.time_step, scenario.seed_of("view"))
    return chain(builder, "view", view, position)
