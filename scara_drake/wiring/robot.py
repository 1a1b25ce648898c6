"""The wiring of a supervised robot, from the operator's command to the references and back.

::

    tool_command, operator_status -> command_frame -> uplink -> robot_supervisor
    robot_supervisor, link_watch, arm_watch -> inverse_kinematics -> robot_report
    robot_report -> downlink -> report_split -> f_haptic, and whole to the operator's supervisor
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import DiagramBuilder, OutputPort
from pydrake.systems.primitives import ConstantVectorSource

from scara_drake.ik.system import InverseKinematicsSystem
from scara_drake.safety import State
from scara_drake.supervision.arm_watch import ArmWatch
from scara_drake.supervision.config import Supervision
from scara_drake.supervision.energy import ChannelEnergy
from scara_drake.supervision.frames import (
    CommandFramePacker,
    CommandFrameSplitter,
    RobotReportPacker,
    RobotReportSplitter,
)
from scara_drake.supervision.link_watch import LinkWatch
from scara_drake.supervision.robot import RobotSupervisor
from scara_drake.vectors import (
    COMMAND_FRAME,
    ROBOT_REPORT,
    SUPERVISOR_STATUS,
    TOOL_COMMAND,
    pose_vector,
)
from scara_drake.wiring import Signals, connect_by_name, outputs
from scara_drake.wiring.feeling import add_supervised_feeling
from scara_drake.wiring.live import add_live_delay
from scara_drake.wiring.radio import add_shadow

if TYPE_CHECKING:
    from scara_drake.operator.devices import Device
    from scara_drake.scenario import Scenario

Array = NDArray[np.float64]

# What the watch over the arm sees of parts that are added after it.
AFTERWARDS = ("state", "actuation", "saturation")


def add_supervised_remote(
    builder: DiagramBuilder,
    scenario: Scenario,
    command: Array,
    q_start: Array,
    signals: Signals,
    device: Device | None = None,
) -> Signals:
    """Add what `tool_command` passes up to the references, and the report back, supervised.

    An operator without a supervisor of his own, such as a program, is engaged from the start.

    Args:
        builder: of the Diagram.
        scenario: of it, with `supervision`.
        command: (8,) the first one, from which the channel starts.
        q_start: (6,) where the arm starts.
        signals: so far.
        device: which haptics shake, if there is one.
    """
    signals = signals | _uplink(builder, scenario, command, signals)
    signals = signals | _robot(builder, scenario, command, q_start, signals)
    signals = signals | _downlink(builder, scenario, q_start, signals)
    signals = signals | add_supervised_feeling(builder, scenario, signals, device)
    if "f_env_on_tool_W" in signals and "tool_command" in signals:
        energy = builder.AddNamedSystem(
            "channel_energy", ChannelEnergy(command, scenario.time_step)
        )
        signals = signals | connect_by_name(builder, energy, signals)
        watch = builder.GetSubsystemByName("link_watch")
        builder.Connect(signals["channel_energy"], watch.GetInputPort("channel_energy"))
    return signals


def add_watch_over_efforts(
    builder: DiagramBuilder, scenario: Scenario, q_start: Array, signals: Signals
) -> Signals:
    """Let a supervised robot see sensors and efforts, and restart its controller if need be."""
    if not builder.HasSubsystemNamed("arm_watch"):
        return signals
    watch = builder.GetSubsystemByName("arm_watch")
    seen = signals | {"state": signals["state_sensed"]}
    for name in AFTERWARDS:
        if name in seen:
            builder.Connect(seen[name], watch.GetInputPort(name))
    controller = builder.GetSubsystemByName("controller")
    if controller.HasInputPort("engaged"):
        builder.Connect(signals["drives_engaged"], controller.GetInputPort("engaged"))
    return signals


def _uplink(
    builder: DiagramBuilder, scenario: Scenario, command: Array, signals: Signals
) -> Signals:
    """Pack the command with the state of its operator, and lead both over the channel."""
    period, link = scenario.time_step, scenario.channel.link("up")
    made: Signals = {}
    if "command_frame" not in signals:
        packer = builder.AddNamedSystem("command_frame", CommandFramePacker())
        made = connect_by_name(builder, packer, signals | _status(builder, signals))
    first = COMMAND_FRAME.pack(tool_command=command, state=float(State.IDLE), engagements=0.0)
    uplink = builder.AddNamedSystem(
        "uplink", link.make_system(first, period, scenario.seed_of("uplink"))
    )
    add_shadow(builder, link, uplink, signals)
    builder.Connect((signals | made)["command_frame"], uplink.GetInputPort("signal_sent"))
    made["command_frame_received"], told = add_live_delay(
        builder, "up", uplink, first, period, signals
    )
    splitter = builder.AddNamedSystem("command_split", CommandFrameSplitter())
    made |= connect_by_name(builder, splitter, made)
    watch = builder.AddNamedSystem("link_watch", LinkWatch(_of(scenario).robot, period))
    for port, name in (("age_of_information", "age"), ("delay", "delay")):
        if uplink.HasOutputPort("age_of_information"):
            builder.Connect(uplink.GetOutputPort(port), watch.GetInputPort(name))
    return made | dict(outputs(watch)) | told


def _status(builder: DiagramBuilder, signals: Signals) -> Signals:
    """Return the status of the operator's supervisor, or of one who is engaged."""
    if "operator_status" in signals:
        return {}
    engaged = SUPERVISOR_STATUS.pack(
        state=float(State.ACTIVE), reason=0.0, engagements=1.0, faults=0.0
    )
    source = builder.AddNamedSystem("engaged", ConstantVectorSource(engaged))
    port: OutputPort = source.get_output_port()
    return {"operator_status": port}


def _robot(
    builder: DiagramBuilder, scenario: Scenario, command: Array, q_start: Array, signals: Signals
) -> Signals:
    """Add the supervisor, its watch over the arm, and the inverse kinematics that follows."""
    period, kinematics = scenario.time_step, scenario.inverse_kinematics
    start = TOOL_COMMAND.pack(
        p=pose_vector(q_start)[:3], quaternion=pose_vector(q_start)[3:], mast=q_start[0]
    )
    supervisor = builder.AddNamedSystem(
        "robot_supervisor", RobotSupervisor(_of(scenario).robot, kinematics, start, period)
    )
    watch = builder.AddNamedSystem("arm_watch", ArmWatch(_of(scenario).robot, start, period))
    seed = scenario.seed_of("inverse_kinematics")
    solver = builder.AddNamedSystem(
        "inverse_kinematics",
        InverseKinematicsSystem(kinematics, command, q_start, seed, period, restarts=True),
    )
    made = {**dict(outputs(supervisor)), **dict(outputs(watch)), **dict(outputs(solver))}
    seen = signals | made
    connect_by_name(builder, supervisor, seen)
    connect_by_name(
        builder,
        watch,
        {name: port for name, port in seen.items() if name not in AFTERWARDS},
    )
    connect_by_name(builder, solver, seen | {"tool_command": made["tool_command_supervised"]})
    return made


def _downlink(
    builder: DiagramBuilder, scenario: Scenario, q_start: Array, signals: Signals
) -> Signals:
    """Lead the report of the robot over the channel, and take the force out of it."""
    period, link = scenario.time_step, scenario.channel.link("down")
    packer = builder.AddNamedSystem(
        "robot_report", RobotReportPacker(scenario.inverse_kinematics, period)
    )
    made = connect_by_name(builder, packer, signals)
    start = TOOL_COMMAND.pack(
        p=pose_vector(q_start)[:3], quaternion=pose_vector(q_start)[3:], mast=q_start[0]
    )
    first = ROBOT_REPORT.zeros(tool_command=start)
    downlink = builder.AddNamedSystem(
        "downlink", link.make_system(first, period, scenario.seed_of("downlink"))
    )
    add_shadow(builder, link, downlink, signals)
    builder.Connect(made["robot_report"], downlink.GetInputPort("signal_sent"))
    made["robot_report_received"], told = add_live_delay(
        builder, "down", downlink, first, period, signals
    )
    splitter = builder.AddNamedSystem("report_split", RobotReportSplitter())
    made |= connect_by_name(builder, splitter, made)
    return made | told


def _of(scenario: Scenario) -> Supervision:
    return scenario.supervision or Supervision()
