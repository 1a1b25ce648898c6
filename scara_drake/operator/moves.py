"""The mind of a scripted operator, as kernels: what he makes of what he sees and feels.

He works in single moves, as people do: he looks, moves the stick by what is missing, and looks
again. How long a move takes to be seen he learns from the moves he makes, so under delay he moves
and waits (Ferrell, 1965), as far as his patience goes.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.layout import REST, Cell, Layout
from scara_drake.operator.aiming import dot, hold_stick, leg_done, next_move, scatter
from scara_drake.operator.skills import leg_of, person_of

Array = NDArray[np.float64]

SEEN: Final = 0.01  # [m], a shorter move is not timed
NOTICED: Final = 0.2  # of a move: it is seen to have begun
AT_REST: Final = 0.001  # [m], that the tool moves within a reaction
SHORTEST: Final = 0.12  # [s], of a move
PEAK: Final = 1.875  # of a minimum-jerk move: its peak speed by its mean
OWN_LAG: Final = 0.1  # [s], of a station without delay, beside the reaction
LOST: Final = 6.0  # [s], a move that has not been seen by then is given up
MOVING, WAITING, DONE = 0.0, 1.0, 2.0


class Mind(NamedTuple):
    """What he remembers.

    Attributes:
        leg: that he is at.
        phase: MOVING, WAITING or DONE.
        since: when the phase began [s].
        lasts: the move [s].
        lag: from the begin of a move until it is seen [s], as he last met it.
        timed: when the move that he times began [s]; negative for none.
        arrived: when the leg began to look done [s]; negative while it does not.
        moves: how many he has made.
        aim: where the stick asks the tool to be (3,) [m].
        begun: where the move began (3,) [m].
        move: the move (3,) [m].
        looked: where the tool was seen when the timed move began (3,) [m].
        start: where the leg began (3,) [m].
        history: what was seen and felt (6,), the newest first.
    """

    leg: Cell
    phase: Cell
    since: Cell
    lasts: Cell
    lag: Cell
    timed: Cell
    arrived: Cell
    moves: Cell
    aim: Array
    begun: Array
    move: Array
    looked: Array
    start: Array
    history: Array


MIND = Layout(
    Mind,
    leg=(),
    phase=(),
    since=(),
    lasts=(),
    lag=(),
    timed=(),
    arrived=(),
    moves=(),
    aim=3,
    begun=3,
    move=3,
    looked=3,
    start=3,
    history=REST,
)
mind_of = MIND.reader()


@njit(cache=True)
def begin_move(t: float, leg: Array, person: Array, seen: Array, mind: Array) -> None:
    """Begin the move that is in the mind, and time it if it is long and none is being timed."""
    g, s, m = leg_of(leg), person_of(person), mind_of(mind)
    length = math.sqrt(dot(m.move, m.move))
    near = dot(g.normal, g.normal) > 0.0 or g.stride < 1.0
    speed = min(s.near_speed if near else s.max_speed, g.speed * s.haste)
    m.lasts[()] = max(PEAK * length / speed, SHORTEST)
    m.phase[()], m.since[()] = MOVING, t
    m.moves[()] += 1.0
    m.begun[:] = m.aim
    if length >= SEEN and m.timed[()] < 0.0:
        m.timed[()] = t
        m.looked[:] = seen


@njit(cache=True)
def watch_move(t: float, reaction: float, seen: Array, mind: Array) -> None:
    """Learn how long a move takes to be seen, from the one that is being timed."""
    m = mind_of(mind)
    if m.timed[()] < 0.0:
        return
    way = 0.0
    for i in range(3):
        way += (seen[i] - m.looked[i]) ** 2
    if math.sqrt(way) >= NOTICED * SEEN or t - m.timed[()] > LOST:
        met = max(t - m.timed[()], reaction + OWN_LAG)
        m.lag[()] = max(met, 0.5 * (m.lag[()] + met))
        m.timed[()] = -1.0


@njit(cache=True)
def see(tool_seen: Array, f_haptic: Array, history: Array) -> None:
    """Move what is seen and felt into the history, whose oldest falls out."""
    for k in range(history.size - 1, 5, -1):
        history[k] = history[k - 6]
    history[:3], history[3:6] = tool_seen, f_haptic


@njit(cache=True)
def start_work(tool_seen: Array, f_haptic: Array, mind: Array) -> None:
    """Write the first memory: he has seen the tool where it is, at rest."""
    m = mind_of(mind)
    for k in range(0, m.history.size, 6):
        m.history[k : k + 3], m.history[k + 3 : k + 6] = tool_seen, f_haptic
    m.start[:] = tool_seen


@njit(cache=True)
def carry_on(t: float, mind: Array) -> None:
    """Move the stick along a move of minimum jerk; at its end begin to wait."""
    m = mind_of(mind)
    share = min((t - m.since[()]) / m.lasts[()], 1.0)
    gone = share**3 * (10.0 - 15.0 * share + 6.0 * share * share)
    for i in range(3):
        m.aim[i] = m.begun[i] + gone * m.move[i]
    if share >= 1.0:
        m.phase[()], m.since[()] = WAITING, t


@njit(cache=True)
def decide(t: float, plan: Array, person: Array, seed: int, mind: Array) -> None:
    """End a leg that looks done, and begin the next move."""
    m = mind_of(mind)
    late = m.history[m.history.size - 6 :]  # what he acts on, a reaction ago
    seen, felt = late[:3], late[3:]
    leg = plan[int(m.leg[()])]
    if not leg_done(leg, seen, felt):
        m.arrived[()] = -1.0
    else:
        m.arrived[()] = t if m.arrived[()] < 0.0 else m.arrived[()]
        if t - m.arrived[()] < leg_of(leg).stay:
            return
        m.start[:] = leg[:3]
        m.leg[()] += 1.0
        m.arrived[()] = -1.0
    if m.leg[()] >= plan.shape[0]:
        m.phase[()] = DONE
        return
    leg = plan[int(m.leg[()])]
    next_move(leg, person, m.start, seen, felt, m.move)
    scatter(leg, person, seed, int(m.moves[()]), m.move)
    begin_move(t, leg, person, seen, mind)


@njit(cache=True)
def is_ready(t: float, patience: float, mind: Array) -> bool:
    """Whether he makes his next move: a patient one has seen the last, and the tool at rest."""
    m = mind_of(mind)
    if m.phase[()] != WAITING or t < m.since[()] + patience * m.lag[()]:
        return False
    if patience < 1.0:
        return True
    way, old = 0.0, m.history.size - 6
    for i in range(3):
        way += (m.history[i] - m.history[old + i]) ** 2
    return m.timed[()] < 0.0 and math.sqrt(way) < AT_REST


@njit(cache=True)
def work(
    t: float,
    tool_seen: Array,
    f_haptic: Array,
    plan: Array,
    person: Array,
    seed: int,
    mind: Array,
    joystick_axes: Array,
) -> None:
    """Update of `TraineeSource`: see, finish or begin a move, hold the stick."""
    s, m = person_of(person), mind_of(mind)
    see(tool_seen, f_haptic, m.history)
    watch_move(t, s.reaction, m.history[m.history.size - 6 :], mind)
    if m.phase[()] == MOVING:
        carry_on(t, mind)
    elif is_ready(t, s.patience, mind):
        decide(t, plan, person, seed, mind)
    hold_stick(t, m.aim, person, joystick_axes)
