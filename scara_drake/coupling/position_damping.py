r"""P+d: a spring to where the other end was, and a damper to the ground, at both ends.

Nuno, Basanez and Ortega (Automatica 47, 2011, 485):

.. math::

    f_m &= K_l\,(x_m - x_s(t - T_r)) + B_l\,v_m \\
    f_s &= K_r\,(x_m(t - T_l) - x_s) - B_r\,v_s

is stable for any passive hand and wall if :math:`4 B_l B_r > (T_l + T_r)^2 K_l K_r`, with the
longest delays of the links, at any rate of their change. It needs no model and no energy, and is
sluggish: the dampers act in free motion too.

The condition is what the proof in that paper leaves: its Lyapunov functional falls if there are
a, c > 0 with :math:`2 B_l / K_l > a + T_l^2 / c` and :math:`2 B_r / K_r > c + T_r^2 / a`. For a
given c the first bounds a, and the smallest right side of the second is then
:math:`(T_l + T_r)^2 K_l / (2 B_l)`, at :math:`c = (T_l^2 + T_l T_r) K_l / (2 B_l)`. With equal
delays nothing is given away: two free masses M, :math:`M s^2 + B s + K (1 + e^{-s T}) = 0`, have
roots to the right just below the bound once M is large.
"""

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
    """`PositionDamping` in a kernel, in the master's units."""

    stiffness: float
    damping: float


class Position(NamedTuple):
    """Payload up and down: position of the sender (3,) [m]."""

    x: Array


class SlaveMemory(NamedTuple):
    """Position [m] and force of the coupling [N] of the last tick at the slave, each (3,)."""

    x: Array
    f: Array


GAINS, POSITION, SLAVE_MEMORY = Layout(Gains), Layout(Position, x=3), Layout(SlaveMemory, x=3, f=3)
gains_of, position_of, slave_memory_of = GAINS.reader(), POSITION.reader(), SLAVE_MEMORY.reader()


def damping_margin(stiffness: float, damping: float, up: float, down: float) -> float:
    """Return 4 B² / ((T_l + T_r)² K²), above 1 where the condition holds; infinite at no delay.

    Args:
        stiffness: K of both ends [N/m].
        damping: B of both ends [N s/m].
        up: longest delay to the slave [s].
        down: longest delay to the master [s].
    """
    demand = (up + down) ** 2 * stiffness**2
    return np.inf if demand == 0.0 else 4.0 * damping * damping / demand


@njit(cache=True)
def position_master(
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
    p, newest, sent = gains_of(s.gains), position_of(s.newest), position_of(s.sent)
    for i in range(3):
        f_master[i] = p.stiffness * (s.x[i] - newest.x[i])
        f_master[i] += p.damping * s.v[i]
        sent.x[i] = s.x[i]


@njit(cache=True)
def position_slave(
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
    newest, sent = position_of(s.newest), position_of(s.sent)
    for i in range(3):
        meter(energy_slave, i, -m.f[i] * (s.x[i] - m.x[i]))
        f = p.stiffness * (newest.x[i] - s.x[i]) - p.damping * s.v[i]
        m.x[i] = s.x[i]
        m.f[i] = f
        admit(i, f, s, tool_command)
        sent.x[i] = s.x[i]


@dataclass
class PositionDamping(Coupling):
    """P+d; both gains are at the tool, and the master has them times the scales.

    The defaults are within the condition for delays of up to 0.6 s there and back.

    Attributes:
        stiffness: K of both springs.
        damping: B of both dampers.
    """

    stiffness: float = number(100.0, "N/m", 0.0, 1e5)
    damping: float = number(30.0, "N s/m", 0.0, 1e4)

    def margin(self, up: float, down: float) -> float:
        """Return the `damping_margin` for the longest delays up and down [s]."""
        return damping_margin(self.stiffness, self.damping, up, down)

    def asked_damping(self) -> float:
        """That of the device [N s/m]; it is not cut, for the condition needs it."""
        return self.impedance_scale * self.damping

    def exchange(self) -> Exchange:
        """What the kind sends, remembers and does."""
        place = ((POSITION.slices["x"], "place"),)
        return Exchange(
            POSITION,
            POSITION,
            position_master,
            position_slave,
            slave_memory=SLAVE_MEMORY,
            felt_up=place,
            felt_down=place,
        )

    def parameters(self, period: float) -> Array:
        """The gains in the master's units."""
        scale = self.impedance_scale
        return GAINS.pack(stiffness=scale * self.stiffness, damping=scale * self.damping)
