"""Dual particle swarm optimisation, and the traditional PSO beside it.

PSO-1 looks for the position, PSO-2 for the orientation around PSO-1's best, and one swarm with
equal weights steps in where PSO-2 stalls (Figure 3 of the paper). With `polish`, damped least
squares from the best particles stands in for PSO-2 and the fallback.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.ik.kernels.branches import LOWER, UPPER, best_branch, search_box
from scara_drake.ik.kernels.refine import error_kernel, nearest_turns_kernel, refine_kernel
from scara_drake.ik.kernels.swarm import Draws, draws, swarm_kernel
from scara_drake.ik.options import TUNED, Dpso, Swarm, SwarmOptions
from scara_drake.ik.result import (
    POSITION_TOLERANCE,
    ROTATION_LENGTH,
    ROTATION_TOLERANCE,
    Answer,
    Problem,
)
from scara_drake.kinematics import REACH

Array = NDArray[np.float64]

ALLOWED_TIME = 0.25  # t_allow of (20) [s]
PARTICLES_PER_JOINT = 10.0  # d_N of (20)
REDUCTION = 10.0  # d_M of (23)
# t_pso1 of (23) is a wall time, which would make answers depend on the machine. It is counted as
# evaluations of this nominal duration [s]: the paper's 52 iterations then give its 40 particles.
EVALUATION_TIME = 65e-6

HISTORY_ROWS = 20_000  # a longer history is cut


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
def _sized(swarm: Swarm, particles: int) -> Swarm:
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
def _score(position: float, rotation: float) -> float:
    return (position / POSITION_TOLERANCE) ** 2 + (rotation / ROTATION_TOLERANCE) ** 2


@njit(cache=True)
def search_kernel(
    parameters: Dpso,
    dual: bool,
    polish: bool,
    p: Array,
    R: Array,
    first_joint: int,
    low: Array,
    high: Array,
    lower: Array,
    upper: Array,
    state: Draws,
    history: Array,
    q: Array,
) -> tuple[int, int, int]:
    """Search for a pose by passes of DPSO (`dual`) or PSO until one succeeds or the budget ends.

    Args:
        parameters: of the stages.
        dual: DPSO rather than PSO.
        polish: least squares from the best particles of the first swarm.
        p: target (3,) [m].
        R: target (3, 3).
        first_joint: 0 or 1.
        low: box of the draws (6,).
        high: box of the draws (6,).
        lower: joint limits (6,).
        upper: joint limits (6,).
        state: of the draws.
        history: (h, 2).
        q: posture (6,), in place; its mast height is kept where first_joint is 1.

    Returns:
        Evaluations, iterations, and rows of history written.
    """
    none = np.empty((0, 2))
    n = population_kernel(6 - first_joint)
    first = _sized(parameters.pso1 if dual else parameters.single, n)
    if dual and polish:
        first = _sized(parameters.draw, n)
    fallback = _sized(parameters.fallback, n)
    best, best_score, start = q.copy(), np.inf, q.copy()
    around_low, around_high, trial = np.empty(6), np.empty(6), np.empty(6)
    any_rotation = np.inf if dual and not polish else ROTATION_TOLERANCE
    budget = parameters.polish_budget if polish and dual else parameters.budget
    evaluations, iterations, written, passes = 0, 0, 0, 0
    while True:
        x, costs = np.empty((first.particles, 6)), np.empty(first.particles)
        for i in range(first.particles):
            x[i] = start
        it1, ev1, position, rotation = swarm_kernel(
            first, parameters.squared, p, R, first_joint, low, high, lower, upper,
            POSITION_TOLERANCE, any_rotation, state, x, costs,
            0, history, written,
        )  # fmt: skip
        iterations += it1
        evaluations += ev1
        written += it1 + 1
        score = _score(position, rotation)
        if score < best_score:
            best_score = score
            best[:] = x[0]
        if polish:
            length = (ROTATION_LENGTH, 0.1, 1.0)[passes % 3]
            for i in range(min(parameters.best, first.particles)):
                trial[:] = x[i]
                position, rotation, ev, it = refine_kernel(
                    trial, p, R, first_joint, length, lower, upper, 1.0, parameters.steps, True,
                    none,
                )  # fmt: skip
                evaluations += ev
                iterations += it
                if _score(position, rotation) < best_score:
                    best_score = _score(position, rotation)
                    best[:] = trial
                if position <= POSITION_TOLERANCE and rotation <= ROTATION_TOLERANCE:
                    # Inside; the steps that are left to exact are few.
                    q[:] = trial
                    position, rotation, ev, it = refine_kernel(
                        trial, p, R, first_joint, ROTATION_LENGTH, lower, upper, 1.0,
                        parameters.steps, True, none,
                    )  # fmt: skip
                    evaluations += ev
                    iterations += it
                    if position <= POSITION_TOLERANCE and rotation <= ROTATION_TOLERANCE:
                        q[:] = trial
                    return evaluations, iterations, written
        elif dual and not (position <= POSITION_TOLERANCE and rotation <= ROTATION_TOLERANCE):
            around = x[0].copy()
            for j in range(6):
                around_low[j] = max(lower[j], around[j] - parameters.radius)
                around_high[j] = min(upper[j], around[j] + parameters.radius)
            second = _sized(parameters.pso2, second_population_kernel(it1, ev1, n))
            for stage in range(2):
                swarm = second if stage == 0 else fallback
                x, costs = np.empty((swarm.particles, 6)), np.empty(swarm.particles)
                for i in range(swarm.particles):
                    x[i] = around if stage == 0 else start
                it, ev, position, rotation = swarm_kernel(
                    swarm, parameters.squared, p, R, first_joint,
                    around_low if stage == 0 else low, around_high if stage == 0 else high,
                    lower, upper, POSITION_TOLERANCE, ROTATION_TOLERANCE, state, x, costs,
                    1 - stage, history, written,
                )  # fmt: skip
                iterations += it
                evaluations += ev
                written += it + 1
                if _score(position, rotation) < best_score:
                    best_score = _score(position, rotation)
                    best[:] = x[0]
                if position <= POSITION_TOLERANCE and rotation <= ROTATION_TOLERANCE:
                    break
        passes += 1
        done = position <= POSITION_TOLERANCE and rotation <= ROTATION_TOLERANCE
        if done or evaluations >= budget:
            # The leader of a swarm that ended inside the tolerance, else the best of all.
            q[:] = x[0] if done and not polish else best
            return evaluations, iterations, written


@njit(cache=True)
def dpso_kernel(p: Array, R: Array, first_joint: int, seed: int, q: Array) -> tuple[int, int]:
    """Solve one pose by DPSO with polish and the tuned parameters, in place of the start q (6,).

    The entry for loops: everything that is the same for each call is compiled in.

    Args:
        p: target (3,) [m].
        R: target (3, 3).
        first_joint: 0 moves the mast, 1 keeps the height of q.
        seed: of the draws.
        q: posture (6,), in place; theta2, theta3, theta6 end nearest to where they were.

    Returns:
        Evaluations and iterations.
    """
    low, high, start = LOWER.copy(), UPPER.copy(), q.copy()
    low[0] = min(max(p[2] - REACH, LOWER[0]), UPPER[0])
    high[0] = min(max(p[2] + REACH, LOWER[0]), UPPER[0])
    state = np.empty(1, dtype=np.uint64)
    state[0] = np.uint64(seed)
    evaluations, iterations, _ = search_kernel(
        TUNED, True, True, p, R, first_joint, low, high, LOWER, UPPER, state, np.empty((0, 2)), q
    )
    nearest_turns_kernel(q, start, LOWER, UPPER)
    return evaluations, iterations


def _solve(problem: Problem, options: SwarmOptions, dual: bool) -> Answer:
    parameters = options.parameter_set()
    if problem.position_first and options.polish is False:
        return _solve_position(problem, parameters, options.history)
    if options.nearest_to is not None or problem.position_first:
        return best_branch(problem, options.nearest_to, options.number_of_starts())
    polish = dual if options.polish is None else options.polish
    q = problem.start.copy()
    if parameters is TUNED and dual and polish and not options.history:
        return Answer(q, *dpso_kernel(problem.p, problem.R, problem.first_joint, problem.seed, q))
    low, high = search_box(problem.p)
    rows = HISTORY_ROWS if options.history else 0
    history = np.empty((rows, 2))
    evaluations, iterations, written = search_kernel(
        parameters, dual, polish, problem.p, problem.R, problem.first_joint, low, high, LOWER,
        UPPER, draws(problem.seed), history, q,
    )  # fmt: skip
    nearest_turns_kernel(q, problem.start, LOWER, UPPER)
    kept = history[:written].copy() if options.history else None
    return Answer(q, evaluations, iterations, kept)


def _solve_position(problem: Problem, parameters: Dpso, keep_history: bool) -> Answer:
    """Solve for the position by PSO-1 alone, objective (22), as the paper's live experiment does.

    It ends within the tolerance, with whatever orientation; each target is drawn anew, so that
    neighbouring targets may get answers far apart.
    """
    low, high = search_box(problem.p)
    state, q = draws(problem.seed), problem.start.copy()
    swarm = _sized(parameters.pso1, population_kernel(6 - problem.first_joint))
    history = np.empty((HISTORY_ROWS if keep_history else 0, 2))
    best, best_error = q.copy(), np.inf
    evaluations, iterations, written = 0, 0, 0
    while evaluations < parameters.budget and best_error > POSITION_TOLERANCE:
        x, costs = np.tile(problem.start, (swarm.particles, 1)), np.empty(swarm.particles)
        it, ev, error, _ = swarm_kernel(
            swarm, parameters.squared, problem.p, problem.R, problem.first_joint, low, high, LOWER,
            UPPER, POSITION_TOLERANCE, np.inf, state, x, costs, 0, history, written,
        )  # fmt: skip
        evaluations, iterations, written = evaluations + ev, iterations + it, written + it + 1
        if error < best_error:
            best, best_error = x[0].copy(), error
    nearest_turns_kernel(best, problem.start, LOWER, UPPER)
    return Answer(best, evaluations, iterations, history[:written].copy() if keep_history else None)


def solve(problem: Problem, options: SwarmOptions) -> Answer:
    """Solve one target by DPSO."""
    return _solve(problem, options, dual=True)


def solve_single(problem: Problem, options: SwarmOptions) -> Answer:
    """Solve one target by the traditional PSO: one swarm on position and orientation together."""
    return _solve(problem, options, dual=False)


def attainable(problem: Problem, limits: bool, seed: int = 0) -> bool:
    """Return whether some posture meets the pose, within the joint ranges or without them.

    Without them every revolute joint turns freely, while the mast keeps its range.
    """
    lower, upper = LOWER.copy(), UPPER.copy()
    if not limits:
        lower[1:], upper[1:] = -2.0 * np.pi, 2.0 * np.pi
    low, high = search_box(problem.p)
    low[1:], high[1:] = lower[1:], upper[1:]
    q = problem.start.copy()
    parameters = SwarmOptions().parameter_set()
    search_kernel(
        parameters, True, True, problem.p, problem.R, problem.first_joint, low, high, lower, upper,
         draws(seed), np.empty((0, 2)), q,
    )  # fmt: skip
    position, rotation = error_kernel(q, problem.p, problem.R)
    return bool(position <= POSITION_TOLERANCE and rotation <= ROTATION_TOLERANCE)
