"""The branches of a pose that passes of a swarm reach, each refined by least squares.

A pass counts where its swarm has converged by itself: within both tolerances for a pose, within
that of the position where the orientation comes second. Refinement then gives the digits that are
left, and the mirrored posture of each solution is one more branch.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.layout import Cell
from scara_drake.ik.kernels.errors import error_kernel, within_kernel
from scara_drake.ik.kernels.postures import (
    TURN,
    Goal,
    keep_limits_kernel,
    mirror_kernel,
    nearest_turns_kernel,
    turns_kernel,
)
from scara_drake.ik.kernels.refine import Descent, refine_kernel, refine_position_first_kernel
from scara_drake.ik.kernels.search import (
    Box,
    Search,
    new_search_kernel,
    pass_kernel,
    position_pass_kernel,
    search_box_kernel,
)
from scara_drake.ik.kernels.solutions import SLACK
from scara_drake.ik.kernels.swarm import draws
from scara_drake.ik.options import Dpso
from scara_drake.ik.result import ROTATION_LENGTH
from scara_drake.joints import LOWER, UPPER

Array = NDArray[np.float64]

REFINEMENT_STEPS = 60
LEADERS = 3  # most that one pass yields, one a stage
# Of the joint ranges, pass by pass: the whole of them for the best solution, half of them for the
# one that is near.
SHARES = (1.0, 0.5)


class Found(NamedTuple):
    """Branches found so far.

    Attributes:
        q: postures (rows, 6).
        errors: of them (rows, 2) [m], [rad].
        count: how many rows are filled.
    """

    q: Array
    errors: Array
    count: Cell


@njit(cache=True)
def aim_kernel(box: Box, whole: Box, near: Array, share: float) -> None:
    """Write the box of the next draw: of each joint a share of its range, about a posture (6,).

    A whole turn is all that a joint of several turns needs.
    """
    for j in range(6):
        low, high = whole.low[j], whole.high[j]
        half = 0.5 * share * (2.0 * np.pi if turns_kernel(j) else high - low)
        middle = min(max(near[j], low + half), high - half)
        box.low[j], box.high[j] = middle - half, middle + half


@njit(cache=True)
def _turn_towards(q: Array, near: Array) -> None:
    """Turn q (6,) to lie nearest to a posture, onto a limit too that it passes by rounding."""
    nearest_turns_kernel(q, near)
    for j in range(6):
        if turns_kernel(j):
            turned = q[j] + TURN * np.round((near[j] - q[j]) / TURN)
            if LOWER[j] - SLACK <= turned <= UPPER[j] + SLACK:
                q[j] = min(max(turned, LOWER[j]), UPPER[j])


@njit(cache=True)
def _refine(q: Array, search: Search, position_first: bool, near: Array) -> tuple[float, float]:
    """Refine a posture (6,) in place and turn it towards `near`; return its errors [m], [rad]."""
    descent, none = Descent(ROTATION_LENGTH, 1.0, REFINEMENT_STEPS, True), np.empty((0, 2))
    if position_first:
        position, rotation, evaluations, _ = refine_position_first_kernel(
            q, search.goal, descent, none
        )
    else:
        position, rotation, evaluations, _ = refine_kernel(q, search.goal, descent, none)
    search.evaluations[()] += evaluations
    _turn_towards(q, near)
    return position, rotation


@njit(cache=True)
def _keep(found: Found, search: Search, leader: Array, position_first: bool, near: Array) -> None:
    """Add a swarm's leader (6,) and its mirror, both refined."""
    goal = search.goal
    for mirrored in (False, True):
        k = found.count[()]
        q = found.q[k]
        if mirrored:
            mirror_kernel(found.q[k - 1], q)
            keep_limits_kernel(q, goal.bounds, True)
        else:
            q[:] = leader
        position, rotation = _refine(q, search, position_first, near)
        if not mirrored and not within_kernel(position, rotation, position_first):
            # The least squares of a pose that cannot be held exactly may lie outside the
            # tolerances though the swarm was inside.
            q[:] = leader
            _turn_towards(q, near)
            position, rotation = error_kernel(q, goal.p, goal.R)
        found.errors[k, 0], found.errors[k, 1] = position, rotation
        found.count[()] += 1


@njit(cache=True)
def swarm_branches_kernel(
    parameters: Dpso,
    dual: bool,
    position_first: bool,
    goal: Goal,
    near: Array,
    seed: int,
    passes: int,
    history: Array,
) -> tuple[Array, Array, int, int, int]:
    """Find branches by passes of DPSO (`dual`) or PSO, and by more until one has converged.

    Args:
        parameters: of the stages; `polish_budget` ends the search where no pass converges.
        dual: DPSO rather than PSO.
        position_first: the orientation as near as it can be, instead of within its tolerance.
        goal: pose and joints; a mast that does not move keeps near[0].
        near: posture (6,); theta2, theta3 and theta6 end nearest to it.
        seed: of the draws.
        passes: at least so many.
        history: (h, 2), receives the errors of the global best, iteration by iteration.

    Returns:
        Postures (n, 6), none where no pass converged, their errors (n, 2) [m], [rad],
        evaluations, iterations of the swarms, rows of history written.
    """
    whole, box = search_box_kernel(goal.p), search_box_kernel(goal.p)
    search = new_search_kernel(parameters, goal, box, draws(seed), history, near)
    rows = 2 * LEADERS * passes
    found = Found(np.empty((rows, 6)), np.empty((rows, 2)), np.zeros((), np.int64))
    leaders, done = np.empty((LEADERS, 6)), 0
    while done < passes or (
        found.count[()] == 0 and search.evaluations[()] < parameters.polish_budget
    ):
        aim_kernel(box, whole, near, SHARES[done % len(SHARES)])
        done += 1
        if position_first:
            n = position_pass_kernel(search, dual, leaders)
        else:
            n = int(pass_kernel(search, dual))
            leaders[0] = search.leader
        for i in range(n):
            _keep(found, search, leaders[i], position_first, near)
    n = found.count[()]
    return (
        found.q[:n], found.errors[:n], search.evaluations[()], search.iterations[()],
        search.written[()],
    )  # fmt: skip
