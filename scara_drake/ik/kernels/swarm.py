"""Particle swarm: the draws, one run of a swarm, and the traditional PSO."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.ik.options import Swarm
from scara_drake.kinematics import tool_pose_kernel

Array = NDArray[np.float64]
Draws = NDArray[np.uint64]

IMPROVEMENT = 0.02  # a best that gains less than this share has stalled


def draws(seed: int) -> Draws:
    """State (1,) of the generator; every kernel that draws advances it."""
    return np.array([seed & 0xFFFFFFFFFFFFFFFF], dtype=np.uint64)


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
def swarm_kernel(
    swarm: Swarm,
    squared: bool,
    p_desired: Array,
    R_desired: Array,
    first_joint: int,
    low: Array,
    high: Array,
    lower: Array,
    upper: Array,
    position_tolerance: float,
    rotation_tolerance: float,
    state: Draws,
    x: Array,
    costs: Array,
    seeded: int,
    history: Array,
    written: int,
) -> tuple[int, int, float, float]:
    """Run one swarm: velocity (18), or (24) with personal = 0, and inertia (53).

    Args:
        swarm: its parameters.
        squared: the objective as a sum of squares.
        p_desired: (3,) [m].
        R_desired: (3, 3).
        first_joint: joints before it are held at the value in x.
        low: box of the first draw (6,).
        high: box of the first draw (6,).
        lower: joint limits (6,), kept by every particle.
        upper: joint limits (6,).
        position_tolerance: a particle within both ends the run [m].
        rotation_tolerance: [rad].
        state: of the draws.
        x: (particles, 6), the first `seeded` of them given; returns the personal bests, the global
            best first.
        costs: (particles,), returns their objectives.
        seeded: how many particles are given.
        history: (h, 2) errors of the global best, filled from row `written`.
        written: rows already filled.

    Returns:
        Iterations, evaluations, and the position and rotation error of the global best.
    """
    n = swarm.particles
    p, R = np.empty(3), np.empty((3, 3))
    best, velocity, leader = np.empty((n, 6)), np.zeros((n, 6)), np.empty(6)
    leading, position, rotation = np.inf, np.inf, np.inf
    for i in range(n):
        if i >= seeded:
            draw_posture_kernel(state, low, high, first_joint, x[i])
        costs[i] = np.inf
    inertia = swarm.inertia
    evaluations, iteration, waited, mark = 0, 0, 0, np.inf
    done = False
    while True:
        for i in range(n):
            e_p, e_w = _errors(x[i], p_desired, R_desired, p, R)
            evaluations += 1
            a, b = swarm.position_weight * e_p, swarm.rotation_weight * e_w
            cost = a * a + b * b if squared else a + b
            if cost < costs[i]:  # (17)
                costs[i] = cost
                best[i] = x[i]
            inside = e_p <= position_tolerance and e_w <= rotation_tolerance
            if (cost < leading and not done) or (inside and not done):  # (16)
                leading, position, rotation = cost, e_p, e_w
                leader[:] = x[i]
                done = inside
        if written + iteration < history.shape[0]:
            history[written + iteration, 0] = position
            history[written + iteration, 1] = rotation
        if leading < (1.0 - IMPROVEMENT) * mark:
            mark, waited = leading, 0
        else:
            waited += 1
        if done or iteration >= swarm.iterations or (swarm.stall > 0 and waited >= swarm.stall):
            break
        iteration += 1
        for i in range(n):
            for j in range(first_joint, 6):
                limit = swarm.max_speed * (upper[j] - lower[j])
                v = inertia * velocity[i, j]
                if swarm.personal > 0.0:
                    v += swarm.personal * draw_kernel(state) * (best[i, j] - x[i, j])
                v += swarm.social * draw_kernel(state) * (leader[j] - x[i, j])
                v = min(max(v, -limit), limit)
                velocity[i, j] = v
                x[i, j] = min(max(x[i, j] + v, lower[j]), upper[j])  # (19) and Step 10
        inertia *= swarm.inertia_damping  # (53)
    # The personal bests, in the order of their objective; the leader in front.
    order = np.argsort(costs)
    ordered = costs[order]
    for i in range(n):
        x[i] = best[order[i]]
        costs[i] = ordered[i]
    if done:
        x[0] = leader
        costs[0] = leading
    return iteration, evaluations, position, rotation
