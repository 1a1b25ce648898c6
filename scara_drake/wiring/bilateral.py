"""The wiring of a bilateral teleoperation: a master that can be pushed, and its coupling.

::

    master -> coupling_master -> uplink -> coupling_slave -> inverse_kinematics -> (controller)
       ^        |        ^                   |   ^   ^               |
       '--------'        '---- downlink <----'   |   '---------------'  motion_limited
                                                 '-- f_env_on_tool_W <- (contact)

Where the scenario has a codec, one before each link says which packets that sends.
With a policy, the operator's hand is moved by `operator`, who has the picture that comes back over
a link of its own, and what is local at the master::

    operator -> master      operator <- view <- tool_position <- (plant)
       ^----------'
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import DiagramBuilder, OutputPort, System
from pydrake.systems.primitives import ConstantVectorSource

from scara_drake.channel.codec import Codec
from scara_drake.channel.links import received_by
from scara_drake.channel.packets import Packets
from scara_drake.ik.system import InverseKinematicsSystem
from scara_drake.kinematics import forward_kinematics
from scara_drake.operator.device_encoder import DeviceEncoder
from scara_drake.operator.master import SimulatedMaster
from scara_drake.operator.policy import OperatorPolicy
from scara_drake.wiring import Signals, connect_by_name, link_signals, outputs
from scara_drake.wiring.trainee import SEEDS, add_view

if TYPE_CHECKING:
    from scara_drake.operator.master import Master
    from scara_drake.scenario import Scenario

Array = NDArray[np.float64]


COMMAND_TICKS = 3  # master, uplink and slave, to the command that the kinematics reads
FORCE_TICKS = 3  # slave, downlink and master, from the force of the contact to that of the device
DEVICE_TICKS = 1  # until that force has moved the device


def own_latency(scenario: Scenario) -> float:
    """Return the delay [s] that the loop has there and back beside that of its channel.

    A tick for each block that a signal crosses, and the lag 2 / bandwidth of the limiter of the
    commands, which is the larger part. A coupling that is not passive has to bear it, too.
    """
    ticks = COMMAND_TICKS + FORCE_TICKS + DEVICE_TICKS
    return ticks * scenario.time_step + 2.0 / scenario.inverse_kinematics.bandwidth


def add_bilateral(
    builder: DiagramBuilder, scenario: Scenario, q_start: Array, signals: Signals
) -> Signals:
    """Add the master, the coupling, the channel and the inverse kinematics, and connect them.

    Without a surface in the scenario the tool is in free space, and the force on it is zero.
    """
    master: Master = scenario.operator  # type: ignore[assignment]  # the table has chosen it
    coupling, period, first = scenario.coupling, scenario.time_step, master.first_command()
    hardware = master.hardware()
    coupling = coupling.within(hardware.stiffness, hardware.damping)
    device = builder.AddNamedSystem("master", SimulatedMaster(master, period))
    motion, shown = device.GetOutputPort("motion_master"), []
    if hardware.resolution > 0.0:
        encoder = builder.AddNamedSystem("device_encoder", DeviceEncoder(master, period))
        builder.Connect(motion, encoder.get_input_port())
        motion, shown = encoder.get_output_port(), [encoder]
    near = builder.AddNamedSystem("coupling_master", coupling.make_master(period, hardware.force))
    # The bandwidth tells the coupling how its commands are followed.
    bandwidth = scenario.inverse_kinematics.bandwidth
    codec = scenario.channel.codec
    hold = 0.0 if codec is None else codec.keep_alive
    far = builder.AddNamedSystem(
        "coupling_slave", coupling.make_slave(period, first, bandwidth, hold)
    )
    seed = scenario.seed_of("inverse_kinematics")
    kinematics = builder.AddNamedSystem(
        "inverse_kinematics",
        InverseKinematicsSystem(scenario.inverse_kinematics, first, q_start, seed, period),
    )
    uplink = _add_link(builder, scenario, "up", near.GetOutputPort("packet_to_slave"))
    downlink = _add_link(builder, scenario, "down", far.GetOutputPort("packet_to_master"))
    f_env_on_tool_W = signals.get("f_env_on_tool_W")
    if f_env_on_tool_W is None:
        free = builder.AddNamedSystem("free_space", ConstantVectorSource(np.zeros(3)))
        f_env_on_tool_W = free.get_output_port()

    def connect(source: System, output: str, target: System, name: str) -> None:
        builder.Connect(source.GetOutputPort(output), target.GetInputPort(name))

    connect(near, "f_master", device, "f_master")
    builder.Connect(motion, near.GetInputPort("motion_master"))
    connect(uplink, "signal_received", far, "packet_from_master")
    connect(downlink, "signal_received", near, "packet_from_slave")
    builder.Connect(f_env_on_tool_W, far.GetInputPort("f_env_on_tool_W"))
    connect(kinematics, "motion_limited", far, "motion_limited")
    connect(far, "tool_command", kinematics, "tool_command")

    made: Signals = {}
    for system in (device, *shown, near, far, kinematics):
        made |= dict(outputs(system))
    made["tool_command_received"] = made.pop("tool_command")
    if master.policy is not None:
        made |= _add_policy(builder, scenario, device, q_start, signals)
    return signals | made | link_signals(uplink, "up") | link_signals(downlink, "down")


def _add_link(
    builder: DiagramBuilder, scenario: Scenario, direction: str, packet: OutputPort
) -> System:
    """Add the link "up" or "down" of some packets, behind a codec where there is one."""
    name, period, size = f"{direction}link", scenario.time_step, packet.size()
    exchange, codec = scenario.coupling.exchange(), scenario.channel.codec
    link = received_by(scenario.channel.link(direction), exchange.uses_late)
    arguments = np.zeros(size), period, scenario.seed_of(name)
    if codec is None or not isinstance(link, Packets):
        carrier = builder.AddNamedSystem(name, link.make_system(*arguments))
    else:
        carrier = builder.AddNamedSystem(name, link.make_system(*arguments, selective=True))
        felt = exchange.felt(direction)
        chooser = builder.AddNamedSystem(
            f"codec_{direction}", Codec(codec, direction, felt, size, period, link.send_period)
        )
        builder.Connect(packet, chooser.GetInputPort("packet"))
        builder.Connect(chooser.GetOutputPort("transmit"), carrier.GetInputPort("transmit"))
        packet = chooser.GetOutputPort("packet_sent")
    builder.Connect(packet, carrier.GetInputPort("signal_sent"))
    return carrier


def _add_policy(
    builder: DiagramBuilder, scenario: Scenario, device: System, q_start: Array, signals: Signals
) -> Signals:
    """Add the operator who reacts: he has the picture and its age, and what is local."""
    master: Master = scenario.operator  # type: ignore[assignment]  # the table has chosen it
    seen = add_view(builder, scenario, q_start, signals)
    view: System = seen.get_system()  # type: ignore[assignment]  # the stubs know no type
    mind = OperatorPolicy(
        master.policy,  # type: ignore[arg-type]  # there is one
        forward_kinematics(q_start)[:3, 3],
        scenario.coupling.position_scale,
        master.hand_stiffness,
        scenario.time_step,
        SEEDS + scenario.seed % SEEDS,
    )
    operator = builder.AddNamedSystem("operator", mind)
    told = link_signals(view, "view")
    known = {"tool_seen": seen, "age_seen": told.get("age_view", told["delay_view"])}
    connect_by_name(builder, operator, known | dict(outputs(device)))
    builder.Connect(operator.GetOutputPort("hand_wanted"), device.GetInputPort("hand_wanted"))
    return {
        "tool_seen": seen,
        "policy_state": operator.GetOutputPort("policy_state"),
    } | {name: port for name, port in told.items() if name == "age_view"}
