"""What an operator who reacts knows: his work, and what he sees and feels, as kernels.

The picture and the force reach his mind a reaction late. He sees whether the picture gets newer:
one that stands still for as long as his reaction tells nothing any more.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.draws import normal
from scara_drake.common.layout import REST, Cell, Layout
from scara_drake.operator.aiming import dot, unit_from
from scara_drake.operator.moves import DONE, mind_of, see, start_work
from scara_drake.vectors import policy_state_of

Array = NDArray[np.float64]

DRAWS: Final = 4  # random numbers of a look: three of the move, one of the judgement
FROZEN: Final = 3.0  # a phase beside those of `moves`


class Stage(NamedTuple):
    """A stage of the work: to be at a place, or, with a normal, to press with a force.

    Attributes:
        place: way of the tool from its start (3,) [m].
        normal: out of the surface (3,); zero to be at the place.
        force: to press with [N].
        tolerance: of the place [m] or of the force [N].
        stay: how long it is to look right [s].
    """

    place: Array
    normal: Array
    force: float
    tolerance: float
    stay: float


class Worker(NamedTuple):
    """Who works, how, and at what.

    Attributes:
        reaction: [s].
        trust: in the picture.
        weber_view: of a distance.
        weber_force: of a force.
        aim: [m].
        spread: of a move.
        max_speed: [m/s].
        gain: `correction` of a move, or the gain of the loop [1/s].
        hand_stiffness: [N/m].
        scale: of the tool's way to the master's.
        period: [s].
        ticks: from look to look.
        seed: of all that scatters.
        caution: [N].
        approach: [m/s].
        first: p_WE at the start (3,) [m].
        plan: stages (n `STAGE.size`,).
    """

    reaction: float
    trust: float
    weber_view: float
    weber_force: float
    aim: float
    spread: float
    max_speed: float
    gain: float
    hand_stiffness: float
    scale: float
    period: float
    ticks: float
    seed: float
    caution: float
    approach: float
    first: Array
    plan: Array


class Sense(NamedTuple):
    """What he remembers beside a `Mind`.

    Attributes:
        stamp: when the newest picture was taken [s].
        fresh: when it came [s].
        frozen: whether the picture stands still.
        moved: when the tool was last seen to move [s].
        done_at: when the last stage was done [s]; negative before.
        stiffness: that he last met [N/m].
        pressed: force when he last decided [N]; zero where he touched nothing.
        depth: of the hand along the normal then [m].
    """

    stamp: Cell
    fresh: Cell
    frozen: Cell
    moved: Cell
    done_at: Cell
    stiffness: Cell
    pressed: Cell
    depth: Cell


STAGE = Layout(Stage, place=3, normal=3)
WORKER = Layout(Worker, first=3, plan=REST)
SENSE = Layout(Sense, **dict.fromkeys(Sense._fields, ()))
STAGE_SIZE: Final = STAGE.size
stage_of, worker_of, sense_of = STAGE.reader(), WORKER.reader(), SENSE.reader()


@njit(cache=True)
def stage_at(mind: Array, worker: Array) -> Array:
    """Return the stage that he is at, a row of `STAGE`."""
    row = int(mind_of(mind).leg[()]) * STAGE_SIZE
    return worker_of(worker).plan[row : row + STAGE_SIZE]


@njit(cache=True)
def start_looking(tool_seen: Array, f_hand: Array, worker: Array, mind: Array) -> None:
    """Write the first memory: the tool has been seen where it is, at rest."""
    w = worker_of(worker)
    start_work((tool_seen - w.first) / w.scale, f_hand, mind)


@njit(cache=True)
def look(
    t: float,
    tool_seen: Array,
    age_seen: Array,
    f_hand: Array,
    worker: Array,
    mind: Array,
    sense: Array,
) -> bool:
    """See and feel; return whether this is a tick of a look, every so many.

    The hand that follows is two ticks behind, and is to rest within the reaction.
    """
    w, s = worker_of(worker), sense_of(sense)
    taken = t - age_seen[0]
    if taken > s.stamp[()] + 0.5 * w.period:
        s.stamp[()], s.fresh[()] = taken, t
    s.frozen[()] = 1.0 if t - s.fresh[()] > w.reaction - 2.5 * w.period else 0.0
    if round(t / w.period) % int(w.ticks) != 0:
        return False
    see((tool_seen - w.first) / w.scale, f_hand, mind_of(mind).history)
    return True


@njit(cache=True)
def late_force(mind: Array) -> Array:
    """Return the force of the hand (3,) [N], a reaction ago."""
    history = mind_of(mind).history
    return history[history.size - 3 :]


@njit(cache=True)
def take_tool_to_be(motion_master: Array, worker: Array, mind: Array, believed: Array) -> None:
    """Write where he takes the tool to be (3,) [m]: where it is seen, or where his hand is."""
    trust, history = worker_of(worker).trust, mind_of(mind).history
    late = history[history.size - 6 : history.size - 3]
    for i in range(3):
        believed[i] = trust * late[i] + (1.0 - trust) * motion_master[i]


@njit(cache=True)
def pressing(stage: Array, worker: Array, mind: Array, draw: int) -> float:
    """Return the force [N] with which he feels to press along a stage's normal."""
    w = worker_of(worker)
    pressed = -dot(late_force(mind), stage_of(stage).normal)
    return pressed * (1.0 + w.weber_force * normal(int(w.seed), DRAWS * draw + 3))


@njit(cache=True)
def off_by(stage: Array, believed: Array, worker: Array, mind: Array, draw: int) -> float:
    """Return by how much a stage looks undone: a distance [m], or a force [N]."""
    g, w = stage_of(stage), worker_of(worker)
    if dot(g.normal, g.normal) > 0.0:
        return abs(g.force - pressing(stage, worker, mind, draw))
    away = np.empty(3)
    distance = unit_from(believed, g.place, away)
    return distance * (1.0 + w.weber_view * normal(int(w.seed), DRAWS * draw + 3))


@njit(cache=True)
def ends_stage(
    t: float, believed: Array, draw: int, worker: Array, mind: Array, sense: Array
) -> int:
    """Judge the stage: return 0 for undone, 1 while it has to stay so, 2 where it has ended.

    After the last stage the phase is DONE.
    """
    m, s = mind_of(mind), sense_of(sense)
    stage = stage_at(mind, worker)
    if off_by(stage, believed, worker, mind, draw) > stage_of(stage).tolerance:
        m.arrived[()] = -1.0
        return 0
    m.arrived[()] = t if m.arrived[()] < 0.0 else m.arrived[()]
    if t - m.arrived[()] < stage_of(stage).stay:
        return 1
    m.leg[()] += 1.0
    m.arrived[()] = -1.0
    s.pressed[()] = 0.0
    if m.leg[()] * STAGE_SIZE >= worker_of(worker).plan.size:
        m.phase[()], s.done_at[()] = DONE, t
    return 2


@njit(cache=True)
def show_aim(mind: Array, hand_wanted: Array) -> None:
    """Write where the hand is to be (3,) [m]."""
    hand_wanted[:] = mind_of(mind).aim


@njit(cache=True)
def show_state(mind: Array, sense: Array, policy_state: Array) -> None:
    """Write what is told of the operator, see `PolicyState`."""
    m, s, told = mind_of(mind), sense_of(sense), policy_state_of(policy_state)
    stands = s.frozen[()] > 0.0 and m.phase[()] != DONE
    told.phase[()] = FROZEN if stands else m.phase[()]
    told.leg[()], told.done_at[()] = m.leg[()], s.done_at[()]
