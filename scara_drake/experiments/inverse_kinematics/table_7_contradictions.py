"""What the paper's own numbers of its swarms exclude, whatever the coefficients of Table 7 are."""

from __future__ import annotations

from statistics import fmean

from scara_drake.experiments.claim import Claim, Criterion, at_least, within_factor
from scara_drake.experiments.inverse_kinematics.paths import POINTS
from scara_drake.experiments.inverse_kinematics.swarm_reported import (
    ITERATIONS,
    PATH_ITERATIONS,
    PATH_PARTICLES,
    PATH_TIME,
    TIMES,
)
from scara_drake.experiments.quantity import quantity
from scara_drake.ik.kernels.search import population_kernel


def contradictions() -> tuple[Claim, Claim]:
    """Judge the times of Table 8 by its counts, and those of Table 9 by those of Table 8."""
    return _work_against_counts(), _tables_8_and_9()


def _work_against_counts() -> Claim:
    """Compare times with counts: of three first draws and of one, none of more than N particles."""
    single, dual = ITERATIONS["PSO"], ITERATIONS["DPSO"]
    paper = quantity(fmean(TIMES["DPSO"]) / fmean(TIMES["PSO"]), "times")
    bound = quantity((dual + 3) / (single + 1), "times", bound="at most")
    share = bound.values[0] / paper.values[0]
    return Claim(
        "Time of DPSO over that of PSO, mean of Table 8",
        paper,
        bound,
        Criterion("the bound is not below it", at_least(bound)),
        "If both begin with N particles, no iteration of DPSO costs more than one of PSO, as "
        f"M < N, and it has {dual} to {single} of them, with the first draws {dual + 3} to "
        f"{single + 1}; time that both spend beside brings the ratio nearer to 1, never beyond. So "
        f"{dual} leaves out a stage that is timed, whatever the coefficients, unless PSO has fewer "
        f"than {share:.0%} of the particles of DPSO.",
    )


def _tables_8_and_9() -> Claim:
    """Compare the time of a path with that of its evaluations, each as long as in Table 8."""
    single, iterations, particles = fmean(TIMES["PSO"]), ITERATIONS["PSO"], population_kernel(6)
    each = single / (iterations * particles)
    spent = POINTS * PATH_PARTICLES * PATH_ITERATIONS
    total = quantity(
        {
            f"N = {particles}": spent * each,
            f"N = {PATH_PARTICLES}": spent * each * particles / PATH_PARTICLES,
        },
        "s",
    )
    kindest = quantity(min(total.values), "s")
    return Claim(
        f"A path of {POINTS} points with {PATH_PARTICLES} particles and {PATH_ITERATIONS} "
        f"iterations each takes {PATH_TIME} s",
        quantity(PATH_TIME, "s"),
        total,
        Criterion("the smaller within a factor of 2, ours", within_factor(kindest, 2.0)),
        f"An evaluation takes {1e6 * each:.0f} µs by Table 8: {single:.4f} s, {iterations} "
        f"iterations, N = {particles} of (20); less if PSO has {PATH_PARTICLES}. So the times of "
        "Tables 8 and 9 and both counts cannot all be right, whatever the coefficients. A start "
        "that is no iteration would have to take 0.18 to 0.21 s of each time in Table 8, where the "
        f"shortest is {min(map(min, TIMES.values()))} s in all.",
    )
