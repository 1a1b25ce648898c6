"""Least squares from many draws: what is left where the closed form and its neighbours fail.

No particle moves here: postures are drawn and ranked, and the best are refined.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.ik.kernels.errors import misfit_kernel, within_kernel
from scara_drake.ik.kernels.postures import TURN, Goal, goal_kernel, nearest_turns_kernel
from scara_drake.ik.kernels.refine import Descent, refine_kernel
from scara_drake.ik.kernels.search import Box, search_box_kernel
from scara_drake.ik.kernels.swarm import Draws, Rule, draws, swarm_kernel
from scara_drake.ik.options import Swarm
from scara_drake.ik.result import POSITION_TOLERANCE, ROTATION_LENGTH, ROTATION_TOLERANCE

Array = NDArray[np.float64]

# A swarm of no iterations draws and ranks; the weights are those of its ranking.
DRAW: Final = Swarm(16, 0, 0.0, 1.0, 0.0, 0.0, 0.0, 0, 1.0, 0.6)
BEST, STEPS = 4, 10  # how many of the draws are refined, by how many steps each
BUDGET = 20_000  # a new round of draws begins only below so many evaluations
LENGTHS = (ROTATION_LENGTH, 0.1, 1.0)  # of the rotation, round by round [m/rad]


@njit(cache=True)
def rounds_kernel(goal: Goal, box: Box, state: Draws, q: Array) -> int:
    """Solve a pose in place of q (6,), which has the height of a mast that does not move.

    Returns the evaluations. What is not within the tolerances is the best that was found.
    """
    x, costs, trial, none = np.empty((DRAW.particles, 6)), np.empty(16), q.copy(), np.empty((0, 2))
    rule = Rule(True, box.low, box.high, POSITION_TOLERANCE, ROTATION_TOLERANCE, 0)
    evaluations, rounds, least = 0, 0, np.inf
    best = q.copy()
    while rounds == 0 or evaluations < BUDGET:
        for i in range(DRAW.particles):
            x[i] = q
        _, drawn, position, rotation = swarm_kernel(DRAW, goal, rule, state, x, costs, none)
        evaluations += drawn
        misfit = misfit_kernel(position, rotation)
        if misfit < least:
            least = misfit
            best[:] = x[0]
        descent = Descent(LENGTHS[rounds % 3], 1.0, STEPS, True)
        for i in range(BEST):
            trial[:] = x[i]
            position, rotation, ev, _ = refine_kernel(trial, goal, descent, none)
            evaluations += ev
            misfit = misfit_kernel(position, rotation)
            if misfit < least:
                least = misfit
                best[:] = trial
            if within_kernel(position, rotation, False):
                # Inside; the steps that are left to exact are few.
                q[:] = trial
                exact = Descent(ROTATION_LENGTH, 1.0, STEPS, True)
                position, rotation, ev, _ = refine_kernel(trial, goal, exact, none)
                if within_kernel(position, rotation, False):
                    q[:] = trial
                return evaluations + ev
        rounds += 1
    q[:] = best
    return evaluations


@njit(cache=True)
def multistart_kernel(p: Array, R: Array, first_joint: int, seed: int, q: Array) -> int:
    """Solve one pose in place of the start q (6,), the entry for loops; return the evaluations.

    Args:
        p: target (3,) [m].
        R: target (3, 3).
        first_joint: 0 moves the mast, 1 keeps the height of q.
        seed: of the draws.
        q: posture (6,), in place; theta2, theta3, theta6 end nearest to where they were.
    """
    start = q.copy()
    evaluations = rounds_kernel(
        goal_kernel(p, R, first_joint), search_box_kernel(p), draws(seed), q
    )
    nearest_turns_kernel(q, start)
    return evaluations


@njit(cache=True)
def free_search_kernel(
    p: Array, R: Array, first_joint: int, limits: bool, seed: int, q: Array
) -> None:
    """Search as `multistart_kernel`, with or without the limits of the joints that turn."""
    goal, box = goal_kernel(p, R, first_joint), search_box_kernel(p)
    if not limits:
        for j in range(1, 6):
            goal.bounds.lower[j], goal.bounds.upper[j] = -TURN, TURN
            box.low[j], box.high[j] = -TURN, TURN
    rounds_kernel(goal, box, draws(seed), q)
