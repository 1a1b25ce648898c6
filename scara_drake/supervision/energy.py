"""What energy the channel takes and gives, between a command and the force that answers it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from scara_drake.common.block import Block, Declaration, Input, Memory
from scara_drake.common.layout import Layout
from scara_drake.supervision.layouts import CHANNEL_ENERGY, channel_energy_of
from scara_drake.vectors import TOOL_COMMAND, tool_command_of

Array = NDArray[np.float64]


class Ends(NamedTuple):
    """The commanded tool points of the last tick (3,) [m]: as sent, and as let through."""

    sent: Array
    followed: Array


ENDS = Layout(Ends, sent=3, followed=3)
ends_of = ENDS.reader()


@njit(cache=True)
def add_work(force: Array, p: Array, before: Array, gives: bool, channel_energy: Array) -> None:
    """Account for the work -f dp of a tick at one end, in place; `before` becomes `p`.

    At the operator's end work above zero is taken from him, at the robot's (`gives`) it is given.
    """
    energy, work = channel_energy_of(channel_energy), 0.0
    for i in range(3):
        work -= force[i] * (p[i] - before[i])
        before[i] = p[i]
    if not np.isfinite(work):
        return
    if (work > 0.0) == gives:
        energy.given[()] += abs(work)
    else:
        energy.taken[()] += abs(work)


@njit(cache=True)
def measure_energy(
    tool_command: Array,
    f_haptic: Array,
    tool_command_supervised: Array,
    f_env_on_tool_W: Array,
    ends: Array,
    channel_energy: Array,
) -> None:
    """One tick of `ChannelEnergy`, in place."""
    last = ends_of(ends)
    sent, followed = tool_command_of(tool_command).p, tool_command_of(tool_command_supervised).p
    add_work(f_haptic, sent, last.sent, False, channel_energy)
    add_work(f_env_on_tool_W, followed, last.followed, True, channel_energy)


class ChannelEnergy(Block):
    """Measures the energy that the channel takes and gives, at both of its ends.

    What is measured: at the operator's end the force that arrives against the travel of the command
    that is sent; at the robot's the force of the contact against the travel of the command that is
    followed, after its supervisor. With a force f and a travel dp of a tick the work is -f dp: at
    the operator's end taken where it is above zero, given where it is below; at the robot's the
    other way round. Both ends are read at one instant, as only a simulation can; on a real robot
    what was taken has to be sent along. It is the energy of the command, not that of a hand: a
    joystick that does not push takes none.

    Ports:
        input tool_command (8), f_haptic (3) [N]: at the operator's end.
        input tool_command_supervised (8), f_env_on_tool_W (3) [N]: at the robot's.
        output channel_energy (2) [J]: see `layouts.ChannelEnergy`.

    Update, at t = k period: as above. Initial: zero.

    Args:
        initial: (8,) the first command.
        period: [s].
    """

    def __init__(self, initial: ArrayLike, period: float = 1e-3) -> None:
        p = TOOL_COMMAND.unpack(np.array(initial, dtype=np.float64)).p
        super().__init__(
            Declaration(
                inputs={
                    "tool_command": Input(TOOL_COMMAND.size),
                    "f_haptic": Input(3),
                    "tool_command_supervised": Input(TOOL_COMMAND.size),
                    "f_env_on_tool_W": Input(3),
                },
                memory={
                    "channel_energy": Memory(CHANNEL_ENERGY.size, port=True),
                    "ends": Memory(ENDS.pack(sent=p, followed=p)),
                },
                period=period,
                update=measure_energy,
            )
        )
