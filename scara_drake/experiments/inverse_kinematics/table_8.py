"""Table 8: the traditional PSO against DPSO on the four desired postures, with the mast."""

from __future__ import annotations

import time
from typing import Any, Final

import numpy as np
import xarray as xr

from scara_drake import ik, kinematics
from scara_drake.experiments.claim import NOT_COMPARABLE, Claim, Experiment, judge, span, variable
from scara_drake.experiments.inverse_kinematics.postures import (
    NUMBERS,
    REFERENCE_HEIGHT,
    angle_difference,
    home,
    targets,
)
from scara_drake.ik.options import PAPER
from scara_drake.ik.result import POSITION_TOLERANCE, ROTATION_TOLERANCE

# PAPER without its last stage, to see what PSO-2 reaches by itself.
TWO_STAGES: Final = PAPER._replace(fallback=PAPER.fallback._replace(iterations=0))
# "paper": one pass with assumed coefficients, since the paper's Table 7 is lost. "tuned": passes
# until one ends inside the tolerances. "polished": the package's own, refined by least squares.
SOLVERS: Final[dict[str, tuple[str, dict[str, Any]]]] = {
    "PSO, paper": ("pso", {"parameters": "paper"}),
    "DPSO, paper": ("dpso", {"parameters": "paper", "polish": False}),
    "DPSO, paper, PSO-1 and PSO-2 only": ("dpso", {"parameters": TWO_STAGES, "polish": False}),
    "PSO, tuned": ("pso", {}),
    "DPSO, tuned": ("dpso", {"polish": False}),
    "DPSO, polished": ("dpso", {}),
}

PAPER_POSITION = (0.14e-3, 0.05e-3, 0.04e-3, 0.15e-3, 0.45e-3, 0.88e-3, 0.58e-3, 0.28e-3)  # [m]
PAPER_ROTATION = (0.0013, 0.0023, 0.0022, 0.0015, 0.005, 0.0002, 0.0025, 0.0005)  # [rad]
PAPER_PSO_TIME, PAPER_DPSO_TIME = (0.242, 0.21, 0.25, 0.28), (0.325, 0.29, 0.19, 0.22)  # [s]
PAPER_ITERATIONS = {"PSO": 66, "DPSO": 52}
ALLOWED_TIME = 0.25  # t_allow of the paper [s]


def run(seed: int = 0, draws: int = 20) -> Experiment:
    """Solve each posture by each of SOLVERS with several draws.

    Args:
        seed: of the first draw; draw k has seed + k.
        draws: for each posture.
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
            "position_error": variable(dims, position, "m", "E_p"),
            "rotation_error": variable(dims, rotation, "rad", "E_o, angle of the rotation left"),
            "angle_difference": variable(
                dims,
                angle_difference(X_WE[:, np.newaxis], X),
                "rad",
                "E_o as the difference of roll, pitch and yaw",
            ),
            "evaluations": variable(dims, evaluations, "1", "forward kinematics spent"),
            "iterations": variable(dims, iterations, "1", "of the swarms, with steps of a polish"),
            "wall_time": variable(dims, wall_time, "s", "of one solution", measured=True),
        },
        coords={"solver": list(SOLVERS), "posture": list(NUMBERS)},
        attrs={"seed": seed, "mast_height": REFERENCE_HEIGHT},
    )
    return Experiment("Table 8", data, claims(data))


def success(data: xr.Dataset) -> xr.DataArray:
    """Return whether each answer is inside both tolerances."""
    return (data.position_error <= POSITION_TOLERANCE) & (data.rotation_error <= ROTATION_TOLERANCE)


def claims(data: xr.Dataset) -> list[Claim]:
    """Judge Table 8; see `run` for the data."""
    good = success(data)
    return [
        *_within_tolerance(good),
        *_small_errors(data, good),
        *_iterations(data, good),
        _second_swarm(good),
        _times(data),
    ]


def _within_tolerance(good: xr.DataArray) -> list[Claim]:
    found = []
    for kind in ("paper", "tuned"):
        share = good.sel(solver=[f"PSO, {kind}", f"DPSO, {kind}"]).mean("draw")
        low = share.min("posture")
        found.append(
            Claim(
                f"PSO and DPSO meet both tolerances at all four postures ({kind} coefficients)",
                "8 of 8 solutions",
                "worst posture: "
                + ", ".join(
                    f"{name.split(',')[0]} {100 * float(low.sel(solver=name)):.0f} %"
                    for name in low.solver.values
                ),
                judge(bool(low.min() >= 0.95), bool(low.min() > 0.0)),
                "Criterion: 95 % of the draws or more at each posture (in kind: some at each). "
                + (
                    "One pass as published; Table 7 with its coefficients is lost, so ours are a "
                    "guess."
                    if kind == "paper"
                    else "Coefficients found by search, and a new pass where one fails."
                ),
            )
        )
    return found


def _small_errors(data: xr.Dataset, good: xr.DataArray) -> list[Claim]:
    found = []
    for name, solver in (
        ("DPSO, tuned", "unpolished"),
        ("DPSO, polished", "ours, polished"),
    ):
        hits = data.where(good).sel(solver=name)
        position = hits.position_error.median("draw")
        rotation = hits.rotation_error.median("draw")
        small = (position <= 1e-3) & (rotation <= 5e-3)
        large = [
            f"posture {int(n)}: {1e3 * float(position.sel(posture=n)):.1f} mm, "
            f"{float(rotation.sel(posture=n)):.3f} rad"
            for n in data.posture.values
            if not small.sel(posture=n)
        ]
        why = (
            " A swarm that ends at the first particle inside 5 mm and 0.0175 rad ends near those "
            "bounds, so smaller errors need another stop rule than the one described."
            if name == "DPSO, tuned"
            else " Posture 1 has no exact solution inside Table 2, see Table 5."
        )
        found.append(
            Claim(
                f"DPSO errors below 1 mm and 0.005 rad ({solver})",
                f"{span(PAPER_POSITION, 2, 1e3)} mm, {span(PAPER_ROTATION, 4)} rad",
                f"{span(position.values, 2, 1e3)} mm, {span(rotation.values, 4)} rad",
                judge(bool(small.all()), small.sum() >= 3),
                "Criterion: medians of the successful draws at all four postures (in kind: at "
                "three)." + (f" Larger: {'; '.join(large)}.{why}" if large else ""),
            )
        )
    return found


def _iterations(data: xr.Dataset, good: xr.DataArray) -> list[Claim]:
    found = []
    for kind in ("paper", "tuned"):
        hits = data.where(good)
        mean = {
            name: float(hits.iterations.sel(solver=f"{name}, {kind}").median("draw").mean())
            for name in PAPER_ITERATIONS
        }
        near = all(n / 1.5 <= mean[name] <= 1.5 * n for name, n in PAPER_ITERATIONS.items())
        fewer = mean["DPSO"] < mean["PSO"]
        found.append(
            Claim(
                f"DPSO needs fewer iterations than PSO ({kind} coefficients)",
                "52 against 66",
                f"{mean['DPSO']:.0f} against {mean['PSO']:.0f}",
                judge(fewer and near, fewer),
                "Criterion: fewer, and both counts within a factor of 1.5 (in kind: fewer). Medians"
                " of the successful draws, averaged over the postures with any, all stages of DPSO "
                "added."
                + (
                    ""
                    if fewer
                    else " PSO-1 alone takes about as many as a PSO that succeeds, and PSO-2 or the"
                    " single swarm comes on top."
                ),
            )
        )
    return found


def _second_swarm(good: xr.DataArray) -> Claim:
    share = good.sel(solver="DPSO, paper, PSO-1 and PSO-2 only").mean("draw")
    simple, others = share.sel(posture=[3, 4]), share.sel(posture=[1, 2])
    return Claim(
        "PSO-2 suffices for postures 3 and 4; the others need the single swarm",
        "3 and 4",
        ", ".join(f"{int(n)}: {100 * float(share.sel(posture=n)):.0f} %" for n in (1, 2, 3, 4)),
        judge(
            bool(simple.min() >= 0.5 > others.max()),
            bool(simple.mean() > others.mean()),
        ),
        "Criterion: PSO-1 and PSO-2 succeed in half of the draws or more at 3 and 4, in fewer at 1 "
        "and 2 (in kind: oftener at 3 and 4). A tool position leaves the arm a two-parameter "
        "motion, with the mast three, and joint 6 free, so that PSO-1's best seldom lies within "
        "0.174 rad of a full answer.",
    )


def _times(data: xr.Dataset) -> Claim:
    seconds = data.wall_time.median("draw").mean("posture")
    late = sum(t > ALLOWED_TIME for t in PAPER_DPSO_TIME)
    return Claim(
        "Solving time of PSO and of DPSO",
        f"{span(PAPER_PSO_TIME)} s and {span(PAPER_DPSO_TIME)} s",
        f"{1e3 * float(seconds.sel(solver='PSO, tuned')):.1f} ms and "
        f"{1e3 * float(seconds.sel(solver='DPSO, tuned')):.1f} ms (tuned), "
        f"{1e3 * float(seconds.sel(solver='DPSO, polished')):.2f} ms (polished)",
        NOT_COMPARABLE,
        f"Other machine, compiled code. {late} of the paper's 4 times of DPSO exceed its own "
        f"t_allow of {ALLOWED_TIME} s.",
    )
