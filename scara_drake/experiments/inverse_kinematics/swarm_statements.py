"""What the paper reports about its swarms, as statistics of our runs with a tolerance each."""

from __future__ import annotations

from itertools import product
from typing import Final, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.experiments.inverse_kinematics.paths import joint_paths
from scara_drake.experiments.inverse_kinematics.postures import home, targets
from scara_drake.experiments.inverse_kinematics.swarm_law import Coefficients, Law
from scara_drake.experiments.inverse_kinematics.swarm_readings import Run, dpso_kernel, pso_kernel
from scara_drake.experiments.inverse_kinematics.swarm_reported import STATEMENTS, Statement
from scara_drake.ik.kernels.postures import goal_kernel
from scara_drake.ik.kernels.swarm import draws
from scara_drake.ik.result import POSITION_TOLERANCE, ROTATION_TOLERANCE
from scara_drake.kinematics import forward_kinematics

Array = NDArray[np.float64]

# Where the fields of Run stand in an array of runs.
FIELDS: Final = len(Run._fields)
FIRST, SECOND, THIRD, AFTER, PARTICLES, STAGE, EVALUATIONS, POSITION, ROTATION = range(FIELDS)
STAGES: Final = ("all", "PSO-1 and PSO-2", "those that answered")


class Count(NamedTuple):
    """How the paper's counts are read.

    Attributes:
        stages: whose iterations are a DPSO's, one of STAGES.
        at_stop: up to where the swarm stops, else to where it is inside the tolerances.
        added: the population of a DPSO is N + M, else its evaluations over its iterations.
    """

    stages: str
    at_stop: bool
    added: bool


COUNTS: Final = tuple(map(Count._make, product(STAGES, (False, True), (True, False))))


class Sample(NamedTuple):
    """Runs of one set of coefficients under one reading; the last axis has the fields of Run.

    Attributes:
        particles: N.
        single: of PSO (4, draws, f) at the postures of Table 5.
        undamped: of PSO at a constant inertia, the same.
        dual: of DPSO, the same.
        path: of DPSO (paths, points, f) at neighbouring points.
        q: answers of those (paths, points, 6).
    """

    particles: int
    single: Array
    undamped: Array
    dual: Array
    path: Array
    q: Array


@njit(cache=True)
def runs_kernel(
    law: Law, c: Coefficients, dual: bool, X_WE: Array, seed: int, q: Array, runs: Array
) -> None:
    """Run a swarm at poses (n, 4, 4), each with a seed of its own.

    Args:
        law: reading.
        c: coefficients.
        dual: DPSO rather than PSO.
        X_WE: (n, 4, 4).
        seed: of the first.
        q: (n, 6), the posture to start from; returns the answers.
        runs: (n, f), returns the runs.
    """
    for k in range(X_WE.shape[0]):
        goal = goal_kernel(X_WE[k, :3, 3].copy(), X_WE[k, :3, :3].copy(), 0)
        state = draws(seed + k)
        if dual:
            run = dpso_kernel(law, c, goal, state, q[k])
        else:
            run = pso_kernel(law, c, goal, state, q[k])
        runs[k, FIRST], runs[k, SECOND], runs[k, THIRD] = run.first, run.second, run.third
        runs[k, AFTER], runs[k, PARTICLES], runs[k, STAGE] = run.after, run.particles, run.stage
        runs[k, EVALUATIONS] = run.evaluations
        runs[k, POSITION], runs[k, ROTATION] = run.position, run.rotation


def _runs(law: Law, c: Coefficients, dual: bool, X_WE: Array, seed: int) -> tuple[Array, Array]:
    """Run a swarm at poses (..., 4, 4); return the runs (..., f) and the answers (..., 6)."""
    poses = np.ascontiguousarray(X_WE.reshape(-1, 4, 4))
    q, runs = np.tile(home(), (len(poses), 1)), np.empty((len(poses), FIELDS))
    runs_kernel(law, c, dual, poses, seed, q, runs)
    shape = X_WE.shape[:-2]
    return runs.reshape(*shape, -1), q.reshape(*shape, -1)


class Size(NamedTuple):
    """How much is run.

    Attributes:
        draws: at each posture.
        paths: trajectories.
        points: of each, the first of its 50.
    """

    draws: int
    paths: int
    points: int = 2


def of_pso(law: Law, c: Coefficients, seed: int, size: Size) -> Array:
    """Run PSO at the postures of Table 5; return the runs (4, draws, f), see `sample`."""
    return _runs(law, c, False, _postures(size), seed)[0]


def _postures(size: Size) -> Array:
    return np.repeat(targets()[:, np.newaxis], size.draws, axis=1)


def sample(law: Law, c: Coefficients, seed: int, size: Size, single: Array | None = None) -> Sample:
    """Run PSO and DPSO at the postures of Table 5, and DPSO along paths.

    Args:
        law: reading.
        c: coefficients.
        seed: of paths and draws.
        size: how much.
        single: the runs of PSO, where they are there already.
    """
    postures = _postures(size)
    if single is None:
        single = of_pso(law, c, seed, size)
    along = forward_kinematics(joint_paths(seed, size.paths)[:, : size.points])
    few = postures[:, : (size.draws + 1) // 2]
    undamped, _ = _runs(law, c._replace(damping=1.0), False, few, seed)
    dual, _ = _runs(law, c, True, postures, seed)
    path, q = _runs(law, c, True, along, seed)
    return Sample(law.particles, single, undamped, dual, path, q)


FURTHEST: Final = np.log(3.0)  # beyond the tolerance, from which on it no longer matters how far


def _success(runs: Array) -> NDArray[np.bool_]:
    inside = runs[..., POSITION] <= POSITION_TOLERANCE
    return (runs[..., STAGE] > 0) & inside & (runs[..., ROTATION] <= ROTATION_TOLERANCE)


def _medians(values: Array, good: NDArray[np.bool_]) -> Array:
    """Medians (n,) of the good values of each row; NaN where a row has none."""
    return np.array(
        [np.median(v[g]) if g.any() else np.nan for v, g in zip(values, good, strict=True)]
    )


def _mean(values: Array) -> float:
    known = values[np.isfinite(values)]
    return float(known.mean()) if known.size else np.nan


def iterations(runs: Array, dual: bool, count: Count) -> Array:
    """Iterations (...) of runs (..., f), NaN for those that a reading does not count."""
    first, second, third = (runs[..., k] for k in (FIRST, SECOND, THIRD))
    after, stage = runs[..., AFTER], runs[..., STAGE]
    run_on = after if count.at_stop else 0.0
    if not dual:
        return first + run_on
    two = np.where(stage == 2, first + second, np.nan)
    if count.stages == "PSO-1 and PSO-2":
        return two + run_on
    return np.where(stage == 2, two, third if count.stages != "all" else first + second + third) + (
        run_on
    )


def least(single: Array) -> float:
    """Sum of the misfits that runs of PSO are sure of by themselves, by the kindest count."""
    none, n = np.zeros((1, 1, FIELDS)), single.shape[1]
    sums = []
    for count in (one for one in COUNTS if one.stages == STAGES[0]):  # PSO has one stage
        found = statistics(Sample(2, single, single, single, none, none), count)
        good = _success(single)
        found["solved"] = np.atleast_1d(100.0 * np.prod((good.sum(axis=1) + 0.5) / (n + 1)))
        kinds = ("pso_iterations", "pso_errors", "solved")
        unknown = float((~good.any(axis=1)).mean())  # a posture without a time
        sums.append(unknown + sum(_misfit(STATEMENTS[name], found[name]) for name in kinds))
    return min(sums)


def statistics(s: Sample, count: Count) -> dict[str, Array]:
    """The statistic of each of STATEMENTS, in the unit and shape of its `paper`."""
    good, both, way = _success(s.single), _success(s.dual), _success(s.path)

    def typical(runs: Array, which: NDArray[np.bool_], dual: bool) -> float:
        counted = iterations(runs, dual, count)
        return _mean(_medians(counted, which & np.isfinite(counted)))

    def errors(runs: Array, which: NDArray[np.bool_]) -> Array:
        each = [_medians(runs[..., k], which) for k in (POSITION, ROTATION)]
        return np.array([1e3, 1.0]) * [
            np.median(e[np.isfinite(e)]) if np.isfinite(e).any() else np.nan for e in each
        ]

    work = [_medians(r[..., EVALUATIONS], g) for r, g in ((s.single, good), (s.dual, both))]
    m = s.dual[..., PARTICLES]
    counted = iterations(s.path, True, count)
    shown = counted[way & np.isfinite(counted)]
    spent, second = s.path[..., EVALUATIONS], s.path[..., PARTICLES]
    moved = s.path[..., [FIRST, SECOND, THIRD, AFTER]].sum(axis=-1)
    rounds = moved + 2 + (s.path[..., THIRD] > 0)  # with the first draws
    population = s.particles + second if count.added else spent / rounds
    n = s.single.shape[1]
    shares = np.concatenate([(g.sum(axis=1) + 0.5) / (n + 1) for g in (good, both)])
    values = {
        "pso_iterations": typical(s.single, good, False),
        "dpso_iterations": typical(s.dual, both, True),
        "solved": 100.0 * shares.prod(),
        "pso_errors": errors(s.single, good),
        "dpso_errors": errors(s.dual, both),
        "times": work[1] / work[0],
        "second": 100.0 * (both & (s.dual[..., STAGE] == 2)).mean(axis=1),
        "damping": 100.0 * _success(s.undamped).mean(),
        "fewer": 100.0 * (m < s.particles).mean(),
        "population": population[way].mean() if way.any() else np.nan,
        "path_iterations": shown.mean() if shown.size else np.nan,
        "path_work": (spent[way].mean() if way.any() else np.nan) / _mean(work[1]),
    }
    return {name: np.atleast_1d(value) for name, value in values.items()}


def misfits(found: dict[str, Array]) -> Array:
    """How far (len(STATEMENTS),) each statistic is beyond its tolerance: 0 met, 1 far off."""
    return np.array([_misfit(STATEMENTS[name], found[name]) for name in STATEMENTS])


def _misfit(statement: Statement, found: Array) -> float:
    paper = np.array(statement.paper)
    if statement.factor:
        with np.errstate(invalid="ignore", divide="ignore"):
            beyond = np.abs(np.log(found / paper)) - np.log(statement.factor)
        return float(np.mean(np.clip(np.where(np.isnan(beyond), np.inf, beyond) / FURTHEST, 0, 1)))
    if statement.chance:
        return float(np.clip(np.log(paper / found)[0] / np.log(1e4), 0.0, 1.0))
    short = np.array(statement.bound) * (paper - found)
    return float(np.mean(np.clip(short / 50.0, 0.0, 1.0)))
