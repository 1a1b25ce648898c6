"""Layouts of what all couplings have: packets, motions, meters, constants and memory by name."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from scara_drake.common.layout import REST, Cell, Layout

Array = NDArray[np.float64]


class Packet(NamedTuple):
    """What crosses the channel.

    Attributes:
        number: 1 for the first, rising; 0 before anything was sent.
        payload: as the kind lays it out.
    """

    number: Cell
    payload: Array


class Motion(NamedTuple):
    """Motion of a device or of the tool: position [m] and velocity [m/s], each (3,)."""

    x: Array
    v: Array


class Meters(NamedTuple):
    """Energy that has come into a port and gone out of it [J], each (3,) and never falling."""

    e_in: Array
    e_out: Array


class MasterConstants(NamedTuple):
    """Constants of the master's end.

    Attributes:
        period: [s].
        actuator_limit: of the device [N].
        gains: of the kind.
    """

    period: float
    actuator_limit: float
    gains: Array


class SlaveConstants(NamedTuple):
    """Constants of the slave's end; impedances and forces in the master's units.

    Attributes:
        period: [s].
        bandwidth: of the limiter that follows the commands [1/s].
        hold: silence up to which the newest packet stands, as one that says the same is not sent
            [s]; 0 where every packet is sent.
        mass: of the virtual tool [kg].
        grip: damping of that mass to the ground in firm contact [N s/m].
        firm: force from which contact is firm [N].
        position_scale: way of the tool over that of the device.
        force_scale: force at the device over that at the tool.
        p_first: where the tool is commanded at first (3,) [m].
        gains: of the kind.
    """

    period: float
    bandwidth: float
    hold: float
    mass: float
    grip: float
    firm: float
    position_scale: float
    force_scale: float
    p_first: Array
    gains: Array


class MasterMemory(NamedTuple):
    """Memory of the master's end.

    Attributes:
        x: of the device at the last tick (3,) [m].
        f: of the device, within its limit, at the last tick (3,) [N].
        rest: the newest packet, then the memory of the kind.
    """

    x: Array
    f: Array
    rest: Array


class Held(NamedTuple):
    """A received velocity that is held.

    Attributes:
        v: (3,) [m/s].
        silent: ticks since it arrived.
    """

    v: Array
    silent: Cell


PACKET = Layout(Packet, number=(), payload=REST)
MOTION = Layout(Motion, x=3, v=3)
METERS = Layout(Meters, e_in=3, e_out=3)
MASTER_CONSTANTS = Layout(MasterConstants, gains=REST)
SLAVE_CONSTANTS = Layout(SlaveConstants, p_first=3, gains=REST)
HELD = Layout(Held, v=3, silent=())
MASTER_MEMORY = Layout(MasterMemory, x=3, f=3, rest=REST)
packet_of, motion_of, meters_of = PACKET.reader(), MOTION.reader(), METERS.reader()
master_constants_of, slave_constants_of = MASTER_CONSTANTS.reader(), SLAVE_CONSTANTS.reader()
master_memory_of, held_of = MASTER_MEMORY.reader(), HELD.reader()
