"""A watch over the command: when it counts as lost, and what follows when it comes again."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from scara_drake.channel.delays import LONGEST
from scara_drake.common.block import Block, Declaration, Input, Memory
from scara_drake.common.fields import ABOVE_ZERO, check, choice, number
from scara_drake.common.layout import Layout
from scara_drake.vectors import TOOL_COMMAND, tool_command_of

Array = NDArray[np.float64]

AFTERWARDS: Final = ("follow", "hold", "catch_up")
FOLLOW, HOLD, CATCH_UP = range(len(AFTERWARDS))
# Values of `command_watch`.
IN_USE, LOST, RETURNING = 0.0, 1.0, 2.0


@dataclass
class CommandWatch:
    """When the command counts as lost, and what follows when it comes again.

    While it is lost the last one stands. Afterwards "follow" takes the new command at once, at the
    full speed of the limiter; "hold" stays until the operator is back within `near` of where the
    tool was left; "catch_up" goes to the new command with `speed`.

    Attributes:
        age_limit: time without a packet from which on the command counts as lost.
        afterwards: what follows, "follow", "hold" or "catch_up".
        near: for "hold": distance of the new command from the last one, a turn of 1 rad as 1 m.
        speed: for "catch_up": of the tool point and of the mast, and of a turn in rad/s.
    """

    age_limit: float = number(0.5, "s", ABOVE_ZERO, LONGEST)
    afterwards: str = choice("hold", AFTERWARDS)
    near: float = number(0.02, "m", ABOVE_ZERO, 1.0)
    speed: float = number(0.1, "m/s", ABOVE_ZERO, 100.0)

    def make_system(self, initial: ArrayLike, period: float) -> CommandWatchSystem:
        """Return the watch over a tool command that starts from `initial` (8,)."""
        return CommandWatchSystem(self, initial, period)


class Watch(NamedTuple):
    """`CommandWatch` in a kernel; `step` is the way of a period [m]."""

    age_limit: float
    afterwards: float
    near: float
    step: float


WATCH = Layout(Watch)
watch_of = WATCH.reader()


@njit(cache=True)
def command_distance(one: Array, other: Array) -> float:
    """Distance of two tool commands (8,) [m], the largest of its kinds; 1 rad counts as 1 m."""
    a, b = tool_command_of(one), tool_command_of(other)
    way = np.sqrt(np.sum((a.p - b.p) ** 2))
    turn = 2.0 * np.arccos(min(abs(np.sum(a.quaternion * b.quaternion)), 1.0))
    return max(way, turn, abs(a.mast[()] - b.mast[()]))


@njit(cache=True)
def move_towards(target: Array, share: float, command: Array) -> None:
    """Move a tool command (8,) in place by a share, 0 to 1, of the way to another."""
    now, wanted = tool_command_of(command), tool_command_of(target)
    side = 1.0 if np.sum(now.quaternion * wanted.quaternion) >= 0.0 else -1.0
    for i in range(3):
        now.p[i] += share * (wanted.p[i] - now.p[i])
    for i in range(4):
        now.quaternion[i] += share * (side * wanted.quaternion[i] - now.quaternion[i])
    now.quaternion[:] = now.quaternion / np.sqrt(np.sum(now.quaternion * now.quaternion))
    now.mast[()] += share * (wanted.mast[()] - now.mast[()])


@njit(cache=True)
def watch_step(
    tool_command: Array,
    age: Array,
    delay: Array,
    watch: Array,
    tool_command_watched: Array,
    command_watch: Array,
) -> None:
    """One tick of `CommandWatchSystem`, in place."""
    p = watch_of(watch)
    if age[0] - delay[0] > p.age_limit:
        command_watch[0] = LOST
        return
    if command_watch[0] != IN_USE:
        command_watch[0] = RETURNING
        distance = command_distance(tool_command, tool_command_watched)
        if int(p.afterwards) == HOLD and distance > p.near:
            return
        if int(p.afterwards) == CATCH_UP and distance > p.step:
            move_towards(tool_command, p.step / distance, tool_command_watched)
            return
    command_watch[0] = IN_USE
    tool_command_watched[:] = tool_command


class CommandWatchSystem(Block):
    """Lets the command pass, but for one that is too old.

    Ports:
        input tool_command (8): after the channel.
        input age (1), delay (1) [s]: of the packet in use.
        output tool_command_watched (8).
        output command_watch (1): 0 the command passes, 1 it is lost, 2 it is there again and is
            waited for, or approached.

    Update, at t = k period: where age - delay, the time since the packet in use arrived, exceeds
    `age_limit`, the output is held; afterwards see `CommandWatch`.
    Initial: tool_command_watched = `initial`, command_watch = 0. It costs one tick.

    Args:
        config: checked.
        initial: (8,).
        period: [s].

    Raises:
        ValueError: a field is out of its bounds.
    """

    def __init__(self, config: CommandWatch, initial: ArrayLike, period: float = 1e-3) -> None:
        check(config, "watch")
        super().__init__(
            Declaration(
                inputs={
                    "tool_command": Input(TOOL_COMMAND.size),
                    "age": Input(1),
                    "delay": Input(1),
                },
                memory={
                    "tool_command_watched": Memory(initial, port=True),
                    "command_watch": Memory(1, port=True),
                },
                parameters={
                    "watch": WATCH.pack(
                        age_limit=config.age_limit,
                        afterwards=AFTERWARDS.index(config.afterwards),
                        near=config.near,
                        step=config.speed * period,
                    )
                },
                period=period,
                update=watch_step,
            )
        )
