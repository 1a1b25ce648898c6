r"""Particle swarm: the draws, one run of a swarm, and the traditional PSO.

With the best posture p of a particle x, the best g of all, and draws r in [0, 1), an iteration is

.. math::

    v      &\leftarrow \omega v + c_1 r_1 (p - x) + c_2 r_2 (g - x)   \quad (18) \\
    v      &\leftarrow \omega v + c_2 r_2 (g - x)                     \quad (24) \\
    x      &\leftarrow x + v                                          \quad (19) \\
    \omega &\leftarrow \omega_d\,\omega                               \quad (53)

with (18) for the first swarm and (24) for the second. Each entry of v is clamped to a share of its
joint's range, each entry of x to that range.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.layout import Cell
from scara_drake.ik.kernels.postures import Bounds, Goal
from scara_drake.ik.options import Swarm
from scara_drake.kinematics import tool_pose_kernel

Array = NDArray[np.float64]
Draws = NDArray[np.uint64]

IMPROVEMENT = 0.02  # a best that gains less than this share has stalled


class Rule(NamedTuple):
    """What a swarm starts from and when it ends.

    Attributes:
        squared: the objective as a sum of squares.
        low: box of the first draw (6,).
        high: box of the first draw (6,).
        position_tolerance: a particle within both ends the run [m].
        rotation_tolerance: [rad].
        seeded: how many particles are given; the others are drawn.
    """

    squared: bool
    low: Array
    high: Array
    position_tolerance: float
    rotation_tolerance: float
    seeded: int


class Flock(NamedTuple):
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
    p: Array
    R: Array


@njit(cache=True)
def draws(seed: int) -> Draws:
    """Return the state (1,) of the generator; every kernel that draws advances it."""
    state = np.empty(1, dtype=np.uint64)
    state[0] = np.uint64(seed)
    return state


@njit(cache=True)
def draw_kernel(state: Draws) -> float:
    """Next number in [0, 1): splitmix64, whose whole state is one word."""
    state[0] += np.uint64(0x9E3779B97F4A7C15)
    z = state[0]
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    z = z ^ (z >> np.uint64(31))
    return np.float64(z >> np.uint64(11)) * (1.0 / 9007199254740992.0)


@njit(cache=True)
def draw_posture_kernel(state: Draws, low: Array, high: Array, first_joint: int, q: Array) -> None:
    """Write a posture (6,) uniform in the box; joints before first_joint stay."""
    for j in range(first_joint, 6):
        q[j] = low[j] + draw_kernel(state) * (high[j] - low[j])


@njit(cache=True)
def _errors(q: Array, p_d: Array, R_d: Array, p: Array, R: Array) -> tuple[float, float]:
    # The rotation angle from the chord |R_d - R|.
    tool_pose_kernel(q, p, R)
    square = chord = 0.0
    for i in range(3):
        square += (p_d[i] - p[i]) ** 2
        for k in range(3):
            chord += (R_d[i, k] - R[i, k]) ** 2
    return np.sqrt(square), 2.0 * np.arcsin(min(1.0, np.sqrt(chord / 8.0)))


@njit(cache=True)
def _rank(swarm: Swarm, goal: Goal, rule: Rule, flock: Flock) -> bool:
    """Find the personal bests and the global one; return whether it is within the tolerances."""
    done = False
    for i in range(swarm.particles):
        e_p, e_w = _errors(flock.x[i], goal.p, goal.R, flock.p, flock.R)
        a, b = swarm.position_weight * e_p, swarm.rotation_weight * e_w
        cost = a * a + b * b if rule.squared else a + b
        if cost < flock.costs[i]:  # (17)
            flock.costs[i] = cost
            flock.best[i] = flock.x[i]
        inside = e_p <= rule.position_tolerance and e_w <= rule.rotation_tolerance
        if (cost < flock.leading[()] and not done) or (inside and not done):  # (16)
            flock.leading[()], flock.position[()], flock.rotation[()] = cost, e_p, e_w
            flock.leader[:] = flock.x[i]
            done = inside
    return done


@njit(cache=True)
def _move(swarm: Swarm, inertia: float, bounds: Bounds, state: Draws, flock: Flock) -> None:
    """Move all particles: velocity (18), or (24) with personal = 0, and position (19)."""
    lower, upper = bounds.lower, bounds.upper
    x, velocity, best, leader = flock.x, flock.velocity, flock.best, flock.leader
    for i in range(swarm.particles):
        for j in range(bounds.first_joint, 6):
            limit = swarm.max_speed * (upper[j] - lower[j])
            v = inertia * velocity[i, j]
            if swarm.personal > 0.0:
                v += swarm.personal * draw_kernel(state) * (best[i, j] - x[i, j])
            v += swarm.social * draw_kernel(state) * (leader[j] - x[i, j])
            v = min(max(v, -limit), limit)
            velocity[i, j] = v
            x[i, j] = min(max(x[i, j] + v, lower[j]), upper[j])  # (19) and Step 10


@njit(cache=True)
def _order(flock: Flock, done: bool) -> None:
    """Replace the postures by the personal bests in the order of their objective.

    A leader that ended the run goes in front.
    """
    order = np.argsort(flock.costs)
    ordered = flock.costs[order]
    for i in range(order.size):
        flock.x[i] = flock.best[order[i]]
        flock.costs[i] = ordered[i]
    if done:
        flock.x[0] = flock.leader
        flock.costs[0] = flock.leading[()]


@njit(cache=True)
def swarm_kernel(
    swarm: Swarm, goal: Goal, rule: Rule, state: Draws, x: Array, costs: Array, history: Array
) -> tuple[int, int, float, float]:
    """Run one swarm: velocity (18), or (24) with personal = 0, and inertia (53).

    Args:
        swarm: its parameters.
        goal: pose and joints; those that do not move keep their value in x.
        rule: start and end.
        state: of the draws.
        x: (particles, 6), the first of them given where `rule` says so; returns the personal bests,
            the global best first.
        costs: (particles,), returns their objectives.
        history: (h, 2) errors of the global best, filled from the first row.

    Returns:
        Iterations, evaluations, and the position and rotation error of the global best.
    """
    n = swarm.particles
    flock = Flock(
        x, np.zeros((n, 6)), np.empty((n, 6)), costs, np.empty(6),
        np.full((), np.inf), np.full((), np.inf), np.full((), np.inf),
        np.empty(3), np.empty((3, 3)),
    )  # fmt: skip
    for i in range(n):
        if i >= rule.seeded:
            draw_posture_kernel(state, rule.low, rule.high, goal.bounds.first_joint, x[i])
        costs[i] = np.inf
    inertia = swarm.inertia
    iteration, waited, mark = 0, 0, np.inf
    while True:
        done = _rank(swarm, goal, rule, flock)
        if iteration < history.shape[0]:
            history[iteration, 0] = flock.position[()]
            history[iteration, 1] = flock.rotation[()]
        if flock.leading[()] < (1.0 - IMPROVEMENT) * mark:
            mark, waited = flock.leading[()], 0
        else:
            waited += 1
        if done or iteration >= swarm.iterations or (swarm.stall > 0 and waited >= swarm.stall):
            break
        iteration += 1
        _move(swarm, inertia, goal.bounds, state, flock)
        inertia *= swarm.inertia_damping  # (53)
    _order(flock, done)
    return iteration, n * (iteration + 1), flock.position[()], flock.rotation[()]
