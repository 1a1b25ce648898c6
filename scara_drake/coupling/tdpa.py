"""Time domain passivity: each end gives out no more energy than the other has told it came in.

Energy that came in never falls, so the newest packet is a safe lower bound of it whatever the
channel delays, loses or reorders. At every tick, per axis, with a reserve E0::

    E_out(slave)(t)  <= E_in(master)(t - tau) + E0,   E_out(master)(t) <= E_in(slave)(t - tau) + E0

The limited form of Hannaford-Ryu (2002) and Ryu-Artigas-Preusche (2010): the slave's velocity and
the master's force are scaled within [0, 1], with no division by a small power. What is left is
spent over `horizon` and not in one tick, so a limit comes on smoothly.

The port at the slave is the velocity v_sd of the desired position and the force of a spring and a
damper from there to the motion that the joints are truly asked for, `motion_limited`::

    f = K_c (x_sd - x) + B_c (v_sd - v),   M v' = f - f_env

so that no limit of the robot is between the force and the velocity that are metered. With v_rx and
x_rx as received, v_sd = v_rx + drift_gain (x_rx - x_sd) before the limit, which lets x_sd return to
the master once there is energy (Artigas; Coelho et al., arXiv:1909.01603). E0 = 0 locks up against
a wall: no force, so no energy, so no force.
"""

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common import checks
from scara_drake.coupling.ends import (
    E_IN,
    E_OUT,
    HEAD,
    HELD,
    NUMBER,
    OWN,
    PERIOD,
    Coupling,
    F,
    Kernel,
    X,
    admit,
    hold_velocity,
    meter,
    meter_device,
    receive,
)

Array = NDArray[np.float64]

STIFFNESS, DAMPING, BRAKE, RESERVE, HORIZON, GUARD, DRIFT, SPEED, FADE = range(OWN, OWN + 9)
# Payload up: x (3), v (3), E_in (3); down: f (3), E_in (3).
UP_X, UP_V, UP_E, UP_SIZE = 1, 4, 7, 10
DOWN_F, DOWN_E, DOWN_SIZE = 1, 4, 7


@dataclass
class Tdpa(Coupling):
    """Passivity in the time domain, for any delay, loss and reordering.

    Attributes:
        stiffness: K_c from the desired position to the tool [N/m].
        damping: B_c [N s/m].
        master_damping: of the device beside its force, at the tool [N s/m]; what it takes from the
            hand counts as energy that came in. It is felt in free motion, and saves the reserve.
        reserve: E0 of each axis and direction, in the master's units [J]. A larger one shows more
            force at a long delay and leaves a larger drift after the release.
        horizon: time over which the energy that is left may be spent [s].
        guard_speed: by which the master's force allows for a hand that turns round [m/s].
        drift_gain: of the position error [1/s].
        max_speed: of the desired position at the device [m/s].
        fade_time: time constant of the received velocity while nothing arrives [s].
    """

    stiffness: float = 1000.0  # [N/m]
    damping: float = 25.0  # [N s/m]
    master_damping: float = 15.0  # [N s/m]
    reserve: float = 0.03  # [J]
    horizon: float = 0.02  # [s]
    guard_speed: float = 0.02  # [m/s]
    drift_gain: float = 5.0  # [1/s]
    max_speed: float = 0.3  # [m/s]
    fade_time: float = 0.02  # [s]

    def validate(self, name: str) -> None:
        """Check the fields.

        Raises:
            ValueError: one line that names the field, its value and what is allowed.
        """
        super().validate(name)
        checks.number(f"{name}.stiffness", self.stiffness, 1.0, 1e5)
        checks.number(f"{name}.damping", self.damping, 0.0, 1e4)
        checks.number(f"{name}.master_damping", self.master_damping, 0.0, 100.0)
        checks.number(f"{name}.reserve", self.reserve, 0.0, 100.0)
        checks.number(f"{name}.horizon", self.horizon, 2e-3, 1.0)
        checks.number(f"{name}.guard_speed", self.guard_speed, 1e-4, 10.0)
        checks.number(f"{name}.drift_gain", self.drift_gain, 0.0, 100.0)
        checks.number(f"{name}.max_speed", self.max_speed, 1e-3, 10.0)
        checks.number(f"{name}.fade_time", self.fade_time, 1e-3, 10.0)

    def kernels(self) -> tuple[Kernel, Kernel]:
        """The kernels of one tick at the master and at the slave."""
        return tdpa_master, tdpa_slave

    def sizes(self) -> tuple[int, int, int, int]:
        """Sizes of the packets up and down, and of the memories; the slave's keeps x_sd in X."""
        return UP_SIZE, DOWN_SIZE, HEAD, HEAD

    def parameters(self, period: float) -> Array:
        """The constants of the kind, in the master's units."""
        scale = self.impedance_scale
        return np.array(
            [
                scale * self.stiffness,
                scale * self.damping,
                scale * self.master_damping,
                self.reserve,
                self.horizon,
                self.guard_speed,
                self.drift_gain,
                self.max_speed,
                math.exp(-period / self.fade_time),
            ]
        )


@njit(cache=True)
def tdpa_master(
    motion: Array,
    packet: Array,
    constants: Array,
    newest: Array,
    memory: Array,
    sent: Array,
    f: Array,
    energy: Array,
) -> None:
    """One tick at the master: meter the device, then limit the received force."""
    receive(packet, newest)
    meter_device(motion, f, constants, memory, energy)
    for i in range(3):
        left = max(newest[DOWN_E + i] + constants[RESERVE] - energy[E_OUT + i], 0.0)
        force = newest[DOWN_F + i]
        # Speed at which the hand may be given way within the horizon.
        retreat = max(constants[GUARD] - math.copysign(1.0, force) * motion[3 + i], 0.0)
        if abs(force) * retreat * constants[HORIZON] > left:
            force = math.copysign(left / (retreat * constants[HORIZON]), force)
        f[i] = force + constants[BRAKE] * motion[3 + i]
        sent[UP_X + i] = motion[i]
        sent[UP_V + i] = motion[3 + i]
        sent[UP_E + i] = energy[E_IN + i]
    sent[NUMBER] += 1.0


@njit(cache=True)
def tdpa_slave(
    motion: Array,
    f_env: Array,
    packet: Array,
    constants: Array,
    newest: Array,
    memory: Array,
    sent: Array,
    command: Array,
    energy: Array,
) -> None:
    """One tick at the slave: limit the desired velocity, then let its spring move the tool.

    The power is that of the force of the tick before, which is on its way to the master: with the
    force that the step itself makes, the budget would count it twice and lock.
    """
    period, speed = constants[PERIOD], constants[SPEED]
    progress = receive(packet, newest)
    hold_velocity(progress, newest[UP_V : UP_V + 3], constants[FADE], memory)
    for i in range(3):
        v = memory[HELD + i] + constants[DRIFT] * (newest[UP_X + i] - memory[X + i])
        v = min(max(v, -speed), speed)
        power = memory[F + i] * v
        if power > 0.0:
            left = max(newest[UP_E + i] + constants[RESERVE] - energy[E_OUT + i], 0.0)
            if power * constants[HORIZON] > left:
                v *= left / (power * constants[HORIZON])
        # Seen from the slave, what goes out is what the master put in.
        meter(energy, i, -memory[F + i] * v * period)
        memory[X + i] += v * period
        f = constants[STIFFNESS] * (memory[X + i] - motion[i]) + constants[DAMPING] * (
            v - motion[3 + i]
        )
        memory[F + i] = f
        admit(i, f, f_env[i], motion, constants, command)
        sent[DOWN_F + i] = f
        sent[DOWN_E + i] = energy[E_IN + i]
    sent[NUMBER] += 1.0
