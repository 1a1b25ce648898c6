"""Table 8: the traditional PSO against DPSO on the four desired postures, with the mast."""

from __future__ import annotations

import time
from typing import Any, Final

import numpy as np
import xarray as xr

from scara_drake import ik, kinematics
from scara_drake.experiments.claim import (
    Claim,
    Criterion,
    Experiment,
    at_least,
    at_most,
    ordered,
    within_factor,
)
from scara_drake.experiments.inverse_kinematics import table_8_readings
from scara_drake.experiments.inverse_kinematics.postures import (
    NUMBERS,
    REFERENCE_HEIGHT,
    angle_difference,
    home,
    success,
    targets,
)
from scara_drake.experiments.inverse_kinematics.swarm_reported import (
    ITERATIONS,
    POSITION_ERRORS,
    ROTATION_ERRORS,
    TIMES,
)
from scara_drake.experiments.quantity import quantity
from scara_drake.experiments.reading import OpenQuestion
from scara_drake.ik.kernels.search import ALLOWED_TIME
from scara_drake.ik.options import PAPER
from scara_drake.ik.result import POSITION_TOLERANCE, ROTATION_TOLERANCE
from scara_drake.recordings.labels import labelled

# PAPER without its last stage, to see what PSO-2 reaches by itself.
TWO_STAGES: Final = PAPER._replace(fallback=PAPER.fallback._replace(iterations=0))
# "paper": one pass with the coefficients of experiment table_7. "tuned": passes
# until one ends inside the tolerances. "polished": the package's own, refined by least squares.
SOLVERS: Final[dict[str, tuple[str, dict[str, Any]]]] = {
    "PSO, paper": ("pso", {"parameters": "paper"}),
    "DPSO, paper": ("dpso", {"parameters": "paper", "polish": False}),
    "DPSO, paper, PSO-1 and PSO-2 only": ("dpso", {"parameters": TWO_STAGES, "polish": False}),
    "PSO, tuned": ("pso", {}),
    "DPSO, tuned": ("dpso", {"polish": False}),
    "DPSO, polished": ("dpso", {}),
}

PAPER_SOLVED = quantity(100, "%", "8 of 8 solutions")
# Of PSO, then of DPSO.
PAPER_POSITION = quantity(list(POSITION_ERRORS.values()), "mm")
PAPER_ROTATION = quantity(list(ROTATION_ERRORS.values()), "rad")
PAPER_PSO_TIME, PAPER_DPSO_TIME = (quantity(times, "s", name) for name, times in TIMES.items())
PAPER_ITERATIONS = quantity({name: ITERATIONS[name] for name in ("DPSO", "PSO")}, "iterations")


def run(seed: int = 0, draws: int = 20, arm_draws: int = 1) -> Experiment:
    """Solve each posture by each of SOLVERS with several draws.

    Args:
        seed: of the first draw; draw k has seed + k.
        draws: for each posture.
        arm_draws: for each posture by the arm alone, which tries in vain until its budget ends.
    """
    X_WE, shape = targets(), (len(SOLVERS), len(NUMBERS), draws)
    q, wall_time = np.empty((*shape, 6)), np.empty(shape)
    evaluations, iterations = np.empty(shape, np.int64), np.empty(shape, np.int64)
    for i, (method, options) in enumerate(SOLVERS.values()):
        ik.solve(X_WE[1], method, q_seed=home(), **options)  # compiles
        for k, d in np.ndindex(shape[1:]):
            begin = time.perf_counter()
            answer = ik.solve(X_WE[k], method, q_seed=home(), seed=seed + d, **options)
            wall_time[i, k, d] = time.perf_counter() - begin
            q[i, k, d] = answer.q
            evaluations[i, k, d], iterations[i, k, d] = answer.evaluations, answer.iterations
    X = kinematics.forward_kinematics(q)
    position, rotation = kinematics.pose_error(X_WE[:, np.newaxis], X)
    dims = ("solver", "posture", "draw")
    data = xr.Dataset(
        {
            "position_error": labelled(dims, position, "m", "E_p"),
            "rotation_error": labelled(dims, rotation, "rad", "E_o, angle of the rotation left"),
            "angle_difference": labelled(
                dims,
                angle_difference(X_WE[:, np.newaxis], X),
                "rad",
                "E_o as the difference of roll, pitch and yaw",
            ),
            "evaluations": labelled(dims, evaluations, "1", "forward kinematics spent"),
            "iterations": labelled(dims, iterations, "1", "of the swarms, with steps of a polish"),
            "wall_time": labelled(dims, wall_time, "s", "of one solution", measured=True),
        },
        coords={"solver": list(SOLVERS), "posture": list(NUMBERS)},
        attrs={"seed": seed, "mast_height": REFERENCE_HEIGHT},
    )
    data = data.merge(
        table_8_readings.arm_alone(seed, arm_draws, SOLVERS), combine_attrs="override"
    )
    return Experiment("Table 8", data, claims(data), questions(data))


def questions(data: xr.Dataset) -> tuple[OpenQuestion, ...]:
    """Show what the claims become without the mast, and by another E_o; see `run` for the data."""
    return table_8_readings.questions(data, _within_tolerance, _small_errors)


def claims(data: xr.Dataset) -> list[Claim]:
    """Judge Table 8; see `run` for the data."""
    good = success(data)
    return [
        *(_within_tolerance(data, good, kind) for kind in ("paper", "tuned")),
        _small_errors(data, good, "DPSO, tuned", "unpolished"),
        _small_errors(data, good, "DPSO, polished", "ours, polished"),
        *(_iterations(data, good, kind) for kind in ("paper", "tuned")),
        _second_swarm(data, good),
        _times(data),
    ]


def _within_tolerance(data: xr.Dataset, good: xr.DataArray, kind: str) -> Claim:
    share = good.sel(solver=[f"PSO, {kind}", f"DPSO, {kind}"]).mean("draw")
    low = 100 * share.min("posture")
    worst = quantity(
        {name.split(",")[0]: float(low.sel(solver=name)) for name in low.solver.values},
        "%",
        "of the draws, worst posture",
    )
    passes = data.evaluations.sel(solver=[f"PSO, {kind}", f"DPSO, {kind}"])
    spent = f"from {int(passes.min())} to {int(passes.max())} evaluations are spent on a posture."
    return Claim(
        f"PSO and DPSO meet both tolerances at all four postures ({kind} coefficients)",
        PAPER_SOLVED,
        worst,
        Criterion(
            "95 % of the draws or more at each posture (in kind: some at each); the share is ours",
            at_least(worst, 0.95),
            min(worst.values) > 0.0,
        ),
        "One pass as published; Table 7 is lost, and ours are what a search found nearest; " + spent
        if kind == "paper"
        else "Coefficients found by search, and a new pass where one fails: " + spent,
    )


def _small_errors(data: xr.Dataset, good: xr.DataArray, solver: str, which: str) -> Claim:
    hits = data.where(good).sel(solver=solver)
    position = quantity(1e3 * hits.position_error.median("draw"), "mm")
    rotation = quantity(hits.rotation_error.median("draw"), "rad")
    bound, angle = max(PAPER_POSITION.values), max(PAPER_ROTATION.values)
    large = [
        f"posture {n}: {quantity(p, 'mm')}, {quantity(r, 'rad')}"
        for n, p, r in zip(data.posture.values, position.values, rotation.values, strict=True)
        if not (p <= bound and r <= angle)
    ]
    return Claim(
        f"DPSO errors below 1 mm and 0.005 rad ({which})",
        (PAPER_POSITION, PAPER_ROTATION),
        (position, rotation),
        Criterion(
            "medians of the successful draws no more than the paper's largest at all four postures "
            "(in kind: each at three)",
            (at_most(position), at_most(rotation)),
            (at_most(position, share=0.75), at_most(rotation, share=0.75)),
        ),
        f"Larger: {'; '.join(large)}. {_why_large(hits, solver)}"
        if large
        else f"The largest of the medians are {quantity(max(position.values), 'mm')} and "
        f"{quantity(max(rotation.values), 'rad')}.",
    )


def _why_large(hits: xr.Dataset, solver: str) -> str:
    if solver == "DPSO, tuned":
        ends = 100 * hits.position_error.median() / POSITION_TOLERANCE
        turns = 100 * hits.rotation_error.median() / ROTATION_TOLERANCE
        return (
            f"The swarm ends at its first particle inside both tolerances, at {ends:.0f} % of the "
            f"one and {turns:.0f} % of the other, so smaller errors need another stop rule than "
            "the one described."
        )
    least = (hits.position_error / POSITION_TOLERANCE).min("draw")
    inexact = [f"posture {n}" for n in hits.posture.values if float(least.sel(posture=n)) > 1e-3]
    where = ", ".join(inexact) or "none"
    return f"Without an exact solution inside the ranges of Table 2, see Table 5: {where}."


def _iterations(data: xr.Dataset, good: xr.DataArray, kind: str) -> Claim:
    medians = data.where(good).iterations.median("draw").mean("posture")
    mean = quantity(
        {name: float(medians.sel(solver=f"{name}, {kind}")) for name in PAPER_ITERATIONS.names},
        "iterations",
    )
    first = data.iterations.sel(solver="DPSO, paper, PSO-1 and PSO-2 only")
    alone = data.iterations.sel(solver="PSO, paper").where(good.sel(solver="PSO, paper"))
    return Claim(
        f"DPSO needs fewer iterations than PSO ({kind} coefficients)",
        PAPER_ITERATIONS,
        mean,
        Criterion(
            "fewer, and both counts within a factor of 1.5 (in kind: fewer); medians of the "
            "successful draws, averaged over the postures with any, all stages of DPSO added; the "
            "factor is ours",
            (ordered(mean), within_factor(mean, 1.5)),
            ordered(mean),
        ),
        f"With the paper's coefficients PSO-1 and PSO-2 take {float(first.median()):.0f} iterations"
        f" and a PSO that succeeds takes {float(alone.median()):.0f}; the single swarm comes on "
        "top where PSO-2 fails.",
    )


def _second_swarm(data: xr.Dataset, good: xr.DataArray) -> Claim:
    solver = "DPSO, paper, PSO-1 and PSO-2 only"
    share = good.sel(solver=solver).mean("draw")
    simple, others = share.sel(posture=[3, 4]), share.sel(posture=[1, 2])
    failed = data.sel(solver=solver).where(~good.sel(solver=solver))
    return Claim(
        "PSO-2 suffices for postures 3 and 4; the others need the single swarm",
        "3 and 4",
        quantity({f"posture {n}": 100 * float(share.sel(posture=n)) for n in NUMBERS}, "%"),
        Criterion(
            "PSO-1 and PSO-2 succeed in half of the draws or more at 3 and 4, in fewer at 1 and 2 "
            "(in kind: oftener at 3 and 4); the half is ours",
            bool(simple.min() >= 0.5 > others.max()),
            bool(simple.mean() > others.mean()),
        ),
        "A tool position leaves the arm a two-parameter motion, with the mast three, and joint 6 "
        f"free, so that PSO-1's best seldom lies within {TWO_STAGES.radius:g} rad of a full "
        f"answer. The draws that fail are {quantity(1e3 * failed.position_error.median(), 'mm')} "
        f"and {quantity(failed.rotation_error.median(), 'rad')} off in the median.",
    )


def _times(data: xr.Dataset) -> Claim:
    seconds = 1e3 * data.wall_time.median("draw").mean("posture")
    late = sum(t > ALLOWED_TIME for t in PAPER_DPSO_TIME.values)
    return Claim(
        "Solving time of PSO and of DPSO",
        (PAPER_PSO_TIME, PAPER_DPSO_TIME),
        quantity(
            {
                name: float(seconds.sel(solver=name))
                for name in ("PSO, tuned", "DPSO, tuned", "DPSO, polished")
            },
            "ms",
            clock=True,
        ),
        None,
        f"Other machine, compiled code. {late} of the paper's {len(PAPER_DPSO_TIME.values)} times "
        f"of DPSO exceed its own t_allow of {ALLOWED_TIME} s.",
    )
