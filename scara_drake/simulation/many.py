"""Many runs, side by side: what the engine compiles in threads, what needs Drake in processes."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack
from dataclasses import dataclass, replace
from itertools import islice
from typing import Final, Generic, TypeVar

import xarray as xr

from scara_drake.common import checks
from scara_drake.common.parallel import job_count
from scara_drake.engine.errors import LeftTheModelError, NotCompilableError
from scara_drake.scenario import Scenario, check_scenario, dump_scenario
from scara_drake.simulation.processes import processes
from scara_drake.simulation.progress import CountLine
from scara_drake.simulation.run import run
from scara_drake.simulation.steppers import AUTO, COMPILED, DRAKE, ENGINES

Result = TypeVar("Result")
# What is kept of a run: a function of its scenario and its recording. To reach another process it
# has to be one that can be pickled.
Figure = Callable[[Scenario, xr.Dataset], Result]

FAILED: Final = "error: "  # begins the `ended_by` of a run that failed


@dataclass(frozen=True)
class Failed:
    """A run that broke off, in place of its result.

    Attributes:
        reason: one line.
    """

    reason: str


def simulate_many(
    scenarios: Iterable[Scenario],
    jobs: int | None = None,
    progress: bool = False,
    engine: str = AUTO,
) -> list[xr.Dataset]:
    """Simulate scenarios side by side and return their recordings, in order.

    A run that breaks off does not stop the others: its recording has no variables, and its
    attribute `ended_by` says why; a warning names it. Ctrl-C raises KeyboardInterrupt once the runs
    that are under way have ended. All recordings are in memory: `each_run` keeps less.

    Args:
        scenarios: from `load_scenario`; they are not changed.
        jobs: how many run side by side; all cores if None. With more than one, a script of your own
            calls this under ``if __name__ == "__main__":``.
        progress: shows a line with how many are done, their rate, and the time left.
        engine: see `simulate`.

    Raises:
        ValueError: a scenario has a value out of its bounds; nothing has been simulated then.
    """
    todo = list(scenarios)
    for scenario in todo:
        check_scenario(scenario)
    found: dict[int, xr.Dataset] = {}
    failed: list[str] = []
    with CountLine("runs", len(todo), on=progress) as line:
        for index, result in each_run(enumerate(todo), whole_recording, jobs, engine):
            if isinstance(result, Failed):
                failed.append(f"run {index}: {result.reason}")
                result = without_samples(todo[index], result)
            found[index] = result
            line.show(len(found), len(failed))
    if failed:
        more = f", and {len(failed) - 3} more" if len(failed) > 3 else ""
        warnings.warn(f"failed: {'; '.join(failed[:3])}{more}", stacklevel=2)
    return [found[index] for index in range(len(todo))]


def whole_recording(scenario: Scenario, recording: xr.Dataset) -> xr.Dataset:
    """Keep all of a run."""
    return recording


def without_samples(scenario: Scenario, failed: Failed) -> xr.Dataset:
    """Return what stands for the recording of a run that broke off."""
    text = dump_scenario(scenario)
    ended_by = f"{FAILED}{failed.reason}"
    return xr.Dataset(attrs={"scenario": text, "seed": scenario.seed, "ended_by": ended_by})


def each_run(
    scenarios: Iterable[tuple[int, Scenario]],
    figure: Figure[Result],
    jobs: int | None = None,
    engine: str = AUTO,
) -> Iterator[tuple[int, Result | Failed]]:
    """Simulate scenarios side by side; yield each one's number and its figure as it ends.

    What the engine compiles runs in threads, what needs Drake in processes. No more than `jobs` of
    the scenarios are taken ahead, so they may be made as they are needed.

    Args:
        scenarios: any number of them, each with a number of its own.
        figure: what is kept of a run: a function of its scenario and its recording.
        jobs: how many run side by side; all cores if None.
        engine: see `simulate`.

    Raises:
        KeyboardInterrupt: Ctrl-C; the runs that were under way have ended.
        ValueError: `jobs` or `engine` is out of its bounds.
    """
    count = job_count(jobs)
    checks.choice("engine", engine, ENGINES)
    todo = iter(scenarios)
    if count == 1:
        for number, scenario in todo:
            yield number, try_run(scenario, figure, engine)
        return
    with _Pools(count) as pools:
        waiting: _Waiting[Result] = {}
        while True:
            for number, scenario in islice(todo, count - len(waiting)):
                pools.start(_Try(number, scenario, figure, engine), waiting)
            if not waiting:
                return
            ended, _ = wait(waiting, return_when=FIRST_COMPLETED)
            for future in ended:
                tried = waiting.pop(future)
                try:
                    result = future.result()
                except (NotCompilableError, LeftTheModelError):
                    pools.start_in_process(tried, waiting)
                except BrokenProcessPool:
                    for each in (tried, *pools.renew(waiting)):
                        if each.lives == 0:
                            yield each.number, Failed("its process ended")
                        else:
                            again = replace(each, lives=each.lives - 1)
                            pools.start_in_process(again, waiting)
                    break  # what else has ended is among those that were started again
                else:
                    yield tried.number, result


def try_run(scenario: Scenario, figure: Figure[Result], engine: str) -> Result | Failed:
    """Simulate a scenario and return its figure, or why it has none.

    Raises:
        KeyboardInterrupt: the run was interrupted.
    """
    try:
        return try_once(scenario, figure, engine)
    except (NotCompilableError, LeftTheModelError) as error:
        return Failed(one_line(error))


def try_once(scenario: Scenario, figure: Figure[Result], engine: str = COMPILED) -> Result | Failed:
    """Do as `try_run`, but raise where the engine cannot.

    Raises:
        NotCompilableError, LeftTheModelError: it needs Drake.
    """
    try:
        return figure(scenario, recorded(scenario, engine))
    except (NotCompilableError, LeftTheModelError):
        raise
    except (ValueError, RuntimeError, ArithmeticError) as error:
        return Failed(one_line(error))


def one_line(error: BaseException) -> str:
    """Return what an error says, in one line."""
    return checks.shown(str(error) or type(error).__name__, 300, quotes=False)


def recorded(scenario: Scenario, engine: str = AUTO) -> xr.Dataset:
    """Simulate a scenario and return its recording; of a run that fails nothing is kept.

    Raises:
        KeyboardInterrupt: the run was interrupted.
        ValueError, RuntimeError: the run failed.
    """
    result = run(scenario, engine)
    if result.interrupted:
        raise KeyboardInterrupt
    return result.recording


@dataclass(frozen=True)
class _Try(Generic[Result]):
    """A run on its way; `lives` are how often it may be tried again if its process ends."""

    number: int
    scenario: Scenario
    figure: Figure[Result]
    engine: str
    lives: int = 2


_Waiting = dict[Future[Result | Failed], _Try[Result]]


class _Pools:
    """The threads and the processes of many runs; both begin when they are needed."""

    def __init__(self, jobs: int) -> None:
        self._jobs = jobs
        self._threads = ThreadPoolExecutor(jobs, "scara_drake_run")
        self._stack = ExitStack()
        self._processes = self._stack.enter_context(processes(jobs))

    def start(self, run: _Try[Result], waiting: _Waiting[Result]) -> None:
        """Let a run begin, to be waited for: in a thread if the engine may do it."""
        if run.engine == DRAKE:
            self.start_in_process(run, waiting)
        else:
            waiting[self._threads.submit(try_once, run.scenario, run.figure)] = run

    def start_in_process(self, run: _Try[Result], waiting: _Waiting[Result]) -> None:
        """Let a run begin in a process."""
        future = self._processes.submit(try_run, run.scenario, run.figure, run.engine)
        waiting[future] = run

    def renew(self, waiting: _Waiting[Result]) -> list[_Try[Result]]:
        """Make new processes, as one has ended; return the runs that wait, which begin anew."""
        self._stack.close()
        self._processes = self._stack.enter_context(processes(self._jobs))
        runs = list(waiting.values())
        waiting.clear()
        return runs

    def __enter__(self) -> _Pools:
        return self

    def __exit__(self, *error: object) -> None:
        self._threads.shutdown(cancel_futures=True)
        self._stack.close()
