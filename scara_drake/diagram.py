"""The wiring of a scenario, and nothing else: it reads like the block diagram.

::

    joystick -> mapping -> uplink -> inverse_kinematics -> controller -> plant
        ^                                                                  |  ^
        '--- haptics <----------- downlink <----------- contact <---------'--'
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import Meshcat, SceneGraph
from pydrake.multibody.plant import (
    AddMultibodyPlant,
    MultibodyPlant,
    MultibodyPlantConfig,
)
from pydrake.systems.framework import Diagram, DiagramBuilder, OutputPort, System

from scara_drake.environment import ImpedanceContact, add_walls
from scara_drake.ik.system import InverseKinematicsSystem, first_posture
from scara_drake.recording import add_recorder
from scara_drake.reference import JointMotion, JointMotionSource
from scara_drake.robot import add_scara
from scara_drake.scenario import Scenario
from scara_drake.teleop.channel import SignalDelay
from scara_drake.teleop.haptics import HapticOutput
from scara_drake.teleop.mapping import JoystickToPose, initial_command
from scara_drake.teleop.operator import Joystick
from scara_drake.visualization import add_visualization

Array = NDArray[np.float64]

# Signals by the name under which they are exported and recorded.
Signals = dict[str, OutputPort]


def make_diagram(scenario: Scenario, meshcat: Meshcat | None = None) -> Diagram:
    """Build the Diagram of a scenario; every system and exported port is named.

    The scenario is not changed. With a meshcat the Diagram also draws itself there; what it
    computes stays the same to the bit.

    Raises:
        ValueError: the scenario is not valid, or its first tool command cannot be reached.
    """
    scenario.validate()
    builder = DiagramBuilder()
    q_start = start_posture(scenario)
    plant, scene_graph = _add_plant(builder, scenario, q_start)
    controller = builder.AddNamedSystem(
        "controller", scenario.controller.make_system(scenario.time_step)
    )
    signals: Signals = {"state": plant.get_state_output_port()}
    if scenario.environment.surfaces:
        signals |= _add_contact(builder, scenario, plant)
    if isinstance(scenario.operator, JointMotion):
        signals |= _add_joint_motion(builder, scenario.operator)
    else:
        signals |= _add_teleoperation(builder, scenario, scenario.operator, q_start, signals)
    builder.Connect(signals["state"], controller.GetInputPort("state"))
    builder.Connect(signals["state_desired"], controller.GetInputPort("state_desired"))
    builder.Connect(controller.GetOutputPort("actuation"), plant.get_actuation_input_port())
    signals |= dict(_outputs(controller))

    add_recorder(builder, scenario, signals, _slow_signals(scenario))
    for name, port in signals.items():
        builder.ExportOutput(port, name)
    if meshcat is not None:
        annotations = add_visualization(builder, plant, scene_graph, meshcat, scenario.environment)
        for name in ("state", "X_WE_desired", "f_env_on_tool_W"):
            if name in signals:
                builder.Connect(signals[name], annotations.GetInputPort(name))
    diagram = builder.Build()
    diagram.set_name(scenario.name or "scara")
    return diagram


def start_posture(scenario: Scenario) -> Array:
    """Return q (6,) at t = 0: `q0`, or where the first reference is."""
    if scenario.q0 is not None:
        return np.array(scenario.q0, dtype=np.float64)
    if isinstance(scenario.operator, JointMotion):
        return scenario.operator.start_state()[:6]
    command = initial_command(scenario.operator.mapping)
    return first_posture(scenario.inverse_kinematics, command, scenario.seed)


def _add_plant(
    builder: DiagramBuilder, scenario: Scenario, q_start: Array
) -> tuple[MultibodyPlant, SceneGraph]:
    config = MultibodyPlantConfig(time_step=scenario.time_step)
    plant, scene_graph = AddMultibodyPlant(config, builder)
    plant.set_name("plant")
    scene_graph.set_name("scene_graph")
    add_scara(plant)
    add_walls(plant, scene_graph, scenario.environment)
    plant.Finalize()
    plant.SetDefaultPositions(q_start)
    return plant, scene_graph


def _add_contact(builder: DiagramBuilder, scenario: Scenario, plant: MultibodyPlant) -> Signals:
    contact = builder.AddNamedSystem(
        "contact", ImpedanceContact(scenario.environment, scenario.time_step)
    )
    builder.Connect(plant.get_state_output_port(), contact.GetInputPort("state"))
    builder.Connect(
        contact.GetOutputPort("generalized_force"),
        plant.get_applied_generalized_force_input_port(),
    )
    return dict(_outputs(contact))


def _add_joint_motion(builder: DiagramBuilder, motion: JointMotion) -> Signals:
    source = builder.AddNamedSystem("joint_motion", JointMotionSource(motion))
    return dict(_outputs(source))


def _add_teleoperation(
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
    uplink = builder.AddNamedSystem("uplink", SignalDelay(channel.up, command, period))
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
        **dict(_outputs(joystick)),
        **dict(_outputs(mapping)),
        **dict(_outputs(kinematics)),
        "delay_up": uplink.GetOutputPort("delay"),
    }
    if "f_env_on_tool_W" in signals:
        downlink = builder.AddNamedSystem(
            "downlink", SignalDelay(channel.down, np.zeros(3), period)
        )
        haptics = builder.AddNamedSystem("haptics", HapticOutput(scenario.haptics, device))
        builder.Connect(signals["f_env_on_tool_W"], downlink.get_input_port())
        builder.Connect(downlink.GetOutputPort("signal_received"), haptics.get_input_port())
        made["f_haptic"] = downlink.GetOutputPort("signal_received")
        made["delay_down"] = downlink.GetOutputPort("delay")
        made["rumble"] = haptics.GetOutputPort("rumble")
    return made


def _slow_signals(scenario: Scenario) -> dict[str, float]:
    """Return the periods [s] of the signals that change less often than every time step."""
    if isinstance(scenario.operator, JointMotion):
        return {}
    return {"joystick_axes": scenario.operator.sample_period, "rumble": scenario.haptics.period}


def _outputs(system: System) -> Iterator[tuple[str, OutputPort]]:
    for index in range(system.num_output_ports()):
        port = system.get_output_port(index)
        yield port.get_name(), port
