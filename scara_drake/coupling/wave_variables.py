r"""Wave variables: force and velocity sent as waves, which any constant delay leaves passive.

Niemeyer and Slotine (1991), with the wave impedance b:

.. math::

    u_m &= \frac{b\,v_m + f_m}{\sqrt{2 b}}, \quad f_m = b\,v_m - \sqrt{2 b}\,w_m \\
    u_s &= \frac{b\,v_s + f_s}{\sqrt{2 b}}, \quad w_s = u_s - \sqrt{2 / b}\,f_s

Power is :math:`f v = u^2 / 2 - w^2 / 2`. Each end sends, beside its wave, the sum of its energy,
and plays what it receives with no more energy than has arrived. Where the delay grows at the rate
:math:`\dot\tau` that is the gain :math:`\sqrt{1 - \dot\tau}` of Lozano, Chopra and Spong (2002),
found without knowing the delay; it also covers loss and reordering. What is left over, where
packets were skipped, pays for a position term that takes away the drift. It is spent at once, so
the next tick without a packet is one without a wave: over jitter or loss that costs far more motion
than the skipped waves themselves, against which a buffer or `integrals` help. With `drift_gain` 0
the last wave is held over such a tick, and the drift stays.

With `integrals` each end also sends the integral of its waves (Niemeyer and Slotine 2004). Where
that differs from what was played, waves were skipped or repeated; the receiver makes up for it,

.. math::

    u \leftarrow u + \frac{1}{T} \left(\int u \, dt - \int u_{\text{played}} \, dt\right)

with no more energy than has arrived either; of what is left over, this and the position term spend
no more than the share 1 / T a second, so that some remains for ticks without a packet.

The wave to the slave is made of the way that the device has made and the force that it had over it,
both of the tick that is over, so it carries the true work of the hand. What a force can give out
before it is replaced is limited as in `tdpa`, for a device whose velocity changes by no more than
`turn`. With a reserve E0, without which no force could begin, at every tick

.. math::

    E_{\text{in, master}} + E_{\text{in, slave}} + E_0
    \ge E_{\text{out, master}} + E_{\text{out, slave}}

The force at the slave is that of a spring and a damper from the desired position to the motion that
the joints are truly asked for, as in `tdpa`.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.fields import number
from scara_drake.common.layout import REST, Layout
from scara_drake.coupling.ends import Coupling, Exchange
from scara_drake.coupling.kernels import (
    admit,
    affordable_force,
    committed,
    master_tick,
    meter,
    slave_tick,
)
from scara_drake.coupling.layouts import meters_of
from scara_drake.coupling.waves import GAINS, affordable, corrected, gains_of, make_up

Array = NDArray[np.float64]


class Up(NamedTuple):
    """Payload to the slave, each (3,): wave [sqrt(W)], energy of all waves [J], place, integral."""

    wave: Array
    energy: Array
    x: Array
    integral: Array


class Down(NamedTuple):
    """Payload to the master, each (3,): wave [sqrt(W)], energy of all waves [J], integral."""

    wave: Array
    energy: Array
    integral: Array


class MasterMemory(NamedTuple):
    """What was played at the master: energy [J] and integral [sqrt(W) s] of the waves, (3,)."""

    played: Array
    integral: Array


class SlaveMemory(NamedTuple):
    """Memory at the slave.

    Attributes:
        x_d: desired position x_sd (3,) [m].
        played: energy of the waves that were played (3,) [J].
        integral: of these waves (3,) [sqrt(W) s].
    """

    x_d: Array
    played: Array
    integral: Array


UP = Layout(Up, wave=3, energy=3, x=3, integral=REST)
DOWN = Layout(Down, wave=3, energy=3, integral=REST)
UP_WITH_INTEGRAL = Layout(Up, wave=3, energy=3, x=3, integral=3)
DOWN_WITH_INTEGRAL = Layout(Down, wave=3, energy=3, integral=3)
MASTER_MEMORY = Layout(MasterMemory, played=3, integral=3)
SLAVE_MEMORY = Layout(SlaveMemory, x_d=3, played=3, integral=3)
up_of, down_of = UP.reader(), DOWN.reader()
master_memory_of, slave_memory_of = MASTER_MEMORY.reader(), SLAVE_MEMORY.reader()


@njit(cache=True)
def wave_master(
    motion_master: Array,
    packet_from_slave: Array,
    constants: Array,
    memory: Array,
    packet_to_slave: Array,
    f_master: Array,
    energy_master: Array,
) -> None:
    """One tick at the master; what the last tick of the device was is sent as a wave."""
    s = master_tick(
        motion_master, packet_from_slave, constants, memory, packet_to_slave, f_master,
        energy_master,
    )  # fmt: skip
    m, newest, sent = master_memory_of(s.memory), down_of(s.newest), up_of(s.sent)
    p, period = gains_of(s.gains), s.period
    b = p.impedance
    energy = meters_of(energy_master)
    for i in range(3):
        left = p.reserve + energy.e_in[i] - energy.e_out[i] + m.played[i] - sent.energy[i]
        u = (b * s.way[i] / period + s.f_acted[i]) / math.sqrt(2.0 * b)
        u = affordable(u, left, committed(i, p.turn, s), period)
        sent.wave[i] = u
        sent.energy[i] += 0.5 * u * u * period
        w = newest.wave[i]
        if p.integral_rate > 0.0:
            sent.integral[i] += u * period
            missing = newest.integral[i] - m.integral[i] - w * period
            arrived = newest.energy[i] - m.played[i]
            w = corrected(w, make_up(missing, p), arrived, p.integral_rate * period, period)
        w = affordable(w, newest.energy[i], m.played[i], period)
        m.played[i] += 0.5 * w * w * period
        m.integral[i] += w * period
        left += 0.5 * (w * w - u * u) * period
        f_master[i] = affordable_force(b * s.v[i] - math.sqrt(2.0 * b) * w, i, left, p.turn, s)
        sent.x[i] = s.x[i]


@njit(cache=True)
def wave_slave(
    packet_from_master: Array,
    f_env_on_tool_W: Array,
    motion_limited: Array,
    constants: Array,
    memory: Array,
    packet_to_master: Array,
    tool_command: Array,
    energy_slave: Array,
) -> None:
    """One tick at the slave; the port is v_s and the force of its spring and damper.

    Both are solved for together: b v_s + f = sqrt(2 b) u_s, f = K_c (x_sd - x) + B_c (v_s - v).
    """
    s = slave_tick(
        packet_from_master, f_env_on_tool_W, motion_limited, constants, memory, packet_to_master
    )
    p, m = gains_of(s.gains), slave_memory_of(s.memory)
    newest, sent = up_of(s.newest), down_of(s.sent)
    period, b = s.period, p.impedance
    for i in range(3):
        drift = p.drift_gain * (newest.x[i] - m.x_d[i])
        drift = min(max(drift, -p.max_speed), p.max_speed)
        u, drift = newest.wave[i], math.sqrt(0.5 * b) * drift
        if p.integral_rate > 0.0:
            missing = newest.integral[i] - m.integral[i] - u * period
            left = newest.energy[i] - m.played[i]
            drift += make_up(missing, p)
            u = corrected(u, drift, left, p.integral_rate * period, period)
        else:
            u += drift
        u = affordable(u, newest.energy[i], m.played[i], period)
        m.played[i] += 0.5 * u * u * period
        m.integral[i] += u * period
        # The spring of the end of the step, which adds no energy of its own.
        rest = p.stiffness * (m.x_d[i] - s.x[i]) - p.damping * s.v[i]
        v = (math.sqrt(2.0 * b) * u - rest) / (b + p.damping + p.stiffness * period)
        f = math.sqrt(2.0 * b) * u - b * v
        m.x_d[i] += v * period
        meter(energy_slave, i, -f * v * period)
        admit(i, f, s, tool_command)
        w = u - math.sqrt(2.0 / b) * f
        sent.wave[i] = w
        sent.energy[i] += 0.5 * w * w * period
        if p.integral_rate > 0.0:
            sent.integral[i] += w * period


@dataclass
class WaveVariables(Coupling):
    """Wave variables.

    Attributes:
        impedance: b at the tool; large is heavy in free motion, small is soft in contact.
        stiffness: K_c from the desired position to the tool.
        damping: B_c beside it.
        drift_gain: of the position error, as far as its energy goes.
        max_speed: of that correction at the device, and of that of the integrals.
        reserve: E0 of each axis, in the master's units.
        turn: fastest change of the device's velocity for which it is passive.
        integrals: whether the integral of the waves is sent, which makes up for lost ones.
        integral_time: in which that is done, and in which energy that is left may be spent on it.
    """

    impedance: float = number(20.0, "N s/m", 0.1, 1e3)
    stiffness: float = number(1000.0, "N/m", 1.0, 1e5)
    damping: float = number(40.0, "N s/m", 0.0, 1e4)
    drift_gain: float = number(5.0, "1/s", 0.0, 100.0)
    max_speed: float = number(0.1, "m/s", 1e-3, 10.0)
    reserve: float = number(0.005, "J", 0.0, 100.0)
    turn: float = number(200.0, "m/s²", 1.0, 1e5)
    integrals: bool = False
    integral_time: float = number(0.3, "s", 1e-3, 10.0)

    def reserves(self) -> float:
        """E0 of the master."""
        return self.reserve

    def asked_damping(self) -> float:
        """The impedance of the waves [N s/m], which the device shows to fast motion."""
        return self.impedance_scale * self.impedance

    def exchange(self) -> Exchange:
        """What the kind sends, remembers and does."""
        up, down = (UP_WITH_INTEGRAL, DOWN_WITH_INTEGRAL) if self.integrals else (UP, DOWN)
        return Exchange(
            up,
            down,
            wave_master,
            wave_slave,
            MASTER_MEMORY,
            SLAVE_MEMORY,
            uses_late=self.integrals,  # the tick that a late wave was for is over
            felt_up=((up.slices["wave"], "wave"),),
            felt_down=((down.slices["wave"], "wave"),),
        )

    def parameters(self, period: float) -> Array:
        """The gains in the master's units."""
        scale = self.impedance_scale
        return GAINS.pack(
            impedance=scale * self.impedance,
            stiffness=scale * self.stiffness,
            damping=scale * self.damping,
            drift_gain=self.drift_gain,
            max_speed=self.max_speed,
            reserve=self.reserve,
            turn=self.turn,
            integral_rate=1.0 / self.integral_time if self.integrals else 0.0,
        )
