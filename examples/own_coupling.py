"""A coupling of your own: the hand feels at most F, however hard the robot presses.

A coupling is the layouts of what crosses the channel, a law at each end, and a dataclass with its
gains. Here the position of the device goes up, and the force of the wall comes down through

    f_master = F tanh(f_env / F) + B v_master

    python examples/own_coupling.py
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

import scara_drake as sd
from scara_drake.common.fields import ABOVE_ZERO, number
from scara_drake.common.layout import Layout
from scara_drake.coupling.ends import Coupling, Exchange
from scara_drake.coupling.kernels import command, master_tick, slave_tick


class Payload(NamedTuple):
    """What crosses: up the position of the device, down the force of the wall (3,) [m, N]."""

    value: np.ndarray


class Gains(NamedTuple):
    """`GentleForce` in the laws: F [N] and B [N s/m]."""

    largest: float
    damping: float


PAYLOAD, GAINS = Layout(Payload, value=3), Layout(Gains)
payload_of, gains_of = PAYLOAD.reader(), GAINS.reader()  # they give the entries their names


# The names of the arguments say what the laws read and write; see `MasterEnd` and `SlaveEnd`.
@njit
def at_master(
    motion_master, packet_from_slave, constants, memory, packet_to_slave, f_master, energy_master
):
    """One tick: show the force that has come, send the position."""
    s = master_tick(
        motion_master, packet_from_slave, constants, memory, packet_to_slave, f_master,
        energy_master,
    )  # fmt: skip
    gains = gains_of(s.gains)
    f = payload_of(s.newest).value
    f_master[:] = gains.largest * np.tanh(f / gains.largest) + gains.damping * s.v
    payload_of(s.sent).value[:] = s.x


@njit
def at_slave(
    packet_from_master, f_env_on_tool_W, motion_limited, constants, memory, packet_to_master,
    tool_command, energy_slave,
):  # fmt: skip
    """One tick: go to the position that has come, send the force; `energy_slave` stays zero."""
    s = slave_tick(
        packet_from_master, f_env_on_tool_W, motion_limited, constants, memory, packet_to_master
    )
    for axis in range(3):
        command(axis, payload_of(s.newest).value[axis], s.end, tool_command)
    payload_of(s.sent).value[:] = s.f_env


@dataclass
class GentleForce(Coupling):
    """Position up, a force of at most F down.

    Attributes:
        largest: F.
        damping: B, of the device.
    """

    largest: float = number(4.0, "N", ABOVE_ZERO, 100.0)
    damping: float = number(10.0, "N s/m", 0.0, 1e3)

    def exchange(self) -> Exchange:
        """What crosses, and the laws."""
        return Exchange(up=PAYLOAD, down=PAYLOAD, master=at_master, slave=at_slave)

    def parameters(self, period: float) -> np.ndarray:
        """Return the gains, as both laws read them."""
        return GAINS.pack(largest=self.largest, damping=self.damping)


coupling = GentleForce()
scenario = sd.load_scenario("bilateral")
scenario.coupling = coupling  # type: ignore[assignment]  # the union has shipped kinds

recording = sd.simulate(scenario, duration=4.0).sel(axis="y")
f_env, f_master, v = -recording.f_env_on_tool_W, recording.f_master, recording.v_master
print(f"largest force on the tool       {float(abs(f_env).max()):7.2f} N")
shown = abs(f_master - coupling.damping * v.shift(time=1))  # v of the tick before
print(f"largest shown, but for B v      {float(shown.max()):7.3f} N, F is {coupling.largest:g} N")
# The law, worked out again from the force at the wall; on its way are the delay and the blocks.
ticks = round(scenario.channel.down.maximum() / scenario.time_step) + 3
law = coupling.largest * np.tanh(f_env.shift(time=ticks, fill_value=0.0) / coupling.largest)
off = float(abs(f_master - coupling.damping * v.shift(time=1) - law).max())
print(f"largest distance from the law   {off:7.1e} N")
