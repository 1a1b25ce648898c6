r"""Four channels: position and force both ways, transparent where nothing is late.

Lawrence (Stability and transparency in bilateral teleoperation, 1993), with the device
:math:`Z_m = m s + b`, the virtual tool :math:`Z_s = M s`, the same spring and damper
:math:`C = B + K / s` at both ends, and what was received marked by a prime:

.. math::

    f_m &= C\,(v_m - v_s') - Z_m v_s' + (1 + C_6)\,f_e' - C_6 f_h \\
    f_s &= C\,(v_m' - v_s) + Z_s v_m' + (1 + C_5)\,f_h' - C_5 f_e

These are his channels C1 = Z_s + C, C2 = 1 + C6, C3 = 1 + C5 and C4 = -(Z_m + C), optimised for
transparency. With the two bodies, :math:`Z_m v_m = f_h - f_m` and :math:`Z_s v_s = f_s - f_e`,

.. math::

    (Z_m + C)\,(v_m - v_s') = (1 + C_6)\,(f_h - f_e'), \quad
    (Z_s + C)\,(v_s - v_m') = (1 + C_5)\,(f_h' - f_e)

so without a delay both differences are zero and the hand feels the environment itself, the device
and the tool taken away. Nothing is passive: what is late is not what is taken away. A hand
:math:`Z_h` at an environment :math:`Z_e` is stable over a delay T there and back where

.. math::

    e^{-s T}\,\frac{(Z_m + C - (1 + C_6) Z_e)\,(Z_s + C - (1 + C_5) Z_h)}
    {(Z_m + C + (1 + C_6) Z_h)\,(Z_s + C + (1 + C_5) Z_e)}

does not go round 1. With a damper alone in the place of both Z + C that is never more than one for
passive ends: wave variables of the impedance B.

No device here has a sensor: the force of the hand is found from the motion of the device, as a
disturbance observer does (Murakami, Yu and Ohnishi, 1993), with the mass and the damping that the
coupling is told. It and the accelerations pass a low-pass filter. By default the accelerations are
left out, as most who build it do: the arm's lag is a delay even where the channel has none, and a
late acceleration drives what it should take away. Then, without a delay and as far as the springs
hold both together,

.. math::

    (m + M)\,s\,v = (2 + C_5 + C_6)\,(f_h - f_e)

so in motion the hand feels that part of the masses of device and tool, half of them for C5 = C6 =
0, as its force pushes at both, and at rest what the tool feels. C6 below 0 takes a part of the
force out of the loop.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.fields import number
from scara_drake.common.layout import Layout
from scara_drake.coupling.ends import Coupling, Exchange
from scara_drake.coupling.kernels import admit, master_tick, meter, slave_tick

Array = NDArray[np.float64]


class Gains(NamedTuple):
    """`FourChannel` in a kernel, in the master's units.

    Of a filtered signal the share `passing` is taken on at every tick.
    """

    stiffness: float
    damping: float
    local_master: float
    local_slave: float
    acceleration: float
    device_mass: float
    device_damping: float
    tool_mass: float
    passing: float


class Payload(NamedTuple):
    """Payload of either direction, each (3,).

    Attributes:
        x: position of the sender [m].
        v: its velocity [m/s].
        a: its acceleration [m/s²].
        f: force of the hand, or of the environment [N].
    """

    x: Array
    v: Array
    a: Array
    f: Array


class MasterMemory(NamedTuple):
    """Velocity of the last tick [m/s], filtered acceleration [m/s²] and hand's force [N], (3,)."""

    v: Array
    a: Array
    f: Array


class SlaveMemory(NamedTuple):
    """Of the last tick: x [m], v [m/s], filtered acceleration [m/s²], force of the coupling [N]."""

    x: Array
    v: Array
    a: Array
    f: Array


GAINS, PAYLOAD = Layout(Gains), Layout(Payload, x=3, v=3, a=3, f=3)
MASTER_MEMORY = Layout(MasterMemory, v=3, a=3, f=3)
SLAVE_MEMORY = Layout(SlaveMemory, x=3, v=3, a=3, f=3)
gains_of, payload_of = GAINS.reader(), PAYLOAD.reader()
master_memory_of, slave_memory_of = MASTER_MEMORY.reader(), SLAVE_MEMORY.reader()


@njit(cache=True)
def four_channel_master(
    motion_master: Array,
    packet_from_slave: Array,
    constants: Array,
    memory: Array,
    packet_to_slave: Array,
    f_master: Array,
    energy_master: Array,
) -> None:
    """One tick at the master."""
    s = master_tick(
        motion_master, packet_from_slave, constants, memory, packet_to_slave, f_master,
        energy_master,
    )  # fmt: skip
    p, m = gains_of(s.gains), master_memory_of(s.memory)
    far, sent = payload_of(s.newest), payload_of(s.sent)
    for i in range(3):
        a = (s.v[i] - m.v[i]) / s.period
        f = p.device_mass * a + p.device_damping * s.way[i] / s.period + s.f_acted[i]
        m.v[i] = s.v[i]
        m.a[i] += p.passing * (a - m.a[i])
        m.f[i] += p.passing * (f - m.f[i])
        body = p.acceleration * p.device_mass * far.a[i] + p.device_damping * far.v[i]
        f_master[i] = p.stiffness * (s.x[i] - far.x[i]) + p.damping * (s.v[i] - far.v[i]) - body
        f_master[i] += (1.0 + p.local_master) * far.f[i] - p.local_master * m.f[i]
        sent.x[i] = s.x[i]
        sent.v[i] = s.v[i]
        sent.a[i] = m.a[i]
        sent.f[i] = m.f[i]


@njit(cache=True)
def four_channel_slave(
    packet_from_master: Array,
    f_env_on_tool_W: Array,
    motion_limited: Array,
    constants: Array,
    memory: Array,
    packet_to_master: Array,
    tool_command: Array,
    energy_slave: Array,
) -> None:
    """One tick at the slave; the port is the force of the coupling and the limited motion."""
    s = slave_tick(
        packet_from_master, f_env_on_tool_W, motion_limited, constants, memory, packet_to_master
    )
    p, m = gains_of(s.gains), slave_memory_of(s.memory)
    far, sent = payload_of(s.newest), payload_of(s.sent)
    for i in range(3):
        meter(energy_slave, i, -m.f[i] * (s.x[i] - m.x[i]))
        m.a[i] += p.passing * ((s.v[i] - m.v[i]) / s.period - m.a[i])
        f = p.stiffness * (far.x[i] - s.x[i]) + p.damping * (far.v[i] - s.v[i])
        f += p.acceleration * p.tool_mass * far.a[i]
        f += (1.0 + p.local_slave) * far.f[i] - p.local_slave * s.f_env[i]
        m.x[i] = s.x[i]
        m.v[i] = s.v[i]
        m.f[i] = f
        admit(i, f, s, tool_command)
        sent.x[i] = s.x[i]
        sent.v[i] = s.v[i]
        sent.a[i] = m.a[i]
        sent.f[i] = s.f_env[i]


@dataclass
class FourChannel(Coupling):
    """Position and force both ways; K and B are at the tool, and the master has them times scales.

    Attributes:
        stiffness: K of both ends.
        damping: B of both ends.
        local_master: C6, of the hand's force at the master; below 0 it is felt less.
        local_slave: C5, of the environment's force at the slave; above 0 the tool gives way more.
        acceleration: share of the accelerations that is sent on; 1 is the transparent law, without
            them the hand feels device and tool.
        device_mass: m, as the coupling believes it.
        device_damping: b, as the coupling believes it.
        cutoff: of the filter of force and accelerations.
    """

    stiffness: float = number(100.0, "N/m", 0.0, 1e5)
    damping: float = number(40.0, "N s/m", 0.0, 1e4)
    local_master: float = number(-0.5, "1", -1.0, 10.0)
    local_slave: float = number(0.0, "1", -1.0, 10.0)
    acceleration: float = number(0.0, "1", 0.0, 1.0)
    device_mass: float = number(0.3, "kg", 0.0, 100.0)
    device_damping: float = number(2.0, "N s/m", 0.0, 1e3)
    cutoff: float = number(200.0, "1/s", 1.0, 1e5)

    def exchange(self) -> Exchange:
        """What the kind sends, remembers and does."""
        felt = ((PAYLOAD.slices["v"], "speed"), (PAYLOAD.slices["f"], "force"))
        return Exchange(
            PAYLOAD,
            PAYLOAD,
            four_channel_master,
            four_channel_slave,
            MASTER_MEMORY,
            SLAVE_MEMORY,
            felt_up=felt,
            felt_down=felt,
        )

    def parameters(self, period: float) -> Array:
        """The gains in the master's units."""
        scale = self.impedance_scale
        return GAINS.pack(
            stiffness=scale * self.stiffness,
            damping=scale * self.damping,
            local_master=self.local_master,
            local_slave=self.local_slave,
            acceleration=self.acceleration,
            device_mass=self.device_mass,
            device_damping=self.device_damping,
            tool_mass=scale * self.virtual_mass,
            passing=1.0 - math.exp(-period * self.cutoff),
        )
