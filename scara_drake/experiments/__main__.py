"""``python -m scara_drake.experiments [NAME ...]``: run the experiments and print what they say."""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table

from scara_drake.experiments import EXPERIMENTS, Experiment, report
from scara_drake.experiments.plots import FIGURES


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the named experiments, all without a name, one after the other.

    Returns:
        The exit status; what a verdict is makes no difference to it.
    """
    parser = argparse.ArgumentParser(
        prog="python -m scara_drake.experiments",
        description="Run the paper's tables and figures, and print a verdict on each claim.",
    )
    parser.add_argument(
        "names", nargs="*", metavar="NAME", help=f"of {', '.join(EXPERIMENTS)}; all without one"
    )
    parser.add_argument("--seed", type=int, default=0, help="of all that is drawn (default 0)")
    parser.add_argument("--reasons", action="store_true", help="print criteria and reasons too")
    parser.add_argument(
        "--pictures", type=Path, metavar="FOLDER", help="draw the paper's figures into it"
    )
    options = parser.parse_args(arguments)
    if options.pictures is not None and not options.pictures.is_dir():
        parser.error(f"--pictures: {options.pictures}, allowed a folder that exists")
    for name in options.names:
        if name not in EXPERIMENTS:
            parser.error(f"NAME: {name}, allowed {', '.join(EXPERIMENTS)}")
    # A file gets lines that are wide enough to read.
    console = Console(width=None if sys.stdout.isatty() or "COLUMNS" in os.environ else 200)
    done: list[tuple[Experiment, float]] = []
    for name in options.names or EXPERIMENTS:
        print(f"{name} ...", file=sys.stderr, flush=True)  # noqa: T201 - says what it is at
        start = time.perf_counter()
        experiment = EXPERIMENTS[name](seed=options.seed)
        done.append((experiment, time.perf_counter() - start))
        for figure, picture in FIGURES.items():
            if options.pictures is not None and picture.experiment == name:
                drawn = picture.draw(experiment.data)
                drawn.savefig(options.pictures / f"figure_{figure}.png")
    console.print(timed_table(done))
    experiments = [experiment for experiment, _ in done]
    if options.reasons:
        for table in report.terminal(*experiments):
            console.print(table)
    counts = report.verdict_counts(experiments).loc["All"]
    told = ", ".join(f"{counts[verdict]} {verdict}" for verdict in report.VERDICTS)
    console.print(f"{counts['All']} claims: {told}")
    return 0


def timed_table(done: Sequence[tuple[Experiment, float]]) -> Table:
    """Return one table: claim, the paper's value, ours, the verdict, and the seconds it took."""
    table = Table("experiment", "claim", "paper", "ours", "verdict", "s")
    for experiment, seconds in done:
        for index, claim in enumerate(experiment.claims):
            statement, paper, measured, verdict, _ = report.row(claim)
            head = (experiment.name, f"{seconds:.0f}") if index == 0 else ("", "")
            cells = (head[0], statement, paper, measured, verdict, head[1])
            table.add_row(*cells, style=report.COLOURS[verdict])
        table.add_section()
    return table


if __name__ == "__main__":
    raise SystemExit(main())
