"""The wiring of a bilateral teleoperation: a master that can be pushed, and its coupling.

::

    master -> coupling_master -> uplink -> coupling_slave -> inverse_kinematics -> (controller)
       ^        |        ^                   |   ^   ^               |
       '--------'        '---- downlink <----'   |   '---------------'  motion_limited
                                                 '-- f_env_on_tool_W <- (contact)
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import DiagramBuilder, System
from pydrake.systems.primitives import ConstantVectorSource

from scara_drake.ik.system import InverseKinematicsSystem
from scara_drake.operator.device_encoder import DeviceEncoder
from scara_drake.operator.master import SimulatedMaster
from scara_drake.wiring import Signals, link_signals, outputs

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
    far = builder.AddNamedSystem("coupling_slave", coupling.make_slave(period, first, bandwidth))
    seed = scenario.seed_of("inverse_kinematics")
    kinematics = builder.AddNamedSystem(
        "inverse_kinematics",
        InverseKinematicsSystem(scenario.inverse_kinematics, first, q_start, seed, period),
    )
    exchange = coupling.exchange()
    uplink, downlink = (
        builder.AddNamedSystem(
            name,
            scenario.channel.link(direction).make_system(
                np.zeros(size), period, scenario.seed_of(name)
            ),
        )
        for name, direction, size in (
            ("uplink", "up", exchange.up_size),
            ("downlink", "down", exchange.down_size),
        )
    )
    f_env_on_tool_W = signals.get("f_env_on_tool_W")
    if f_env_on_tool_W is None:
        free = builder.AddNamedSystem("free_space", ConstantVectorSource(np.zeros(3)))
        f_env_on_tool_W = free.get_output_port()

    def connect(source: System, output: str, target: System, name: str) -> None:
        builder.Connect(source.GetOutputPort(output), target.GetInputPort(name))

    connect(near, "f_master", device, "f_master")
    builder.Connect(motion, near.GetInputPort("motion_master"))
    connect(near, "packet_to_slave", uplink, "signal_sent")
    connect(uplink, "signal_received", far, "packet_from_master")
    connect(far, "packet_to_master", downlink, "signal_sent")
    connect(downlink, "signal_received", near, "packet_from_slave")
    builder.Connect(f_env_on_tool_W, far.GetInputPort("f_env_on_tool_W"))
    connect(kinematics, "motion_limited", far, "motion_limited")
    connect(far, "tool_command", kinematics, "tool_command")

    made: Signals = {}
    for system in (device, *shown, near, far, kinematics):
        made |= dict(outputs(system))
    made["tool_command_received"] = made.pop("tool_command")
    return signals | made | link_signals(uplink, "up") | link_signals(downlink, "down")
