"""What is seen while experiments run: which of them, how many are done, how long it takes."""

from __future__ import annotations

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TaskID,
    TextColumn,
    TimeElapsedColumn,
)

from scara_drake.reproduction.contents import counts, told_counts
from scara_drake.reproduction.run import Outcome


class Watch:
    """A line for all experiments and one for each that runs; elsewhere than on a terminal, none.

    A line for each that has ended stays.
    """

    def __init__(self, console: Console, count: int) -> None:
        self._progress = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            console=console,
            transient=True,
            disable=not console.is_terminal,
        )
        self._all = self._progress.add_task("experiments", total=count)
        self._running: dict[str, TaskID] = {}

    def began(self, name: str) -> None:
        """Show that one has begun."""
        self._running[name] = self._progress.add_task(f"  {name}", total=1)

    def ended(self, outcome: Outcome) -> None:
        """Say what became of one."""
        self._progress.remove_task(self._running.pop(outcome.name))
        self._progress.advance(self._all)
        said = f"broke off: {outcome.error}" if outcome.error else told_counts(counts(outcome))
        self._progress.console.print(
            f"{outcome.name}: {said} ({outcome.seconds:.0f} s)", markup=False, highlight=False
        )

    def __enter__(self) -> Watch:
        self._progress.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._progress.stop()
