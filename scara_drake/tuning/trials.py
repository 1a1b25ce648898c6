"""The runs of a search, one after the other or side by side."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager

import numpy as np

from scara_drake.engine.errors import LeftTheModelError, NotCompilableError
from scara_drake.scenario import Scenario
from scara_drake.simulation.many import recorded
from scara_drake.simulation.processes import processes
from scara_drake.simulation.steppers import AUTO, COMPILED, DRAKE
from scara_drake.tuning.cost import Cost, Figures

# A scenario, its cost, and whether a failure of the run is an error.
Task = tuple[Scenario, Cost, bool]
Simulators = Callable[[list[Task]], Iterable[Figures | None]]


@contextmanager
def simulators(jobs: int) -> Iterator[Simulators]:
    """Yield what simulates tasks, in order: one by one, or side by side.

    Side by side, what the engine compiles runs in threads, and what needs Drake in processes.
    """
    if jobs == 1:
        yield lambda tasks: map(simulate_task, tasks)
        return
    with ThreadPoolExecutor(jobs) as threads, processes(jobs) as pool:

        def simulate_here(task: Task) -> Figures | None:
            try:
                return simulate_task(task, COMPILED)
            except (NotCompilableError, LeftTheModelError):
                return pool.submit(simulate_task, task, DRAKE).result()

        try:
            yield lambda tasks: threads.map(simulate_here, tasks)
        finally:
            threads.shutdown(cancel_futures=True)


def simulate_task(task: Task, engine: str = AUTO) -> Figures | None:
    """Return the figures of a run; None if it failed or if they are not finite.

    Raises:
        NotCompilableError, LeftTheModelError: only Drake can simulate it, and it was not to.
        KeyboardInterrupt: the run was interrupted.
        ValueError, RuntimeError: the run failed, where that is an error.
    """
    scenario, cost, must_succeed = task
    try:
        recording = recorded(scenario, engine)
    except (NotCompilableError, LeftTheModelError):
        raise
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
