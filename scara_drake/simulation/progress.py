"""The line that a run shows of itself."""

from __future__ import annotations

from types import TracebackType

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn


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
