"""The strategy of who follows what is missing without a pause, as kernels."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.draws import normal
from scara_drake.common.scratch import scratch
from scara_drake.operator.aiming import TOUCHED, dot
from scara_drake.operator.moves import DONE, MOVING, WAITING, mind_of
from scara_drake.operator.policy_sense import (
    DRAWS,
    ends_stage,
    look,
    pressing,
    sense_of,
    stage_at,
    stage_of,
    take_tool_to_be,
    worker_of,
)

Array = NDArray[np.float64]

RISE: Final = 0.2  # [s], from rest to the top speed


@njit(cache=True)
def wish_speed(stage: Array, believed: Array, draw: int, worker: Array, mind: Array) -> Array:
    """Return the velocity (3,) [m/s] that the hand is to have."""
    g, w = stage_of(stage), worker_of(worker)
    v = np.empty(3)
    if dot(g.normal, g.normal) > 0.0:
        pressed = pressing(stage, worker, mind, draw)
        speed = w.gain * (g.force - pressed) / w.hand_stiffness
        if pressed < TOUCHED:
            speed = w.approach
        v[:] = -min(speed, w.approach) * g.normal
    else:
        for i in range(3):
            v[i] = w.gain * (g.place[i] - believed[i])
    size = math.sqrt(dot(v, v))
    for i in range(3):
        scatter = normal(int(w.seed), DRAWS * draw + i)
        v[i] += scatter * math.hypot(w.gain * w.aim, w.spread * size)
    shrink = min(w.max_speed / max(math.sqrt(dot(v, v)), 1e-12), 1.0)
    for i in range(3):
        v[i] *= shrink
    return v


@njit(cache=True)
def steer(t: float, motion_master: Array, worker: Array, mind: Array, sense: Array) -> None:
    """Judge the stage, and turn the velocity of the hand, which is `move` of the mind.

    What scatters is drawn anew once in a reaction: `moves` counts these.
    """
    w, m, believed = worker_of(worker), mind_of(mind), scratch(3)
    if t >= m.since[()] + w.reaction:
        m.since[()] = t
        m.moves[()] += 1.0
    take_tool_to_be(motion_master, worker, mind, believed)
    draw = int(m.moves[()])
    ends_stage(t, believed, draw, worker, mind, sense)
    if m.phase[()] == DONE:
        m.move[:] = 0.0
        return
    wish = wish_speed(stage_at(mind, worker), believed, draw, worker, mind)
    most = w.ticks * w.period * w.max_speed / RISE
    for i in range(3):
        m.move[i] += min(max(wish[i] - m.move[i], -most), most)


@njit(cache=True)
def follow(
    t: float,
    tool_seen: Array,
    age_seen: Array,
    motion_master: Array,
    f_hand: Array,
    worker: Array,
    mind: Array,
    sense: Array,
) -> None:
    """Update of `OperatorPolicy` by `Continuous`, in place."""
    w, m = worker_of(worker), mind_of(mind)
    looks = look(t, tool_seen, age_seen, f_hand, worker, mind, sense)
    if m.phase[()] == DONE:
        return
    if sense_of(sense).frozen[()] > 0.0:
        m.phase[()] = WAITING
        m.move[:] = 0.0
        return
    m.phase[()] = MOVING
    if looks:
        steer(t, motion_master, worker, mind, sense)
    for i in range(3):
        m.aim[i] += w.period * m.move[i]
