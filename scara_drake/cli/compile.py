"""The command `scara-drake compile`: compile the kernels, so that no later command has to."""

from __future__ import annotations

import argparse
import io
import time
from collections.abc import Iterable

from rich.console import Console

from scara_drake import ik, kinematics
from scara_drake.cli.compile_line import counted_kernels
from scara_drake.joints import HOME
from scara_drake.scenario import Scenario, load_scenario, scenario_names
from scara_drake.simulation.kernels import compile_kernels


def run(options: argparse.Namespace, console: Console) -> None:
    """Compile what some scenarios need, all shipped ones if none is named, and the solvers.

    Raises:
        ValueError: a scenario is not valid.
    """
    scenarios = [load_scenario(name) for name in options.scenarios or scenario_names()]
    start = time.perf_counter()
    count = compile_all(scenarios)
    console.print(f"Compiled: {count} kernels in {time.perf_counter() - start:.0f} s.")


def compile_all(scenarios: Iterable[Scenario]) -> int:
    """Compile what some scenarios need, and the solvers; return how many kernels that were."""
    with counted_kernels(Console(file=io.StringIO())) as line:  # `main` shows it
        for scenario in scenarios:
            compile_kernels(scenario)
        X_WE = kinematics.forward_kinematics(HOME)
        for method in ik.METHODS:
            ik.solve(X_WE, method)
        ik.solve_all(X_WE)
    return line.count
