"""The search for a pose by dual particle swarm optimisation, and by the traditional PSO.

PSO-1 looks for the position, PSO-2 for the orientation around PSO-1's best, and one swarm with
equal weights steps in where PSO-2 stalls (Figure 3 of the paper). That is one pass.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.layout import Cell
from scara_drake.ik.kernels.errors import misfit_kernel, within_kernel
from scara_drake.ik.kernels.postures import Goal
from scara_drake.ik.kernels.swarm import Draws, Rule, swarm_kernel
from scara_drake.ik.options import Dpso, Swarm
from scara_drake.ik.result import POSITION_TOLERANCE, ROTATION_TOLERANCE
from scara_drake.joints import LOWER, UPPER
from scara_drake.kinematics import REACH

Array = NDArray[np.float64]

ALLOWED_TIME = 0.25  # t_allow of (20) [s]
PARTICLES_PER_JOINT = 10.0  # d_N of (20)
REDUCTION = 10.0  # d_M of (23)
# t_pso1 of (23) is a wall time, which would make answers depend on the machine. It is counted as
# evaluations of this nominal duration [s]: the paper's 52 iterations then give its 40 particles.
EVALUATION_TIME = 65e-6


class Box(NamedTuple):
    """Where postures are drawn.

    Attributes:
        low: (6,).
        high: (6,).
    """

    low: Array
    high: Array


class Search(NamedTuple):
    """A search under way.

    Attributes:
        parameters: of the stages.
        goal: pose and joints.
        box: of the draws.
        state: of the draws.
        history: (h, 2) errors of the global best, iteration by iteration.
        start: posture (6,); particles have its mast height where the mast keeps it.
        leader: (6,) of the swarm that ran last.
        position: error of the posture looked at last [m].
        rotation: its error [rad].
        best: posture (6,) of the smallest misfit.
        least: that misfit.
        evaluations: spent.
        iterations: spent.
        written: rows of history.
    """

    parameters: Dpso
    goal: Goal
    box: Box
    state: Draws
    history: Array
    start: Array
    leader: Array
    position: Cell
    rotation: Cell
    best: Array
    least: Cell
    evaluations: Cell
    iterations: Cell
    written: Cell


@njit(cache=True)
def population_kernel(moving: int) -> int:
    """N of (20) for so many moving joints; its tolerance counts in millimetres."""
    return round(moving * PARTICLES_PER_JOINT / (ALLOWED_TIME * 1e3 * POSITION_TOLERANCE))


@njit(cache=True)
def second_population_kernel(iterations: int, evaluations: int, population: int) -> int:
    """M of (23), between half of N and N - 1 (the constant d_M is there to cause M < N)."""
    m = iterations * evaluations * EVALUATION_TIME / (ROTATION_TOLERANCE * REDUCTION)
    return max(population // 2, min(population - 1, round(m)))


@njit(cache=True)
def search_box_kernel(p: Array) -> Box:
    """Box of the draws: the joint ranges, the mast only where the arm can reach p (3,)."""
    low, high = LOWER.copy(), UPPER.copy()
    low[0] = min(max(p[2] - REACH, LOWER[0]), UPPER[0])
    high[0] = min(max(p[2] + REACH, LOWER[0]), UPPER[0])
    return Box(low, high)


@njit(cache=True)
def sized_kernel(swarm: Swarm, particles: int) -> Swarm:
    """Return a swarm, with so many particles where it does not say how many."""
    return Swarm(
        particles if swarm.particles == 0 else swarm.particles,
        swarm.iterations,
        swarm.inertia,
        swarm.inertia_damping,
        swarm.personal,
        swarm.social,
        swarm.max_speed,
        swarm.stall,
        swarm.position_weight,
        swarm.rotation_weight,
    )


@njit(cache=True)
def _within(search: Search) -> bool:
    return within_kernel(search.position[()], search.rotation[()], False)


@njit(cache=True)
def _note(search: Search, q: Array, position: float, rotation: float) -> None:
    """Note the errors of a posture (6,), and the posture where none was better."""
    search.position[()], search.rotation[()] = position, rotation
    misfit = misfit_kernel(position, rotation)
    if misfit < search.least[()]:
        search.least[()] = misfit
        search.best[:] = q


@njit(cache=True)
def _run_swarm(
    search: Search, swarm: Swarm, box: Box, rotation_tolerance: float, seeded: int, x: Array
) -> tuple[int, int]:
    """Run a swarm from x (particles, 6) and note its leader; return iterations, evaluations."""
    rule = Rule(
        search.parameters.squared, box.low, box.high, POSITION_TOLERANCE, rotation_tolerance,
        seeded,
    )  # fmt: skip
    iterations, evaluations, position, rotation = swarm_kernel(
        swarm, search.goal, rule, search.state, x, np.empty(x.shape[0]),
        search.history[search.written[()] :],
    )  # fmt: skip
    search.iterations[()] += iterations
    search.evaluations[()] += evaluations
    search.written[()] += iterations + 1
    search.leader[:] = x[0]
    _note(search, x[0], position, rotation)
    return iterations, evaluations


@njit(cache=True)
def particles_kernel(swarm: Swarm, at: Array) -> Array:
    """Return the particles (particles, 6) of a swarm, all at one posture (6,)."""
    x = np.empty((swarm.particles, 6))
    for i in range(swarm.particles):
        x[i] = at
    return x


@njit(cache=True)
def pso1_kernel(search: Search, swarm: Swarm, rotation_tolerance: float) -> tuple[Array, int, int]:
    """PSO-1 on the position (22), or whichever swarm stands first.

    Returns its particles (particles, 6), the best first, its iterations and its evaluations.
    """
    x = particles_kernel(swarm, search.start)
    iterations, evaluations = _run_swarm(search, swarm, search.box, rotation_tolerance, 0, x)
    return x, iterations, evaluations


@njit(cache=True)
def pso2_kernel(search: Search, swarm: Swarm) -> None:
    """PSO-2 on (25), within `radius` of the best of PSO-1."""
    around, bounds, radius = search.leader.copy(), search.goal.bounds, search.parameters.radius
    low, high = np.empty(6), np.empty(6)
    for j in range(6):
        low[j] = max(bounds.lower[j], around[j] - radius)
        high[j] = min(bounds.upper[j], around[j] + radius)
    x = particles_kernel(swarm, around)
    _run_swarm(search, swarm, Box(low, high), ROTATION_TOLERANCE, 1, x)


@njit(cache=True)
def fallback_kernel(search: Search, swarm: Swarm) -> None:
    """One swarm on position and orientation together, where PSO-2 stalls."""
    x = particles_kernel(swarm, search.start)
    _run_swarm(search, swarm, search.box, ROTATION_TOLERANCE, 0, x)


@njit(cache=True)
def pass_kernel(search: Search, dual: bool) -> bool:
    """Run one pass; return whether the leader of the swarm that ran last is in both tolerances."""
    parameters = search.parameters
    n = population_kernel(6 - search.goal.bounds.first_joint)
    if not dual:
        pso1_kernel(search, sized_kernel(parameters.single, n), ROTATION_TOLERANCE)
        return _within(search)
    _, iterations, evaluations = pso1_kernel(search, sized_kernel(parameters.pso1, n), np.inf)
    if not _within(search):
        m = second_population_kernel(iterations, evaluations, n)
        pso2_kernel(search, sized_kernel(parameters.pso2, m))
        if not _within(search):
            fallback_kernel(search, sized_kernel(parameters.fallback, n))
    return _within(search)


@njit(cache=True)
def position_pass_kernel(search: Search, dual: bool, leaders: Array) -> int:
    """Run one pass for the position exactly and the orientation as near as it can be.

    PSO-1 has to reach the position; the swarms on (25) behind it have no orientation to reach, and
    end where they stall. Writes the leader of each stage (3, 6); returns their number, 0 where
    PSO-1 failed.
    """
    parameters = search.parameters
    n = population_kernel(6 - search.goal.bounds.first_joint)
    _, iterations, evaluations = pso1_kernel(search, sized_kernel(parameters.pso1, n), np.inf)
    if search.position[()] > POSITION_TOLERANCE:
        return 0
    leaders[0] = search.leader
    if not dual:
        fallback_kernel(search, sized_kernel(parameters.single, n))
        leaders[1] = search.leader
        return 2
    m = second_population_kernel(iterations, evaluations, n)
    pso2_kernel(search, sized_kernel(parameters.pso2, m))
    leaders[1] = search.leader
    fallback_kernel(search, sized_kernel(parameters.fallback, n))
    leaders[2] = search.leader
    return 3


@njit(cache=True)
def new_search_kernel(
    parameters: Dpso, goal: Goal, box: Box, state: Draws, history: Array, q: Array
) -> Search:
    """Return a search that has not begun; q (6,) has the height of a mast that does not move."""
    return Search(
        parameters, goal, box, state, history, q.copy(), q.copy(), np.full((), np.inf),
        np.full((), np.inf), q.copy(), np.full((), np.inf), np.zeros((), np.int64),
        np.zeros((), np.int64), np.zeros((), np.int64),
    )  # fmt: skip


@njit(cache=True)
def search_kernel(
    parameters: Dpso,
    dual: bool,
    goal: Goal,
    box: Box,
    state: Draws,
    history: Array,
    q: Array,
) -> tuple[int, int, int]:
    """Search for a pose by passes of DPSO (`dual`) or PSO until one succeeds or the budget ends.

    Args:
        parameters: of the stages.
        dual: DPSO rather than PSO.
        goal: pose and joints.
        box: of the draws.
        state: of the draws.
        history: (h, 2).
        q: posture (6,), in place; its mast height is kept where the mast does not move.

    Returns:
        Evaluations, iterations, and rows of history written.
    """
    search = new_search_kernel(parameters, goal, box, state, history, q)
    passes, done = 0, False
    while not (done or (passes > 0 and search.evaluations[()] >= parameters.budget)):
        done = pass_kernel(search, dual)
        passes += 1
    # The leader of a swarm that ended inside the tolerance, else the best of all.
    q[:] = search.leader if done else search.best
    return search.evaluations[()], search.iterations[()], search.written[()]
