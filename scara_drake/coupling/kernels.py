"""What the laws of all couplings share, inside kernels.

Everything is per axis of W and in the master's units: a position of the slave is its way from the
first command over `position_scale`, a force that of the tool times `force_scale`. Forces are
positive where they resist motion in the positive direction, so force times velocity is the power
that the hand, or the command, puts in.

A packet is its number and a payload. The receiver keeps the highest number it has seen, so loss,
reordering and a channel that runs backwards cost performance only; while nothing arrives it holds.

A law at the master begins with `master_tick`, one at the slave with `slave_tick`: they receive,
number the packet to send, and name what the law reads and writes.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.coupling.layouts import (
    MasterMemory,
    SlaveConstants,
    held_of,
    master_constants_of,
    master_memory_of,
    meters_of,
    motion_of,
    packet_of,
    slave_constants_of,
)

Array = NDArray[np.float64]


class MasterTick(NamedTuple):
    """What a law at the master reads and writes.

    Attributes:
        period: [s].
        x: of the device (3,) [m].
        v: of the device (3,) [m/s].
        way: of the device since the last tick (3,) [m].
        f_acted: force that the device had over that way (3,) [N].
        f_acting: force that it has from now to the next tick (3,) [N].
        gains: constants of the kind.
        memory: of the kind.
        newest: payload of the newest packet.
        sent: payload to send.
    """

    period: float
    x: Array
    v: Array
    way: Array
    f_acted: Array
    f_acting: Array
    gains: Array
    memory: Array
    newest: Array
    sent: Array


class SlaveTick(NamedTuple):
    """What a law at the slave reads and writes, in the master's units.

    Attributes:
        period: [s].
        x: of the tool that the joints are truly asked for (3,) [m].
        v: of the same (3,) [m/s].
        f_env: of the environment (3,) [N].
        progress: by how many numbers the newest packet is newer than the last, 0 if none came.
        end: constants of the end.
        gains: constants of the kind.
        memory: of the kind.
        newest: payload of the newest packet.
        sent: payload to send.
    """

    period: float
    x: Array
    v: Array
    f_env: Array
    progress: float
    end: SlaveConstants
    gains: Array
    memory: Array
    newest: Array
    sent: Array


@njit(cache=True)
def master_tick(
    motion_master: Array,
    packet_from_slave: Array,
    constants: Array,
    memory: Array,
    packet_to_slave: Array,
    f_master: Array,
    energy_master: Array,
) -> MasterTick:
    """Receive, meter the device, number the packet to send; return what the law needs."""
    end, own = master_constants_of(constants), master_memory_of(memory)
    device = motion_of(motion_master)
    newest = own.rest[: packet_from_slave.size]
    receive(packet_from_slave, newest)
    way, f_acted, f_acting = meter_device(
        device.x, f_master, end.actuator_limit, own, energy_master
    )
    sent = packet_of(packet_to_slave)
    sent.number[()] += 1.0
    return MasterTick(
        end.period,
        device.x,
        device.v,
        way,
        f_acted,
        f_acting,
        end.gains,
        own.rest[packet_from_slave.size :],
        packet_of(newest).payload,
        sent.payload,
    )


@njit(cache=True)
def slave_tick(
    packet_from_master: Array,
    f_env_on_tool_W: Array,
    motion_limited: Array,
    constants: Array,
    memory: Array,
    packet_to_master: Array,
) -> SlaveTick:
    """Receive, change to the master's units, number the packet to send; return what the law needs.

    The memory is the newest packet, then that of the kind.
    """
    end = slave_constants_of(constants)
    newest = memory[: packet_from_master.size]
    progress = receive(packet_from_master, newest)
    x, v, f_env = to_master_units(motion_limited, f_env_on_tool_W, end)
    sent = packet_of(packet_to_master)
    sent.number[()] += 1.0
    return SlaveTick(
        end.period,
        x,
        v,
        f_env,
        progress,
        end,
        end.gains,
        memory[packet_from_master.size :],
        packet_of(newest).payload,
        sent.payload,
    )


@njit(cache=True)
def receive(packet: Array, newest: Array) -> float:
    """Keep a packet in `newest` if it is newer; return by how many numbers, 0 if it is not."""
    progress = packet_of(packet).number[()] - packet_of(newest).number[()]
    if not progress > 0.0:
        return 0.0
    newest[:] = packet
    return progress


@njit(cache=True)
def meter(energy: Array, axis: int, work: float) -> None:
    """Add work [J] that an axis of a port took in, or gave if negative, to its meters (6,)."""
    meters = meters_of(energy)
    if work > 0.0:
        meters.e_in[axis] += work
    else:
        meters.e_out[axis] -= work


@njit(cache=True)
def meter_device(
    x: Array, f: Array, limit: float, last: MasterMemory, energy: Array
) -> tuple[Array, Array, Array]:
    """Meter the device's port: it has moved under the force that was commanded two ticks ago.

    The force now on the port acts over the period that begins, so the one before it moved the
    device here. The product is exact, see `master`. Return the way [m], the force over it and the
    force that acts next [N], each (3,).
    """
    way, f_acted, f_acting = np.empty(3), np.empty(3), np.empty(3)
    for i in range(3):
        way[i] = x[i] - last.x[i]
        f_acted[i] = last.f[i]
        f_acting[i] = min(max(f[i], -limit), limit)
        meter(energy, i, f_acted[i] * way[i])
        last.x[i] = x[i]
        last.f[i] = f_acting[i]
    return way, f_acted, f_acting


@njit(cache=True)
def given_out(f: float, v: float, period: float, ahead: float, turn: float) -> float:
    """Return the most energy [J] that a force can give out over a period, some periods ahead.

    Args:
        f: of the device over that period, positive resists [N].
        v: of the device now [m/s].
        period: [s].
        ahead: periods from now to the middle of that one.
        turn: fastest change of the velocity [m/s²].
    """
    along = math.copysign(v, f * v)
    return abs(f) * max(ahead * period * turn - along, 0.0) * period


@njit(cache=True)
def committed(axis: int, turn: float, s: MasterTick) -> float:
    """Return the most energy [J] that an axis of the device gives out until the next tick."""
    return given_out(s.f_acting[axis], s.v[axis], s.period, 0.5, turn)


@njit(cache=True)
def affordable_force(f: float, axis: int, left: float, turn: float, s: MasterTick) -> float:
    """Return a force [N] of the device, smaller where it could give out more than is left [J].

    A force that is commanded now acts from the next tick to the one after it, when the hand may
    have turned round. With a velocity that changes by no more than `turn` [m/s²], what the force
    that acts in the meantime gives out is bounded, and so is what this one does. So no hand of that
    kind ever takes more than is left.
    """
    left = max(left - committed(axis, turn, s), 0.0)
    most = given_out(f, s.v[axis], s.period, 1.5, turn)
    return f * left / most if most > left else f


@njit(cache=True)
def to_master_units(
    motion_limited: Array, f_env_on_tool_W: Array, end: SlaveConstants
) -> tuple[Array, Array, Array]:
    """Return position, velocity and resisting force (3,) of the tool in the master's units."""
    tool = motion_of(motion_limited)
    x, v, f_env = np.empty(3), np.empty(3), np.empty(3)
    for i in range(3):
        x[i] = (tool.x[i] - end.p_first[i]) / end.position_scale
        v[i] = tool.v[i] / end.position_scale
        f_env[i] = -end.force_scale * f_env_on_tool_W[i]
    return x, v, f_env


@njit(cache=True)
def command(axis: int, x: float, end: SlaveConstants, tool_command: Array) -> None:
    """Ask for a position [m] of an axis, in the master's units."""
    tool_command[axis] = end.p_first[axis] + end.position_scale * x


@njit(cache=True)
def admit(axis: int, f: float, s: SlaveTick, tool_command: Array) -> None:
    """Write the command with which the limiter moves the virtual mass: M v' = f - f_env - D v.

    The contact damping D grows with the force that is felt, up to a firm one. The limiter's
    velocity goes to half its bandwidth times the distance to the command, at twice the bandwidth.
    So v' is the net force over M where the command is ahead of the motion by 2 / bandwidth times
    v + v' / (2 bandwidth), of the period in which it is read. Whatever a limit takes away stays in
    the motion, from which the next command starts: nothing winds up.
    """
    end, v, f_env = s.end, s.v[axis], s.f_env[axis]
    damping = end.grip * min(abs(f_env) / end.firm, 1.0)
    acceleration = (f - f_env - damping * v) / end.mass
    wanted = v + acceleration * (end.period + 0.5 / end.bandwidth)
    command(axis, s.x[axis] + end.period * v + 2.0 / end.bandwidth * wanted, end, tool_command)


@njit(cache=True)
def hold_velocity(s: SlaveTick, v: Array, fade: float, memory: Array) -> float:
    """Keep a received velocity (3,), see `Held`; return the time [s] for which it has stood.

    Where every packet is sent it fades while nothing arrives, and that time is zero. Where silence
    says that it is still the same, it stands for `hold` before it fades, and the position received
    with it is taken to have gone on by so much of it.
    """
    held = held_of(memory)
    held.silent[()] += 1.0
    if s.progress > 0.0:
        held.silent[()] = 0.0
        held.v[:] = v
    elif (held.silent[()] - 0.5) * s.period > s.end.hold:  # whole ticks, whatever the rounding
        for i in range(held.v.size):
            held.v[i] *= fade
    return min(held.silent[()] * s.period, s.end.hold)
