"""The runs of a search, in this process or in several."""

from __future__ import annotations

import multiprocessing
import signal
import tempfile
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from scara_drake.scenario import Scenario
from scara_drake.simulation.run import run
from scara_drake.tuning.cost import Cost, Figures

# A scenario, its cost, and whether a failure of the run is an error.
Task = tuple[Scenario, Cost, bool]
# Each run leaves 2 MB in its process, see `simulate`.
RUNS_PER_PROCESS = 50
Simulators = Callable[[list[Task]], Iterable[Figures | None]]


@contextmanager
def simulators(jobs: int) -> Iterator[Simulators]:
    """Yield what simulates tasks, in order, in this process or in several."""
    if jobs == 1:
        yield lambda tasks: map(simulate_task, tasks)
        return
    processes = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(
        jobs, processes, _leave_interrupts, max_tasks_per_child=RUNS_PER_PROCESS
    ) as pool:
        try:
            yield lambda tasks: pool.map(simulate_task, tasks)
        finally:
            pool.shutdown(cancel_futures=True)


def _leave_interrupts() -> None:
    """Ctrl-C reaches every process of the terminal; a run takes it, an idle process does not."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def simulate_task(task: Task) -> Figures | None:
    """Return the figures of a run; None if it failed or if they are not finite.

    Raises:
        KeyboardInterrupt: the run was interrupted.
        ValueError, RuntimeError: the run failed, where that is an error.
    """
    scenario, cost, must_succeed = task
    try:
        with tempfile.TemporaryDirectory(prefix="scara_drake_") as folder:
            result = run(scenario, Path(folder) / "run.journal")
    except (ValueError, RuntimeError):
        if must_succeed:
            raise
        return None
    if result.interrupted:
        raise KeyboardInterrupt
    figures = cost.figures(result.recording)
    if np.isfinite([figures.tracking, figures.effort]).all():
        return figures
    if must_succeed:
        raise RuntimeError("the run with the start gains has errors that are not finite")
    return None
