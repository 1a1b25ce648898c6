"""The wiring of a scenario, and nothing else: it reads like the block diagram.

::

    joystick -> mapping -> uplink -> inverse_kinematics -> governor -> controller -> drives -> plant
        ^                                                                                      |  ^
        '--- haptics <----------------- downlink <----------------- contact <-----------------'--'
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
from pydrake.systems.primitives import Adder

from scara_drake.bilateral import add_bilateral
from scara_drake.control.contact_estimate import ContactForceEstimator
from scara_drake.environment import ImpedanceContact, add_surfaces
from scara_drake.ik.system import InverseKinematicsSystem, first_posture
from scara_drake.recording import add_recorder
from scara_drake.reference import JointMotion, JointMotionSource
from scara_drake.robot import add_scara
from scara_drake.scenario import Scenario
from scara_drake.teleop.haptics import HapticOutput
from scara_drake.teleop.kinesthetic import KinestheticOutput
from scara_drake.teleop.mapping import JoystickToPose, initial_command
from scara_drake.teleop.master import Master
from scara_drake.teleop.operator import Joystick
from scara_drake.teleop.signal_delay import SignalDelay
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
    signals: Signals = {"state": plant.get_state_output_port()}
    if scenario.environment.surfaces:
        signals |= _add_contact(builder, scenario, plant)
    operator = scenario.operator
    if isinstance(operator, JointMotion):
        signals |= _add_joint_motion(builder, operator)
    elif isinstance(operator, Master):
        signals |= _add_bilateral(builder, scenario, operator, q_start, signals)
    else:
        signals |= _add_teleoperation(builder, scenario, operator, q_start, signals)
    signals |= _add_control(builder, scenario, q_start, signals)
    signals |= _add_drives(builder, scenario, plant, signals)
    _add_forces(builder, scenario, plant, signals)

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
    if isinstance(scenario.operator, Master):
        command = scenario.operator.first_command()
    else:
        command = initial_command(scenario.operator.mapping)
    return first_posture(scenario.inverse_kinematics, command, scenario.seed)


def _add_plant(
    builder: DiagramBuilder, scenario: Scenario, q_start: Array
) -> tuple[MultibodyPlant, SceneGraph]:
    config = MultibodyPlantConfig(time_step=scenario.time_step)
    plant, scene_graph = AddMultibodyPlant(config, builder)
    plant.set_name("plant")
    scene_graph.set_name("scene_graph")
    add_scara(plant, scenario.robot)
    add_surfaces(plant, scene_graph, scenario.environment)
    plant.Finalize()
    plant.SetDefaultPositions(q_start)
    return plant, scene_graph


def _add_contact(builder: DiagramBuilder, scenario: Scenario, plant: MultibodyPlant) -> Signals:
    contact = builder.AddNamedSystem(
        "contact", ImpedanceContact(scenario.environment, scenario.time_step)
    )
    builder.Connect(plant.get_state_output_port(), contact.GetInputPort("state"))
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
        **dict(_outputs(joystick)),
        **dict(_outputs(mapping)),
        **dict(_outputs(kinematics)),
        "tool_command_received": uplink.GetOutputPort("signal_received"),
        **_link_signals(uplink, "up"),
    }
    if "f_env_on_tool_W" in signals:
        downlink = builder.AddNamedSystem(
            "downlink",
            channel.link("down").make_system(np.zeros(3), period, scenario.stream(1)),
        )
        haptics = builder.AddNamedSystem("haptics", HapticOutput(scenario.haptics, device))
        builder.Connect(signals["f_env_on_tool_W"], downlink.get_input_port())
        builder.Connect(downlink.GetOutputPort("signal_received"), haptics.get_input_port())
        made |= _link_signals(downlink, "down")
        made["f_haptic"] = downlink.GetOutputPort("signal_received")
        made["rumble"] = haptics.GetOutputPort("rumble")
        if scenario.kinesthetic is not None:
            device_force = KinestheticOutput(scenario.kinesthetic, period)
            made["f_kinesthetic"] = _chain(builder, "kinesthetic", device_force, made["f_haptic"])
    return made


def _add_bilateral(
    builder: DiagramBuilder, scenario: Scenario, master: Master, q_start: Array, signals: Signals
) -> Signals:
    """Add a master that can be pushed, its coupling, the channel and the inverse kinematics."""
    made = add_bilateral(
        builder,
        master,
        scenario.coupling,
        scenario.channel,
        scenario.inverse_kinematics,
        q_start,
        signals.get("f_env_on_tool_W"),
        scenario.time_step,
        (scenario.stream(0), scenario.stream(1), scenario.seed),
    )
    made["tool_command_received"] = made.pop("tool_command")
    return made


def _link_signals(link: System, direction: str) -> Signals:
    """Return what a link tells about itself: its delay, and of packets the age of information."""
    names = {"delay": f"delay_{direction}", "age_of_information": f"age_{direction}"}
    return {names[name]: port for name, port in _outputs(link) if name in names}


def _add_control(
    builder: DiagramBuilder, scenario: Scenario, q_start: Array, signals: Signals
) -> Signals:
    """Add the controller, what it measures with, and what its references pass through."""
    period, delays = scenario.time_step, scenario.process_delay
    at_rest = np.concatenate([q_start, np.zeros(6)])
    operator = scenario.operator
    first_reference = operator.start_state() if isinstance(operator, JointMotion) else at_rest
    controller = builder.AddNamedSystem("controller", scenario.controller.make_system(period))
    made: Signals = dict(_outputs(controller))

    state, desired = signals["state"], signals["state_desired"]
    if scenario.drives.encoder is not None:
        encoder = scenario.drives.encoder.make_system(period, scenario.stream(2))
        state = _chain(builder, "encoder", encoder, state)
    if delays is not None and delays.measurement is not None:
        state = _chain(
            builder, "measurement_delay", SignalDelay(delays.measurement, at_rest, period), state
        )
    if delays is not None and delays.reference is not None:
        desired = _chain(
            builder,
            "reference_delay",
            SignalDelay(delays.reference, first_reference, period),
            desired,
        )
    if scenario.governor is not None:
        governor = builder.AddNamedSystem("governor", scenario.governor.make_system(period))
        made |= _connect(builder, governor, {**made, "state": state, "state_desired": desired})
        desired = made["state_desired_governed"]
    builder.Connect(state, controller.GetInputPort("state"))
    builder.Connect(desired, controller.GetInputPort("state_desired"))
    if "perturbation_estimate" in made:
        estimator = builder.AddNamedSystem("contact_estimate", ContactForceEstimator())
        made |= _connect(builder, estimator, {**made, "state": state})

    return made


def _add_drives(
    builder: DiagramBuilder, scenario: Scenario, plant: MultibodyPlant, signals: Signals
) -> Signals:
    """Lead the controller's effort through the drives to the plant; return what is on the way."""
    period, delays, drives = scenario.time_step, scenario.process_delay, scenario.drives
    made: Signals = {}
    actuation = signals["actuation"]
    if delays is not None and delays.actuation is not None:
        delay = SignalDelay(delays.actuation, np.zeros(6), period)
        actuation = _chain(builder, "actuation_delay", delay, actuation)
    if drives.lag is not None:
        actuation = _chain(builder, "actuator_lag", drives.lag.make_system(period), actuation)
        made["actuation_delivered"] = actuation
    builder.Connect(actuation, plant.get_actuation_input_port())
    if drives.friction is not None:
        friction = drives.friction.make_system(period)
        made["friction_force"] = _chain(builder, "joint_friction", friction, signals["state"])
    return made


def _add_forces(
    builder: DiagramBuilder, scenario: Scenario, plant: MultibodyPlant, signals: Signals
) -> None:
    """Lead the sum of the forces on the joints, beside those of the drives, to the plant."""
    names = ("generalized_force", "friction_force")
    forces = [signals[name] for name in names if name in signals]
    if scenario.perturbation is not None:
        source = scenario.perturbation.make_system()
        forces.append(builder.AddNamedSystem("perturbation", source).get_output_port())
    if len(forces) > 1:
        total = builder.AddNamedSystem("joint_forces", Adder(len(forces), 6))
        for index, force in enumerate(forces):
            builder.Connect(force, total.get_input_port(index))
        forces = [total.get_output_port()]
    if forces:
        builder.Connect(forces[0], plant.get_applied_generalized_force_input_port())


def _connect(builder: DiagramBuilder, system: System, signals: Signals) -> Signals:
    """Connect the inputs of a system to the signals of their names; return its outputs."""
    for name, port in signals.items():
        if system.HasInputPort(name):
            builder.Connect(port, system.GetInputPort(name))
    return dict(_outputs(system))


def _chain(builder: DiagramBuilder, name: str, system: System, source: OutputPort) -> OutputPort:
    """Add a system with one input; return its first output."""
    builder.AddNamedSystem(name, system)
    builder.Connect(source, system.get_input_port(0))
    return system.get_output_port(0)


def _slow_signals(scenario: Scenario) -> dict[str, float]:
    """Return the periods [s] of the signals that change less often than every time step."""
    if not isinstance(scenario.operator, Joystick):
        return {}
    return {"joystick_axes": scenario.operator.sample_period, "rumble": scenario.haptics.period}


def _outputs(system: System) -> Iterator[tuple[str, OutputPort]]:
    for index in range(system.num_output_ports()):
        port = system.get_output_port(index)
        yield port.get_name(), port
