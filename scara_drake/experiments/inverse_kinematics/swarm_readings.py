"""The paper's swarms under each reading that its text leaves open, one run of PSO and of DPSO each.

Apart from the package's swarms (`scara_drake.ik`), which follow one reading; under that one the two
agree to the bit. What the readings share: the mast takes part, since the arm alone reaches one
posture of Table 5; the coefficients are those of all stages; a stage begins again at the whole
inertia; the fallback draws anew.
"""

from __future__ import annotations

from statistics import fmean
from typing import Final, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.layout import Cell
from scara_drake.experiments.inverse_kinematics.swarm_law import Coefficients, Law
from scara_drake.experiments.inverse_kinematics.swarm_reported import ITERATIONS, TIMES
from scara_drake.ik.kernels.postures import Goal
from scara_drake.ik.kernels.search import REDUCTION, Box, search_box_kernel
from scara_drake.ik.kernels.swarm import Draws, draw_kernel, draw_posture_kernel
from scara_drake.ik.options import PAPER
from scara_drake.ik.result import POSITION_TOLERANCE, ROTATION_TOLERANCE
from scara_drake.kinematics import tool_pose_kernel

Array = NDArray[np.float64]

MOST_ITERATIONS: Final = 150  # of one swarm, more than twice what the paper reports
RADIUS: Final = PAPER.radius  # of PSO-2's box [rad | m]
# t_pso1 of (23): the paper's mean time of a PSO over its iterations [s]. The population drops out,
# for an iteration of PSO-1 moves as many particles as one of PSO.
ITERATION_TIME: Final = fmean(TIMES["PSO"]) / ITERATIONS["PSO"]
LARGEST_M: Final = 200  # where (23) gives more; M < N fails long before


class Stage(NamedTuple):
    """What differs from swarm to swarm.

    Attributes:
        personal: c1, 0 for the law (24).
        position_weight: [1/m].
        rotation_weight: [1/rad].
        rotation_tolerance: [rad].
        most: iterations until it must be inside the tolerances.
        after: iterations that it runs on then.
        seeded: whether the first particle is given.
    """

    personal: float
    position_weight: float
    rotation_weight: float
    rotation_tolerance: float
    most: int
    after: int
    seeded: bool


class Run(NamedTuple):
    """One run of PSO or of DPSO.

    Attributes:
        first: iterations of PSO-1, or of PSO, until it was inside its tolerances.
        second: of PSO-2.
        third: of the fallback.
        after: iterations run on behind that.
        particles: M of (23); 0 for PSO.
        stage: the swarm that answered: 1, 2 or 3; 0 where none did.
        evaluations: spent.
        position: error of the answer [m].
        rotation: [rad], in the measure of the reading.
    """

    first: int
    second: int
    third: int
    after: int
    particles: int
    stage: int
    evaluations: int
    position: float
    rotation: float


class Crowd(NamedTuple):
    """A swarm on its way.

    Attributes:
        x: postures (n, 6).
        velocity: (n, 6).
        best: personal bests (n, 6).
        costs: their objectives (n,).
        leader: global best (6,).
        leading: its objective.
        position: its error [m].
        rotation: its error [rad].
        inside: whether one has been inside the tolerances.
        p: work space (3,).
        R: work space (3, 3).
    """

    x: Array
    velocity: Array
    best: Array
    costs: Array
    leader: Array
    leading: Cell
    position: Cell
    rotation: Cell
    inside: Cell
    p: Array
    R: Array


@njit(cache=True)
def _half_turn(angle: float) -> float:
    return (angle + np.pi) % (2.0 * np.pi) - np.pi


@njit(cache=True)
def rotation_error_kernel(law: Law, R_d: Array, R: Array) -> float:
    """|O_d - O| [rad] in the measure of a reading; rotations are Rx(roll) Ry(pitch) Rz(yaw)."""
    if law.angles:
        roll = _half_turn(np.arctan2(-R_d[1, 2], R_d[2, 2]) - np.arctan2(-R[1, 2], R[2, 2]))
        pitch = np.arcsin(min(1.0, max(-1.0, R_d[0, 2]))) - np.arcsin(min(1.0, max(-1.0, R[0, 2])))
        yaw = _half_turn(np.arctan2(-R_d[0, 1], R_d[0, 0]) - np.arctan2(-R[0, 1], R[0, 0]))
        return np.sqrt(roll * roll + pitch * pitch + yaw * yaw)
    chord = 0.0
    for i in range(3):
        for k in range(3):
            chord += (R_d[i, k] - R[i, k]) ** 2
    return 2.0 * np.arcsin(min(1.0, np.sqrt(chord / 8.0)))


@njit(cache=True)
def _rank(law: Law, stage: Stage, goal: Goal, crowd: Crowd, i: int) -> None:
    """Evaluate particle i; update its best (17) and the leader (16).

    The first particle inside the tolerances leads, whatever its objective.
    """
    tool_pose_kernel(crowd.x[i], crowd.p, crowd.R)
    square = 0.0
    for k in range(3):
        square += (goal.p[k] - crowd.p[k]) ** 2
    e_p, e_w = np.sqrt(square), rotation_error_kernel(law, goal.R, crowd.R)
    cost = stage.position_weight * e_p + stage.rotation_weight * e_w
    if cost < crowd.costs[i]:
        crowd.costs[i] = cost
        crowd.best[i] = crowd.x[i]
    inside = e_p <= POSITION_TOLERANCE and e_w <= stage.rotation_tolerance
    first = inside and crowd.inside[()] == 0.0
    stands = crowd.inside[()] == 1.0 and not inside  # an answer is not given up again
    if (cost < crowd.leading[()] and not stands) or first:
        crowd.leading[()], crowd.position[()], crowd.rotation[()] = cost, e_p, e_w
        crowd.leader[:] = crowd.x[i]
        if inside:
            crowd.inside[()] = 1.0


@njit(cache=True)
def _move(
    law: Law, c: Coefficients, personal: float, inertia: float, goal: Goal, crowd: Crowd,
    state: Draws, i: int,
) -> None:  # fmt: skip
    """Move particle i by (18) or (24), and (19)."""
    lower, upper = goal.bounds.lower, goal.bounds.upper
    scale, shift = (2.0 * c.speed, -c.speed) if law.literal else (1.0, 0.0)
    for j in range(goal.bounds.first_joint, 6):
        v = inertia * crowd.velocity[i, j]
        if personal > 0.0:
            r = shift + scale * draw_kernel(state)
            v += personal * r * (crowd.best[i, j] - crowd.x[i, j])
        r = shift + scale * draw_kernel(state)
        v += c.social * r * (crowd.leader[j] - crowd.x[i, j])
        if not law.literal:
            limit = c.speed * (upper[j] - lower[j])
            v = min(max(v, -limit), limit)
        crowd.velocity[i, j] = v
        crowd.x[i, j] = min(max(crowd.x[i, j] + v, lower[j]), upper[j])


@njit(cache=True)
def _crowd(box: Box, stage: Stage, goal: Goal, state: Draws, n: int, at: Array) -> Crowd:
    x = np.empty((n, 6))
    for i in range(n):
        x[i] = at
        if i > 0 or not stage.seeded:
            draw_posture_kernel(state, box.low, box.high, goal.bounds.first_joint, x[i])
    return Crowd(
        x, np.zeros((n, 6)), np.empty((n, 6)), np.full(n, np.inf), at.copy(),
        np.full((), np.inf), np.full((), np.inf), np.full((), np.inf), np.zeros(()),
        np.empty(3), np.empty((3, 3)),
    )  # fmt: skip


@njit(cache=True)
def stage_kernel(
    law: Law, c: Coefficients, stage: Stage, goal: Goal, box: Box, state: Draws, crowd: Crowd
) -> tuple[int, int]:
    """Run one swarm; return the iteration at which it was inside its tolerances, and the last.

    The first is -1 where it never was.
    """
    n, converged, iteration, inertia = crowd.x.shape[0], -1, 0, c.inertia
    for i in range(n):
        _rank(law, stage, goal, crowd, i)
    while True:
        if converged < 0 and crowd.inside[()] == 1.0:
            converged = iteration
        if iteration >= (stage.most if converged < 0 else converged + stage.after):
            break
        iteration += 1
        for i in range(n):
            _move(law, c, stage.personal, inertia, goal, crowd, state, i)
            if law.at_once:
                _rank(law, stage, goal, crowd, i)
        if not law.at_once:
            for i in range(n):
                _rank(law, stage, goal, crowd, i)
        inertia *= c.damping  # (53)
    return converged, iteration


@njit(cache=True)
def second_population_kernel(iterations: int) -> int:
    """M of (23), literally, at least 2."""
    m = iterations * (iterations * ITERATION_TIME) / (ROTATION_TOLERANCE * REDUCTION)
    return min(max(2, round(m)), LARGEST_M)


@njit(cache=True)
def _first_box(law: Law, goal: Goal) -> Box:
    box = search_box_kernel(goal.p)
    if law.one_turn:
        for j in range(1, 6):
            box.low[j], box.high[j] = max(box.low[j], -np.pi), min(box.high[j], np.pi)
    return box


@njit(cache=True)
def pso_kernel(law: Law, c: Coefficients, goal: Goal, state: Draws, q: Array) -> Run:
    """Run the traditional PSO once, (25) with both weights 1; its answer in q (6,)."""
    unit = 1e3 if law.millimetres else 1.0
    stage = Stage(c.personal, unit, 1.0, ROTATION_TOLERANCE, MOST_ITERATIONS, c.after, False)
    box = _first_box(law, goal)
    crowd = _crowd(box, stage, goal, state, law.particles, q)
    at, last = stage_kernel(law, c, stage, goal, box, state, crowd)
    spent = law.particles * (last + 1)
    q[:] = crowd.leader
    at_end = at if at >= 0 else last
    return Run(
        at_end, 0, 0, last - at_end, 0, 1 if at >= 0 else 0, spent, crowd.position[()],
        crowd.rotation[()],
    )  # fmt: skip


@njit(cache=True)
def dpso_kernel(law: Law, c: Coefficients, goal: Goal, state: Draws, q: Array) -> Run:
    """Run DPSO once; its answer in q (6,).

    PSO-1 on (22), PSO-2 on (25) around its best, PSO where that does not come to an end.
    """
    unit = 1e3 if law.millimetres else 1.0
    box, n = _first_box(law, goal), law.particles
    stage = Stage(c.personal, 1.0, 0.0, np.inf, MOST_ITERATIONS, 0, False)
    crowd = _crowd(box, stage, goal, state, n, q)
    _, first = stage_kernel(law, c, stage, goal, box, state, crowd)
    evaluations = n * (first + 1)
    around, bounds = crowd.leader, goal.bounds
    near = Box(np.empty(6), np.empty(6))
    for j in range(6):
        near.low[j] = max(bounds.lower[j], around[j] - RADIUS)
        near.high[j] = min(bounds.upper[j], around[j] + RADIUS)
    m = second_population_kernel(first)
    stage = Stage(0.0, 0.25 * unit, 0.75, ROTATION_TOLERANCE, c.patience, c.after, True)
    crowd = _crowd(near, stage, goal, state, m, around)
    at, last = stage_kernel(law, c, stage, goal, near, state, crowd)
    evaluations += m * (last + 1)
    if at >= 0:
        q[:] = crowd.leader
        return Run(
            first, at, 0, last - at, m, 2, evaluations, crowd.position[()], crowd.rotation[()]
        )
    run = pso_kernel(law, c, goal, state, q)
    return Run(
        first, last, run.first, run.after, m, 3 if run.stage > 0 else 0,
        evaluations + run.evaluations, run.position, run.rotation,
    )  # fmt: skip
