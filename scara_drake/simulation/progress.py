"""The line that a run, or a study of many, shows of itself."""

from __future__ import annotations

from typing import Self

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    Task,
    TextColumn,
    TimeRemainingColumn,
)
from rich.text import Text


class _Line:
    """A progress bar that is there within a `with`; shows nothing if not on.

    It is drawn by a thread of its own, `drawn` times a second.
    """

    def __init__(self, *columns: ProgressColumn, on: bool, drawn: float = 10.0) -> None:
        console = Console(stderr=True)
        self._bar = Progress(*columns, console=console, disable=not on, refresh_per_second=drawn)

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._bar.stop()


class ProgressLine(_Line):
    """A progress bar with the simulated time and the real-time factor; shows nothing if not on.

    Where the output is no terminal, one plain line is printed at the end. To draw it takes
    milliseconds of Python, so a run in real time is shown seldom.

    Args:
        name: of the run.
        duration: [s].
        on: shows nothing otherwise.
        paced: whether it runs in real time.
    """

    def __init__(self, name: str, duration: float, on: bool, paced: bool = False):
        super().__init__(
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.completed:6.1f} of {task.total:g} s"),
            TextColumn("{task.fields[factor]:5.2f} x real time"),
            TimeRemainingColumn(),
            on=on,
            drawn=2.0 if paced else 10.0,
        )
        self._task = self._bar.add_task(name, total=duration, factor=0.0)

    def show(self, simulated: float, factor: float) -> None:
        """Show the simulated time [s] and the real-time factor."""
        self._bar.update(self._task, completed=simulated, factor=factor)


class CountLine(_Line):
    """A progress bar with how many of some runs are done, their rate and the time left.

    Args:
        name: of them.
        total: how many there are.
        done: how many were done before.
        on: shows nothing otherwise.
    """

    def __init__(self, name: str, total: int, done: int = 0, on: bool = True) -> None:
        super().__init__(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            _Rate(),
            TimeRemainingColumn(),
            TextColumn("{task.fields[failed]}"),
            on=on,
        )
        self._task = self._bar.add_task(name, total=total, completed=done, failed="")

    def show(self, done: int, failed: int) -> None:
        """Show how many are done in all, and how many of them failed."""
        told = f"{failed} failed" if failed else ""
        self._bar.update(self._task, completed=done, failed=told)


class _Rate(ProgressColumn):
    """Runs a second, or a minute where they are few; those done before do not count."""

    def render(self, task: Task) -> Text:
        rate = task.finished_speed or task.speed
        if rate is None:
            return Text("")
        return Text(f"{rate:.1f} runs/s" if rate >= 1.0 else f"{60.0 * rate:.1f} runs/min")
