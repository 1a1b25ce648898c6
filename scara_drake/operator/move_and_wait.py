"""The strategy of Ferrell's operators, as kernels: a move, a wait until it was seen, a move."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.draws import normal
from scara_drake.common.scratch import scratch
from scara_drake.operator.aiming import TOUCHED, dot, unit_from
from scara_drake.operator.moves import (
    AT_REST,
    DONE,
    MOVING,
    PEAK,
    SEEN,
    SHORTEST,
    WAITING,
    carry_on,
    is_ready,
    mind_of,
    watch_move,
)
from scara_drake.operator.policy_sense import (
    DRAWS,
    ends_stage,
    late_force,
    look,
    pressing,
    sense_of,
    stage_at,
    stage_of,
    take_tool_to_be,
    worker_of,
)

Array = NDArray[np.float64]

SOFTEST: Final = 0.2  # of the hand's stiffness: nothing is taken to be softer
TELLING: Final = 0.001  # [m], a shorter move says nothing of a stiffness


@njit(cache=True)
def move_into(stage: Array, draw: int, worker: Array, mind: Array, sense: Array) -> float:
    """Return how far to move into the surface [m], by the force that is felt.

    Before the touch as far as makes no more than `caution`; then by the force that is missing, over
    the stiffness that the last move in contact has shown.
    """
    g, w, m, s = stage_of(stage), worker_of(worker), mind_of(mind), sense_of(sense)
    pressed, depth = pressing(stage, worker, mind, draw), -dot(m.aim, g.normal)
    if pressed < TOUCHED:
        s.pressed[()] = 0.0
        return w.caution / s.stiffness[()]
    way = depth - s.depth[()]
    if s.pressed[()] > 0.0 and abs(way) > TELLING:
        met = max((pressed - s.pressed[()]) / way, SOFTEST * w.hand_stiffness)
        s.stiffness[()] = min(0.5 * (s.stiffness[()] + met), w.hand_stiffness)
    s.pressed[()], s.depth[()] = pressed, depth
    return w.gain * (g.force - pressed) / s.stiffness[()]


@njit(cache=True)
def plan_move(
    stage: Array, believed: Array, draw: int, worker: Array, mind: Array, sense: Array
) -> None:
    """Write the next move into the mind, with the scatter of the aim.

    One to a place also takes back what the hand is ahead of the device by the force in it.
    """
    g, w, m = stage_of(stage), worker_of(worker), mind_of(mind)
    if dot(g.normal, g.normal) > 0.0:
        m.move[:] = -move_into(stage, draw, worker, mind, sense) * g.normal
    else:
        held = late_force(mind)
        for i in range(3):
            m.move[i] = w.gain * (g.place[i] - believed[i]) - held[i] / w.hand_stiffness
    length = math.sqrt(dot(m.move, m.move))
    for i in range(3):
        scatter = normal(int(w.seed), DRAWS * draw + i)
        m.move[i] += scatter * math.hypot(w.aim, w.spread * length)


@njit(cache=True)
def begin(t: float, timed: bool, worker: Array, mind: Array) -> None:
    """Begin the move that is in the mind, and time it if it is long and none is being timed.

    One from or into a touch is not timed: the surface may keep it from being seen.
    """
    w, m = worker_of(worker), mind_of(mind)
    length = math.sqrt(dot(m.move, m.move))
    m.lasts[()] = max(PEAK * length / w.max_speed, SHORTEST)
    m.phase[()], m.since[()] = MOVING, t
    m.moves[()] += 1.0
    m.begun[:] = m.aim
    if timed and length >= SEEN and m.timed[()] < 0.0:
        m.timed[()] = t
        m.looked[:] = m.history[m.history.size - 6 : m.history.size - 3]


@njit(cache=True)
def rests(t: float, worker: Array, mind: Array, sense: Array) -> bool:
    """Whether he is ready for the next move, and has seen the tool at rest for a reaction."""
    w, m, s = worker_of(worker), mind_of(mind), sense_of(sense)
    way = scratch(3)
    if unit_from(m.history[m.history.size - 6 : m.history.size - 3], m.history[:3], way) > AT_REST:
        s.moved[()] = t
    trusted = s.moved[()] if w.trust == 1.0 else m.since[()]
    return t >= max(trusted, m.since[()]) + w.reaction and is_ready(t, w.trust, mind)


@njit(cache=True)
def decide(t: float, motion_master: Array, worker: Array, mind: Array, sense: Array) -> None:
    """End a stage that looks done, and begin the next move."""
    m, believed = mind_of(mind), scratch(3)
    take_tool_to_be(motion_master, worker, mind, believed)
    draw = int(m.moves[()])
    judged = ends_stage(t, believed, draw, worker, mind, sense)
    if judged == 1 or m.phase[()] == DONE:
        return
    stage = stage_at(mind, worker)
    plan_move(stage, believed, draw, worker, mind, sense)
    normal_, held = stage_of(stage).normal, late_force(mind)
    free = dot(normal_, normal_) == 0.0 and dot(held, held) < TOUCHED**2
    begin(t, free, worker, mind)


@njit(cache=True)
def move_and_wait(
    t: float,
    tool_seen: Array,
    age_seen: Array,
    motion_master: Array,
    f_hand: Array,
    worker: Array,
    mind: Array,
    sense: Array,
) -> None:
    """Update of `OperatorPolicy` by `MoveAndWait`, in place."""
    w, m = worker_of(worker), mind_of(mind)
    looks = look(t, tool_seen, age_seen, f_hand, worker, mind, sense)
    if sense_of(sense).frozen[()] > 0.0:
        if m.phase[()] == MOVING:
            m.phase[()], m.since[()] = WAITING, t
        return
    if looks:
        late = m.history.size - 6
        watch_move(t, w.reaction, m.history[late : late + 3], mind)
    if m.phase[()] == MOVING:
        carry_on(t, mind)
    elif looks and rests(t, worker, mind, sense):
        decide(t, motion_master, worker, mind, sense)
