"""How the swarms of DPSOIJ find first postures: success, evaluations, time, the fallback's share.

Random first commands of both tasks, the arm alone, nearest to home as the loop starts::

    python benchmarks/ik_first_posture.py --targets 1000
"""

from __future__ import annotations

import argparse

import numpy as np
from rich.console import Console
from rich.table import Table

from scara_drake import ik, kinematics
from scara_drake.joints import HOME, LOWER, UPPER

SEED = 9_000_000


def commands(count: int, task: str) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return poses (4, 4) and home at the mast's height (6,); any orientation for "position"."""
    rng = np.random.default_rng(SEED)
    drawn = []
    for q in rng.uniform(LOWER, UPPER, (count, 6)):
        X = kinematics.forward_kinematics(q)
        if task == "position":
            X[:3, :3] = kinematics.rotation_from_intrinsic_xyz(rng.uniform(-np.pi, np.pi, 3))
        drawn.append((X, np.array([q[0], *HOME[1:]])))
    return drawn


def main(arguments: list[str] | None = None) -> None:
    """Measure and print a table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--targets", type=int, default=1000)
    options = parser.parse_args(arguments)
    table = Table(title=f"{options.targets} first commands of each task", title_justify="left")
    for heading in ("task", "met", "by swarm", "evaluations", "95 %", "ms", "95 %", "largest"):
        table.add_column(heading, justify="right")
    for task in ("pose", "position"):
        answers = [
            ik.solve(X, "dpsoij", "arm", task, q_seed=near, seed=k, nearest_to=near)
            for k, (X, near) in enumerate(commands(options.targets + 1, task))
        ][1:]  # the first one loads the kernels
        spent = np.quantile([answer.evaluations for answer in answers], (0.5, 0.95))
        time = 1e3 * np.quantile([answer.seconds for answer in answers], (0.5, 0.95, 1.0))
        table.add_row(
            task,
            f"{100 * np.mean([answer.success for answer in answers]):g} %",
            f"{100 * np.mean([answer.found_by == 'dpso' for answer in answers]):g} %",
            *(f"{value:.0f}" for value in spent),
            *(f"{value:.1f}" for value in time),
        )
    Console().print(table)


if __name__ == "__main__":
    main()
