"""Couplings with a planted fault, which a red team has to find."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.layout import Layout
from scara_drake.coupling.ends import Exchange
from scara_drake.coupling.layouts import packet_of
from scara_drake.coupling.tdpa import DOWN, SLAVE_MEMORY, UP, Tdpa, tdpa_master, tdpa_slave

Array = NDArray[np.float64]


class ForgetfulMemory(NamedTuple):
    """TDPA's memory, and the energy that was counted again (3,) [J]."""

    x_d: Array
    f: Array
    v_held: Array
    again: Array


FORGETFUL_MEMORY = Layout(ForgetfulMemory, x_d=3, f=3, v_held=3, again=3)
up_of, memory_of = UP.reader(), FORGETFUL_MEMORY.reader()


@njit(cache=True)
def credulous_slave(
    packet_from_master: Array,
    f_env_on_tool_W: Array,
    motion_limited: Array,
    constants: Array,
    memory: Array,
    packet_to_master: Array,
    tool_command: Array,
    energy_slave: Array,
) -> None:
    """As TDPA's, but the energy of every packet is counted twice."""
    twice = packet_from_master.copy()
    up_of(packet_of(twice).payload).e_in[:] *= 2.0
    tdpa_slave(
        twice, f_env_on_tool_W, motion_limited, constants, memory, packet_to_master, tool_command,
        energy_slave,
    )  # fmt: skip


@njit(cache=True)
def forgetful_slave(
    packet_from_master: Array,
    f_env_on_tool_W: Array,
    motion_limited: Array,
    constants: Array,
    memory: Array,
    packet_to_master: Array,
    tool_command: Array,
    energy_slave: Array,
) -> None:
    """As TDPA's, but what a packet brings is counted twice where one before it is missing."""
    size = packet_from_master.size
    again = memory_of(memory[size:]).again
    last, twice = packet_of(memory[:size]), packet_from_master.copy()
    arrived = packet_of(twice)
    told, known = up_of(arrived.payload).e_in, up_of(last.payload).e_in
    skipped = arrived.number[()] > last.number[()] + 1.0 and last.number[()] > 0.0
    for i in range(3):
        if skipped:
            again[i] += told[i] - (known[i] - again[i])
        told[i] += again[i]
    tdpa_slave(
        twice, f_env_on_tool_W, motion_limited, constants, memory, packet_to_master, tool_command,
        energy_slave,
    )  # fmt: skip


@dataclass
class Credulous(Tdpa):
    """TDPA whose slave counts the energy of every packet twice."""

    def exchange(self) -> Exchange:
        """What it does."""
        return Exchange(UP, DOWN, tdpa_master, credulous_slave, slave_memory=SLAVE_MEMORY)


@dataclass
class Forgetful(Tdpa):
    """TDPA whose slave counts a packet's energy twice where one before it is missing."""

    def exchange(self) -> Exchange:
        """What it does."""
        return Exchange(UP, DOWN, tdpa_master, forgetful_slave, slave_memory=FORGETFUL_MEMORY)
