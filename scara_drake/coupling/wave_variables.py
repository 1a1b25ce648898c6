"""Wave variables: force and velocity sent as waves, which any constant delay leaves passive.

Niemeyer and Slotine (1991), with the wave impedance b::

    u_m = (b v_m + f_m) / sqrt(2 b),  f_m = b v_m - sqrt(2 b) w_m
    u_s = (b v_s + f_s) / sqrt(2 b),  w_s = u_s - sqrt(2 / b) f_s

Power f v is u² / 2 - w² / 2. Each end sends, beside its wave, the sum of its energy, and plays what
it receives with no more energy than has arrived. Where the delay grows at the rate tau' that is the
gain sqrt(1 - tau') of Lozano, Chopra and Spong (2002), found without knowing the delay; it also
covers loss and reordering. What is left over, where packets were skipped, pays for a position term
that takes away the drift.

The force at the slave is that of a spring and a damper from the desired position to the motion that
the joints are truly asked for, as in `tdpa`.
"""

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common import checks
from scara_drake.coupling.ends import (
    HEAD,
    NUMBER,
    OWN,
    PERIOD,
    Coupling,
    Kernel,
    X,
    admit,
    meter,
    meter_device,
    receive,
)

Array = NDArray[np.float64]

IMPEDANCE, STIFFNESS, DAMPING, DRIFT, SPEED = range(OWN, OWN + 5)
# Payload up: wave (3), its energy (3) [J], x (3); down: wave (3), its energy (3).
WAVE, ENERGY, UP_X, UP_SIZE, DOWN_SIZE = 1, 4, 7, 10, 7
# Memory after the head: energy of the waves that were played (3) [J].
PLAYED, MEMORY = HEAD, HEAD + 3


@dataclass
class WaveVariables(Coupling):
    """Wave variables.

    Attributes:
        impedance: b at the tool [N s/m]; large is heavy in free motion, small is soft in contact.
        stiffness: K_c from the desired position to the tool [N/m].
        damping: B_c [N s/m].
        drift_gain: of the position error, as far as its energy goes [1/s].
        max_speed: of that correction at the device [m/s].
    """

    impedance: float = 20.0  # [N s/m]
    stiffness: float = 1000.0  # [N/m]
    damping: float = 40.0  # [N s/m]
    drift_gain: float = 5.0  # [1/s]
    max_speed: float = 0.1  # [m/s]

    def validate(self, name: str) -> None:
        """Check the fields.

        Raises:
            ValueError: one line that names the field, its value and what is allowed.
        """
        super().validate(name)
        checks.number(f"{name}.impedance", self.impedance, 0.1, 1e3)
        checks.number(f"{name}.stiffness", self.stiffness, 1.0, 1e5)
        checks.number(f"{name}.damping", self.damping, 0.0, 1e4)
        checks.number(f"{name}.drift_gain", self.drift_gain, 0.0, 100.0)
        checks.number(f"{name}.max_speed", self.max_speed, 1e-3, 10.0)

    def kernels(self) -> tuple[Kernel, Kernel]:
        """The kernels of one tick at the master and at the slave."""
        return wave_master, wave_slave

    def sizes(self) -> tuple[int, int, int, int]:
        """Sizes of the packets up and down, and of the memories; the slave's keeps x_sd in X."""
        return UP_SIZE, DOWN_SIZE, MEMORY, MEMORY

    def parameters(self, period: float) -> Array:
        """The constants of the kind, in the master's units."""
        impedances = self.impedance_scale * np.array([self.impedance, self.stiffness, self.damping])
        return np.concatenate([impedances, [self.drift_gain, self.max_speed]])


@njit(cache=True)
def affordable(wave: float, arrived: float, played: float, period: float) -> float:
    """Return the wave, smaller where its energy over the period is not there [J]."""
    left = max(arrived - played, 0.0)
    if 0.5 * wave * wave * period > left:
        return math.copysign(math.sqrt(2.0 * left / period), wave)
    return wave


@njit(cache=True)
def wave_master(
    motion: Array,
    packet: Array,
    constants: Array,
    newest: Array,
    memory: Array,
    sent: Array,
    f: Array,
    energy: Array,
) -> None:
    """One tick at the master."""
    period, b = constants[PERIOD], constants[IMPEDANCE]
    receive(packet, newest)
    meter_device(motion, f, constants, memory, energy)
    for i in range(3):
        w = affordable(newest[WAVE + i], newest[ENERGY + i], memory[PLAYED + i], period)
        memory[PLAYED + i] += 0.5 * w * w * period
        f[i] = b * motion[3 + i] - math.sqrt(2.0 * b) * w
        u = (b * motion[3 + i] + f[i]) / math.sqrt(2.0 * b)
        sent[WAVE + i] = u
        sent[ENERGY + i] += 0.5 * u * u * period
        sent[UP_X + i] = motion[i]
    sent[NUMBER] += 1.0


@njit(cache=True)
def wave_slave(
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
    """One tick at the slave; the port is v_s and the force of its spring and damper.

    Both are solved for together: b v_s + f = sqrt(2 b) u_s, f = K_c (x_sd - x) + B_c (v_s - v).
    """
    period, b = constants[PERIOD], constants[IMPEDANCE]
    stiffness, damping, speed = constants[STIFFNESS], constants[DAMPING], constants[SPEED]
    receive(packet, newest)
    for i in range(3):
        drift = constants[DRIFT] * (newest[UP_X + i] - memory[X + i])
        drift = min(max(drift, -speed), speed)
        u = newest[WAVE + i] + math.sqrt(0.5 * b) * drift
        u = affordable(u, newest[ENERGY + i], memory[PLAYED + i], period)
        memory[PLAYED + i] += 0.5 * u * u * period
        # The spring of the end of the step, which adds no energy of its own.
        rest = stiffness * (memory[X + i] - motion[i]) - damping * motion[3 + i]
        v = (math.sqrt(2.0 * b) * u - rest) / (b + damping + stiffness * period)
        f = math.sqrt(2.0 * b) * u - b * v
        memory[X + i] += v * period
        meter(energy, i, -f * v * period)
        admit(i, f, f_env[i], motion, constants, command)
        w = u - math.sqrt(2.0 / b) * f
        sent[WAVE + i] = w
        sent[ENERGY + i] += 0.5 * w * w * period
    sent[NUMBER] += 1.0
