"""Direct position-force coupling: the slave's position is the master's, the force comes back.

No energy is accounted for. With a slave that is always where it should be it is just stable without
delay, and against a stiff wall bears a few milliseconds there and back. An arm's own lag is more
than that, so it is unstable then over any channel, which is why the other kinds exist; a small
`force_scale` is the first thing that helps.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.fields import number
from scara_drake.common.layout import Layout
from scara_drake.coupling.ends import Coupling, Exchange
from scara_drake.coupling.kernels import command, master_tick, meter, slave_tick

Array = NDArray[np.float64]


class Up(NamedTuple):
    """Payload to the slave: position of the device (3,) [m]."""

    x: Array


class Down(NamedTuple):
    """Payload to the master: force of the environment (3,) [N]."""

    f: Array


class SlaveMemory(NamedTuple):
    """Position [m] and force [N] of the last tick at the slave, each (3,)."""

    x: Array
    f: Array


UP, DOWN, SLAVE_MEMORY = Layout(Up, x=3), Layout(Down, f=3), Layout(SlaveMemory, x=3, f=3)
up_of, down_of, slave_memory_of = UP.reader(), DOWN.reader(), SLAVE_MEMORY.reader()


@njit(cache=True)
def direct_master(
    motion_master: Array,
    packet_from_slave: Array,
    constants: Array,
    memory: Array,
    packet_to_slave: Array,
    f_master: Array,
    energy_master: Array,
) -> None:
    """One tick at the master: show the force, send the position."""
    s = master_tick(
        motion_master, packet_from_slave, constants, memory, packet_to_slave, f_master,
        energy_master,
    )  # fmt: skip
    f_master[:] = down_of(s.newest).f
    up_of(s.sent).x[:] = s.x


@njit(cache=True)
def direct_slave(
    packet_from_master: Array,
    f_env_on_tool_W: Array,
    motion_limited: Array,
    constants: Array,
    memory: Array,
    packet_to_master: Array,
    tool_command: Array,
    energy_slave: Array,
) -> None:
    """One tick at the slave: go to the position; the port is that of the environment."""
    s = slave_tick(
        packet_from_master, f_env_on_tool_W, motion_limited, constants, memory, packet_to_master
    )
    m, newest, sent = slave_memory_of(s.memory), up_of(s.newest), down_of(s.sent)
    for i in range(3):
        meter(energy_slave, i, -m.f[i] * (s.x[i] - m.x[i]))
        m.x[i] = s.x[i]
        m.f[i] = s.f_env[i]
        sent.f[i] = s.f_env[i]
        command(i, newest.x[i], s.end, tool_command)


@dataclass
class Direct(Coupling):
    """Position up, force of the environment down; `virtual_mass` has no meaning here."""

    def exchange(self) -> Exchange:
        """What the kind sends, remembers and does."""
        return Exchange(
            UP,
            DOWN,
            direct_master,
            direct_slave,
            slave_memory=SLAVE_MEMORY,
            felt_up=((UP.slices["x"], "place"),),
            felt_down=((DOWN.slices["f"], "force"),),
        )

    def parameters(self, period: float) -> Array:
        """None."""
        return np.zeros(0)


@dataclass
class ScaledForce(Direct):
    """`Direct` with a tenth of the force.

    Attributes:
        force_scale: force at the device over that at the tool.
    """

    force_scale: float = number(0.1, "1", 1e-6, 100.0)
