"""The runs of a search, in this process or in several."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager

import numpy as np

from scara_drake.scenario import Scenario
from scara_drake.simulation.many import recorded
from scara_drake.simulation.processes import processes
from scara_drake.tuning.cost import Cost, Figures

# A scenario, its cost, and whether a failure of the run is an error.
Task = tuple[Scenario, Cost, bool]
Simulators = Callable[[list[Task]], Iterable[Figures | None]]


@contextmanager
def simulators(jobs: int) -> Iterator[Simulators]:
    """Yield what simulates tasks, in order, in this process or in several."""
    if jobs == 1:
        yield lambda tasks: map(simulate_task, tasks)
        return
    with processes(jobs) as pool:
        yield lambda tasks: pool.map(simulate_task, tasks)


def simulate_task(task: Task) -> Figures | None:
    """Return the figures of a run; None if it failed or if they are not finite.

    Raises:
        KeyboardInterrupt: the run was interrupted.
        ValueError, RuntimeError: the run failed, where that is an error.
    """
    scenario, cost, must_succeed = task
    try:
        recording = recorded(scenario)
    except (ValueError, RuntimeError):
        if must_succeed:
            raise
        return None
    figures = cost.figures(recording)
    if np.isfinite([figures.tracking, figures.effort]).all():
        return figures
    if must_succeed:
        raise RuntimeError("the run with the start gains has errors that are not finite")
    return None
