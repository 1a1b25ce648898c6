"""Tune the swarms of the unpolished DPSO: fewest evaluations to a solution.

Differential evolution varies PSO-1 and the fallback swarm of the parameter set "tuned" and counts
the forward kinematics that the search spends until it succeeds, on targets of a seed of their own;
the best set and the shipped one are then compared on targets of another seed. No test uses either
seed. Evaluations are counted, not time, so the result is the same on every machine::

    python benchmarks/tune_dpso.py --generations 20
"""

from __future__ import annotations

import argparse

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table
from scipy.optimize import differential_evolution

from scara_drake import kinematics
from scara_drake.ik.kernels.dpso import dual_search_kernel
from scara_drake.ik.options import TUNED, Dpso, Swarm
from scara_drake.joints import LOWER, UPPER

Array = NDArray[np.float64]

TUNING_SEED, CHECKING_SEED = 7_000_000, 8_000_000
# Of a swarm: particles, iterations, inertia, its damping, c1, c2, largest speed, stall.
BOUNDS = [(8, 60), (10, 400), (0.3, 1.0), (0.97, 1.0), (0.0, 2.0), (0.5, 2.5), (0.02, 0.4), (5, 60)]


def with_swarms(x: Array) -> Dpso:
    """Return the tuned set with other swarms, from two rows of eight numbers."""

    def swarm(values: Array, position_weight: float, rotation_weight: float) -> Swarm:
        particles, iterations, stall = (round(values[k]) for k in (0, 1, 7))
        inertia, damping, personal, social, speed = (float(value) for value in values[2:7])
        return Swarm(
            particles, iterations, inertia, damping, personal, social, speed, stall,
            position_weight, rotation_weight,
        )  # fmt: skip

    return TUNED._replace(
        pso1=swarm(x[:8], 1.0, 0.0),
        fallback=swarm(x[8:], TUNED.fallback.position_weight, 1.0),
    )


def evaluations(parameters: Dpso, count: int, seed: int) -> Array:
    """Return the evaluations (count,) to a solution, or the budget where there was none."""
    rng = np.random.default_rng(seed)
    postures = rng.uniform(LOWER, UPPER, (count, 6))
    spent = np.empty(count)
    for k, X in enumerate(kinematics.forward_kinematics(postures)):
        p, R, q = X[:3, 3].copy(), X[:3, :3].copy(), postures[k].copy()
        spent[k], *_ = dual_search_kernel(parameters, p, R, 1, seed + k, np.empty((0, 2)), q)
    return spent


def main(arguments: list[str] | None = None) -> None:
    """Tune, and compare with the shipped set."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--generations", type=int, default=20)
    parser.add_argument("--targets", type=int, default=60)
    options = parser.parse_args(arguments)
    shipped = np.array([*TUNED.pso1[:8], *TUNED.fallback[:8]], dtype=np.float64)
    result = differential_evolution(
        lambda x: float(np.log(evaluations(with_swarms(x), options.targets, TUNING_SEED)).mean()),
        BOUNDS * 2,
        maxiter=options.generations,
        popsize=2,
        seed=TUNING_SEED,
        x0=np.clip(shipped, *np.array(BOUNDS * 2).T),
        polish=False,
    )
    table = Table(title="Evaluations to a solution, on targets not tuned on", title_justify="left")
    for heading in ("set", "median", "99 %", "largest"):
        table.add_column(heading, justify="left" if heading == "set" else "right")
    for name, parameters in (("shipped", TUNED), ("found", with_swarms(result.x))):
        spent = evaluations(parameters, 20 * options.targets, CHECKING_SEED)
        median, high = np.quantile(spent, (0.5, 0.99))
        table.add_row(name, f"{median:.0f}", f"{high:.0f}", f"{spent.max():.0f}")
    console = Console()
    console.print(table)
    console.print("found:", with_swarms(result.x))


if __name__ == "__main__":
    main()
