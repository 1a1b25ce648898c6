"""The wiring of a bilateral teleoperation: a master that can be pushed, and its coupling.

::

    master -> coupling_master -> uplink -> coupling_slave -> inverse_kinematics -> (controller)
       ^        |        ^                   |   ^   ^               |
       '--------'        '---- downlink <----'   |   '---------------'  motion_limited
                                                 '-- f_env_on_tool_W <- (contact)
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import DiagramBuilder, OutputPort, System
from pydrake.systems.primitives import ConstantVectorSource

from scara_drake.channel.links import Channel
from scara_drake.coupling.ends import Coupling
from scara_drake.ik.system import InverseKinematics, InverseKinematicsSystem
from scara_drake.operator.master import Master, SimulatedMaster
from scara_drake.wiring import Signals, link_signals, outputs

Array = NDArray[np.float64]


def add_bilateral(
    builder: DiagramBuilder,
    master: Master,
    coupling: Coupling,
    channel: Channel,
    inverse_kinematics: InverseKinematics,
    q_start: Array,
    f_env_on_tool_W: OutputPort | None = None,
    period: float = 1e-3,
    seeds: tuple[int, int, int] = (0, 1, 2),
) -> Signals:
    """Add the master, the coupling, the channel and the inverse kinematics, and connect them.

    Args:
        builder: receives the systems.
        master: the operator.
        coupling: of master and slave.
        channel: its links carry the packets.
        inverse_kinematics: its `bandwidth` tells the coupling how commands are followed.
        q_start: (6,), where `master.first_command()` has the tool.
        f_env_on_tool_W: force of the environment (3) [N]; None is free space.
        period: of every block [s].
        seeds: of the uplink, the downlink and the inverse kinematics.

    Returns:
        The output ports by the name of the signal; `state_desired` goes to the controller.
    """
    first = master.first_command()
    device = builder.AddNamedSystem("master", SimulatedMaster(master, period))
    near = builder.AddNamedSystem(
        "coupling_master", coupling.make_master(period, master.actuator_limit)
    )
    far = builder.AddNamedSystem(
        "coupling_slave", coupling.make_slave(period, first, inverse_kinematics.bandwidth)
    )
    kinematics = builder.AddNamedSystem(
        "inverse_kinematics",
        InverseKinematicsSystem(inverse_kinematics, first, q_start, seeds[2], period),
    )
    exchange = coupling.exchange()
    uplink = builder.AddNamedSystem(
        "uplink", channel.link("up").make_system(np.zeros(exchange.up_size), period, seeds[0])
    )
    downlink = builder.AddNamedSystem(
        "downlink", channel.link("down").make_system(np.zeros(exchange.down_size), period, seeds[1])
    )
    if f_env_on_tool_W is None:
        free = builder.AddNamedSystem("free_space", ConstantVectorSource(np.zeros(3)))
        f_env_on_tool_W = free.get_output_port()

    def connect(source: System, output: str, target: System, name: str) -> None:
        builder.Connect(source.GetOutputPort(output), target.GetInputPort(name))

    connect(near, "f_master", device, "f_master")
    connect(device, "motion_master", near, "motion_master")
    connect(near, "packet_to_slave", uplink, "signal_sent")
    connect(uplink, "signal_received", far, "packet_from_master")
    connect(far, "packet_to_master", downlink, "signal_sent")
    connect(downlink, "signal_received", near, "packet_from_slave")
    builder.Connect(f_env_on_tool_W, far.GetInputPort("f_env_on_tool_W"))
    connect(kinematics, "motion_limited", far, "motion_limited")
    connect(far, "tool_command", kinematics, "tool_command")

    made: Signals = {}
    for system in (device, near, far, kinematics):
        made |= dict(outputs(system))
    made["tool_command_received"] = made.pop("tool_command")
    return made | link_signals(uplink, "up") | link_signals(downlink, "down")
