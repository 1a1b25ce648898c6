"""Direct position-force coupling: the slave's position is the master's, the force comes back.

No energy is accounted for. With a delay in the loop it is unstable against a stiff wall, which is
why the other kinds exist; a small `force_scale` is the first thing that helps.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.coupling.ends import (
    HEAD,
    NUMBER,
    Coupling,
    F,
    Kernel,
    X,
    meter,
    meter_device,
    receive,
)

Array = NDArray[np.float64]

# Payload up: x (3); down: f (3).
UP_X, UP_SIZE = 1, 4
DOWN_F, DOWN_SIZE = 1, 4


@dataclass
class Direct(Coupling):
    """Position up, force of the environment down; `virtual_mass` has no meaning here."""

    def kernels(self) -> tuple[Kernel, Kernel]:
        """The kernels of one tick at the master and at the slave."""
        return direct_master, direct_slave

    def sizes(self) -> tuple[int, int, int, int]:
        """Sizes of the packets up and down, and of the memories."""
        return UP_SIZE, DOWN_SIZE, HEAD, HEAD

    def parameters(self, period: float) -> Array:
        """None."""
        return np.zeros(0)


@dataclass
class ScaledForce(Direct):
    """`Direct` with a tenth of the force."""

    force_scale: float = 0.1


@njit(cache=True)
def direct_master(
    motion: Array,
    packet: Array,
    constants: Array,
    newest: Array,
    memory: Array,
    sent: Array,
    f: Array,
    energy: Array,
) -> None:
    """One tick at the master: show the force, send the position."""
    receive(packet, newest)
    meter_device(motion, f, constants, memory, energy)
    f[:] = newest[DOWN_F : DOWN_F + 3]
    sent[UP_X : UP_X + 3] = motion[:3]
    sent[NUMBER] += 1.0


@njit(cache=True)
def direct_slave(
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
    """One tick at the slave: go to the position; the port is that of the environment."""
    receive(packet, newest)
    for i in range(3):
        meter(energy, i, -memory[F + i] * (motion[i] - memory[X + i]))
        memory[X + i] = motion[i]
        memory[F + i] = f_env[i]
        sent[DOWN_F + i] = f_env[i]
        command[i] = newest[UP_X + i]
    sent[NUMBER] += 1.0
