"""The line that a run, or a study of many, shows of itself."""

from __future__ import annotations

from types import TracebackType

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


class ProgressLine:
    """A progress bar with the simulated time and the real-time factor; shows nothing if not on.

    Where the output is no terminal, one plain line is printed at the end.
    """

    def __init__(self, name: str, duration: float, on: bool):
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.completed:6.1f} of {task.total:g} s"),
            TextColumn("{task.fields[factor]:5.2f} x real time"),
            TimeRemainingColumn(),
            console=Console(stderr=True),
            disable=not on,
        )
        self._task = self._bar.add_task(name, total=duration, factor=0.0)

    def __enter__(self) -> ProgressLine:
        self._bar.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._bar.stop()

    def show(self, simulated: float, factor: float) -> None:
        """Show the simulated time [s] and the real-time factor."""
        self._bar.update(self._task, completed=simulated, factor=factor)


class CountLine:
    """A progress bar with how many of some runs are done, their rate and the time left.

    Args:
        name: of them.
        total: how many there are.
        done: how many were done before.
        on: shows nothing otherwise.
    """

    def __init__(self, name: str, total: int, done: int = 0, on: bool = True) -> None:
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            _Rate(),
            TimeRemainingColumn(),
            TextColumn("{task.fields[failed]}"),
            console=Console(stderr=True),
            disable=not on,
        )
        self._task = self._bar.add_task(name, total=total, completed=done, failed="")

    def __enter__(self) -> CountLine:
        self._bar.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._bar.stop()

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
