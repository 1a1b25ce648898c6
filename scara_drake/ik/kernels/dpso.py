"""Where a search by the swarms alone is entered from Python."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.ik.kernels.postures import goal_kernel, nearest_turns_kernel
from scara_drake.ik.kernels.search import (
    particles_kernel,
    population_kernel,
    search_box_kernel,
    search_kernel,
    sized_kernel,
)
from scara_drake.ik.kernels.swarm import Rule, draws, swarm_kernel
from scara_drake.ik.options import Dpso
from scara_drake.ik.result import POSITION_TOLERANCE

Array = NDArray[np.float64]


@njit(cache=True)
def dual_search_kernel(
    parameters: Dpso,
    p: Array,
    R: Array,
    first_joint: int,
    seed: int,
    history: Array,
    q: Array,
) -> tuple[int, int, int]:
    """DPSO from outside, on the joint ranges; see `search_kernel`."""
    goal, box = goal_kernel(p, R, first_joint), search_box_kernel(p)
    return search_kernel(parameters, True, goal, box, draws(seed), history, q)


@njit(cache=True)
def single_search_kernel(
    parameters: Dpso,
    p: Array,
    R: Array,
    first_joint: int,
    seed: int,
    history: Array,
    q: Array,
) -> tuple[int, int, int]:
    """The traditional PSO from outside, on the joint ranges; see `search_kernel`."""
    goal, box = goal_kernel(p, R, first_joint), search_box_kernel(p)
    return search_kernel(parameters, False, goal, box, draws(seed), history, q)


@njit(cache=True)
def position_search_kernel(
    parameters: Dpso, p: Array, R: Array, first_joint: int, seed: int, history: Array, q: Array
) -> tuple[int, int, int]:
    """Solve for the position by runs of PSO-1 alone, objective (22), in place of q (6,).

    It ends within the tolerance, with whatever orientation. Returns evaluations, iterations, and
    rows of history written.
    """
    goal, box, state, start = (
        goal_kernel(p, R, first_joint),
        search_box_kernel(p),
        draws(seed),
        q.copy(),
    )
    swarm = sized_kernel(parameters.pso1, population_kernel(6 - first_joint))
    rule = Rule(parameters.squared, box.low, box.high, POSITION_TOLERANCE, np.inf, 0)
    least, evaluations, iterations, written = np.inf, 0, 0, 0
    while evaluations < parameters.budget and least > POSITION_TOLERANCE:
        x, costs = particles_kernel(swarm, start), np.empty(swarm.particles)
        it, ev, position, _ = swarm_kernel(swarm, goal, rule, state, x, costs, history[written:])
        evaluations, iterations, written = evaluations + ev, iterations + it, written + it + 1
        if position < least:
            least = position
            q[:] = x[0]
    nearest_turns_kernel(q, start)
    return evaluations, iterations, written
