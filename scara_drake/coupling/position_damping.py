"""P+d: a spring to where the other end was, and a damper to the ground, at both ends.

Nuno, Basanez and Ortega (Automatica 47, 2011, 485)::

    f_m = K_l (x_m - x_s(t - T_r)) + B_l v_m,   f_s = K_r (x_m(t - T_l) - x_s) - B_r v_s

is stable for any passive hand and wall if 4 B_l B_r > (T_l² + T_r²) K_l K_r with the longest
delays. It needs no model and no energy, and is sluggish: the dampers act in free motion too.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common import checks
from scara_drake.coupling.ends import (
    HEAD,
    NUMBER,
    OWN,
    Coupling,
    F,
    Kernel,
    X,
    admit,
    meter,
    meter_device,
    receive,
)

Array = NDArray[np.float64]

STIFFNESS, DAMPING = OWN, OWN + 1
# Payload up and down: x (3).
P_X, P_SIZE = 1, 4


def damping_margin(stiffness: float, damping: float, up: float, down: float) -> float:
    """Return 4 B² / ((T_l² + T_r²) K²), above 1 where the condition holds; infinite at no delay.

    Args:
        stiffness: K of both ends [N/m].
        damping: B of both ends [N s/m].
        up: longest delay to the slave [s].
        down: longest delay to the master [s].
    """
    demand = (up * up + down * down) * stiffness * stiffness
    return np.inf if demand == 0.0 else 4.0 * damping * damping / demand


@dataclass
class PositionDamping(Coupling):
    """P+d; both gains are at the tool, and the master has them times the scales."""

    stiffness: float = 100.0  # K [N/m]
    damping: float = 30.0  # B [N s/m]

    def validate(self, name: str) -> None:
        """Check the fields.

        Raises:
            ValueError: one line that names the field, its value and what is allowed.
        """
        super().validate(name)
        checks.number(f"{name}.stiffness", self.stiffness, 0.0, 1e5)
        checks.number(f"{name}.damping", self.damping, 0.0, 1e4)

    def margin(self, up: float, down: float) -> float:
        """Return the `damping_margin` for the longest delays up and down [s]."""
        return damping_margin(self.stiffness, self.damping, up, down)

    def kernels(self) -> tuple[Kernel, Kernel]:
        """The kernels of one tick at the master and at the slave."""
        return position_master, position_slave

    def sizes(self) -> tuple[int, int, int, int]:
        """Sizes of the packets up and down, and of the memories."""
        return P_SIZE, P_SIZE, HEAD, HEAD

    def parameters(self, period: float) -> Array:
        """The gains in the master's units."""
        return self.impedance_scale * np.array([self.stiffness, self.damping])


@njit(cache=True)
def position_master(
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
    receive(packet, newest)
    meter_device(motion, f, constants, memory, energy)
    for i in range(3):
        f[i] = constants[STIFFNESS] * (motion[i] - newest[P_X + i])
        f[i] += constants[DAMPING] * motion[3 + i]
        sent[P_X + i] = motion[i]
    sent[NUMBER] += 1.0


@njit(cache=True)
def position_slave(
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
    """One tick at the slave; the port is the force of the coupling and the limited motion."""
    receive(packet, newest)
    for i in range(3):
        meter(energy, i, -memory[F + i] * (motion[i] - memory[X + i]))
        f = (
            constants[STIFFNESS] * (newest[P_X + i] - motion[i])
            - constants[DAMPING] * motion[3 + i]
        )
        memory[X + i] = motion[i]
        memory[F + i] = f
        admit(i, f, f_env[i], motion, constants, command)
        sent[P_X + i] = motion[i]
    sent[NUMBER] += 1.0
