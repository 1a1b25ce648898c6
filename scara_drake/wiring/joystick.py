"""The wiring of an operator with a joystick.

::

    joystick -> mapping -> uplink -> inverse_kinematics -> (controller)
        ^
        '--- haptics <- downlink <- (contact)
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import DiagramBuilder

from scara_drake.ik.system import InverseKinematicsSystem
from scara_drake.operator.haptics import HapticOutput
from scara_drake.operator.joystick import Joystick
from scara_drake.operator.kinesthetic import KinestheticOutput
from scara_drake.operator.mapping import JoystickToPose, initial_command
from scara_drake.scenario import Scenario
from scara_drake.wiring import Signals, chain, link_signals, outputs

Array = NDArray[np.float64]


def add_joystick(
    builder: DiagramBuilder,
    scenario: Scenario,
    operator: Joystick,
    q_start: Array,
    signals: Signals,
) -> Signals:
    """Add the operator's side, the channel both ways and the inverse kinematics."""
    channel, period = scenario.channel, scenario.time_step
    command = initial_command(operator.mapping)
    device = operator.open_device()
    joystick = builder.AddNamedSystem("joystick", operator.make_source(device))
    mapping = builder.AddNamedSystem("mapping", JoystickToPose(operator.mapping, period))
    uplink = builder.AddNamedSystem(
        "uplink", channel.link("up").make_system(command, period, scenario.stream(0))
    )
    kinematics = builder.AddNamedSystem(
        "inverse_kinematics",
        InverseKinematicsSystem(
            scenario.inverse_kinematics, command, q_start, scenario.seed, period
        ),
    )
    builder.Connect(joystick.get_output_port(), mapping.get_input_port())
    builder.Connect(mapping.get_output_port(), uplink.get_input_port())
    builder.Connect(uplink.GetOutputPort("signal_received"), kinematics.get_input_port())
    made = {
        **dict(outputs(joystick)),
        **dict(outputs(mapping)),
        **dict(outputs(kinematics)),
        "tool_command_received": uplink.GetOutputPort("signal_received"),
        **link_signals(uplink, "up"),
    }
    if "f_env_on_tool_W" in signals:
        downlink = builder.AddNamedSystem(
            "downlink",
            channel.link("down").make_system(np.zeros(3), period, scenario.stream(1)),
        )
        haptics = builder.AddNamedSystem("haptics", HapticOutput(scenario.haptics, device))
        builder.Connect(signals["f_env_on_tool_W"], downlink.get_input_port())
        builder.Connect(downlink.GetOutputPort("signal_received"), haptics.get_input_port())
        made |= link_signals(downlink, "down")
        made["f_haptic"] = downlink.GetOutputPort("signal_received")
        made["rumble"] = haptics.GetOutputPort("rumble")
        if scenario.kinesthetic is not None:
            device_force = KinestheticOutput(scenario.kinesthetic, period)
            made["f_kinesthetic"] = chain(builder, "kinesthetic", device_force, made["f_haptic"])
    return made
