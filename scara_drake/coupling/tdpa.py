r"""Time domain passivity: each end gives out no more energy than the other has told it came in.

Energy that came in never falls, so the newest packet is a safe lower bound of it whatever the
channel delays, loses or reorders. At every tick, per axis, with a reserve E0,

.. math::

    E_{\text{out, slave}}(t)  &\le E_{\text{in, master}}(t - \tau) + E_0 \\
    E_{\text{out, master}}(t) &\le E_{\text{in, slave}}(t - \tau) + E_0

This is for a device whose velocity changes by no more than `turn`, by the hand and its own
actuators together. A force that is commanded now acts from the next tick to the one after it, when
the device may have turned round; so it is limited by the most that it could give out in that time,
and not by what it gives out now.

The limited form of Hannaford-Ryu (2002) and Ryu-Artigas-Preusche (2010): the slave's velocity and
the master's force are scaled within [0, 1], with no division by a small power. What is left is
spent over `horizon` and not in one tick, so a limit comes on smoothly.

The port at the slave is the velocity v_sd of the desired position and the force of a spring and a
damper from there to the motion that the joints are truly asked for, `motion_limited`,

.. math::

    f = K_c\,(x_{sd} - x) + B_c\,(v_{sd} - v), \quad M \dot v = f - f_{\text{env}}

so that no limit of the robot is between the force and the velocity that are metered. With v_rx and
x_rx as received, v_sd = v_rx + drift_gain (x_rx - x_sd) before the limit, which lets x_sd return to
the master once there is energy (Artigas; Coelho et al., arXiv:1909.01603). E0 = 0 locks up against
a wall: no force, so no energy, so no force.
"""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple, Self

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.fields import number
from scara_drake.common.layout import Layout
from scara_drake.coupling.ends import Coupling, Exchange
from scara_drake.coupling.kernels import (
    admit,
    affordable_force,
    hold_velocity,
    master_tick,
    meter,
    slave_tick,
)
from scara_drake.coupling.layouts import HELD, held_of, meters_of

Array = NDArray[np.float64]


class Gains(NamedTuple):
    """`Tdpa` in a kernel, in the master's units.

    A velocity that is held fades to the share `fade` at every tick.
    """

    stiffness: float
    damping: float
    master_damping: float
    reserve: float
    horizon: float
    guard_speed: float
    turn: float
    drift_gain: float
    max_speed: float
    fade: float


class Up(NamedTuple):
    """Payload to the slave: position [m], velocity [m/s], energy that came in [J]; (3,) each."""

    x: Array
    v: Array
    e_in: Array


class Down(NamedTuple):
    """Payload to the master: force [N] and energy that came in [J], each (3,)."""

    f: Array
    e_in: Array


class SlaveMemory(NamedTuple):
    """Memory at the slave.

    Attributes:
        x_d: desired position x_sd (3,) [m].
        f: force of the spring and the damper at the last tick (3,) [N].
        held: received velocity, see `Held`.
    """

    x_d: Array
    f: Array
    held: Array


GAINS, UP, DOWN = Layout(Gains), Layout(Up, x=3, v=3, e_in=3), Layout(Down, f=3, e_in=3)
SLAVE_MEMORY = Layout(SlaveMemory, x_d=3, f=3, held=HELD.size)
gains_of, up_of, down_of = GAINS.reader(), UP.reader(), DOWN.reader()
slave_memory_of = SLAVE_MEMORY.reader()


@njit(cache=True)
def tdpa_master(
    motion_master: Array,
    packet_from_slave: Array,
    constants: Array,
    memory: Array,
    packet_to_slave: Array,
    f_master: Array,
    energy_master: Array,
) -> None:
    """One tick at the master: meter the device, then limit the received force."""
    s = master_tick(
        motion_master, packet_from_slave, constants, memory, packet_to_slave, f_master,
        energy_master,
    )  # fmt: skip
    p, newest, sent = gains_of(s.gains), down_of(s.newest), up_of(s.sent)
    energy = meters_of(energy_master)
    for i in range(3):
        left = max(newest.e_in[i] + p.reserve - energy.e_out[i], 0.0)
        force = newest.f[i]
        # Speed at which the hand may be given way within the horizon.
        retreat = max(p.guard_speed - math.copysign(s.v[i], force * s.v[i]), 0.0)
        spent = abs(force) * retreat * p.horizon
        if spent > left:
            force *= left / spent
        force += p.master_damping * s.v[i]
        f_master[i] = affordable_force(force, i, left, p.turn, s)
        sent.x[i] = s.x[i]
        sent.v[i] = s.v[i]
        sent.e_in[i] = energy.e_in[i]


@njit(cache=True)
def tdpa_slave(
    packet_from_master: Array,
    f_env_on_tool_W: Array,
    motion_limited: Array,
    constants: Array,
    memory: Array,
    packet_to_master: Array,
    tool_command: Array,
    energy_slave: Array,
) -> None:
    """One tick at the slave: limit the desired velocity, then let its spring move the tool.

    The power is that of the force of the tick before, which is on its way to the master: with the
    force that the step itself makes, the budget would count it twice and lock.
    """
    s = slave_tick(
        packet_from_master, f_env_on_tool_W, motion_limited, constants, memory, packet_to_master
    )
    p, m = gains_of(s.gains), slave_memory_of(s.memory)
    newest, sent, energy = up_of(s.newest), down_of(s.sent), meters_of(energy_slave)
    ahead = hold_velocity(s, newest.v, p.fade, m.held)
    v_held = held_of(m.held).v
    for i in range(3):
        v = v_held[i] + p.drift_gain * (newest.x[i] + ahead * newest.v[i] - m.x_d[i])
        v = min(max(v, -p.max_speed), p.max_speed)
        power = m.f[i] * v
        if power > 0.0:
            left = max(newest.e_in[i] + p.reserve - energy.e_out[i], 0.0)
            if power * p.horizon > left:
                v *= left / (power * p.horizon)
        # Seen from the slave, what goes out is what the master put in.
        meter(energy_slave, i, -m.f[i] * v * s.period)
        m.x_d[i] += v * s.period
        f = p.stiffness * (m.x_d[i] - s.x[i]) + p.damping * (v - s.v[i])
        m.f[i] = f
        admit(i, f, s, tool_command)
        sent.f[i] = f
        sent.e_in[i] = energy.e_in[i]


@dataclass
class Tdpa(Coupling):
    """Passivity in the time domain, for any delay, loss and reordering.

    Attributes:
        stiffness: K_c from the desired position to the tool.
        damping: B_c beside it.
        master_damping: of the device beside its force, at the tool; what it takes from the hand
            counts as energy that came in. It is felt in free motion, and saves the reserve.
        reserve: E0 of each axis and direction, in the master's units. A larger one shows more
            force at a long delay and leaves a larger drift after the release.
        horizon: time over which the energy that is left may be spent.
        guard_speed: beside that of the hand's retreat, at which it is taken to be spent.
        turn: fastest change of the device's velocity for which the bound holds.
        drift_gain: of the position error.
        max_speed: of the desired position at the device.
        fade_time: time constant of the received velocity while nothing arrives.
    """

    stiffness: float = number(1000.0, "N/m", 1.0, 1e5)
    damping: float = number(25.0, "N s/m", 0.0, 1e4)
    master_damping: float = number(20.0, "N s/m", 0.0, 100.0)
    reserve: float = number(0.03, "J", 0.0, 100.0)
    horizon: float = number(0.02, "s", 2e-3, 1.0)
    guard_speed: float = number(0.02, "m/s", 0.0, 10.0)
    turn: float = number(200.0, "m/s²", 1.0, 1e5)
    drift_gain: float = number(5.0, "1/s", 0.0, 100.0)
    max_speed: float = number(0.3, "m/s", 1e-3, 10.0)
    fade_time: float = number(0.02, "s", 1e-3, 10.0)

    def reserves(self) -> float:
        """E0 of both directions."""
        return 2.0 * self.reserve

    def within(self, stiffness: float, damping: float) -> Self:
        """The coupling whose damping at the device is cut to what that renders [N s/m]."""
        most = damping / self.impedance_scale
        return replace(self, master_damping=min(self.master_damping, most))

    def asked_damping(self) -> float:
        """That of the device beside its force [N s/m]."""
        return self.impedance_scale * self.master_damping

    def exchange(self) -> Exchange:
        """What the kind sends, remembers and does."""
        return Exchange(
            UP,
            DOWN,
            tdpa_master,
            tdpa_slave,
            slave_memory=SLAVE_MEMORY,
            felt_up=((UP.slices["v"], "speed"),),
            felt_down=((DOWN.slices["f"], "force"),),
        )

    def parameters(self, period: float) -> Array:
        """The gains in the master's units."""
        scale = self.impedance_scale
        return GAINS.pack(
            stiffness=scale * self.stiffness,
            damping=scale * self.damping,
            master_damping=scale * self.master_damping,
            reserve=self.reserve,
            horizon=self.horizon,
            guard_speed=self.guard_speed,
            turn=self.turn,
            drift_gain=self.drift_gain,
            max_speed=self.max_speed,
            fade=math.exp(-period / self.fade_time),
        )
