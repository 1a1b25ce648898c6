"""The command `scara-drake tune`: search a controller's gains for the lowest cost of a scenario."""

from __future__ import annotations

import argparse
import dataclasses
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any

from rich import box
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from scara_drake import joints
from scara_drake.cli.outputs import check_output
from scara_drake.common.files import write_whole
from scara_drake.scenario import Scenario, dump_scenario, load_scenario, parse_overrides
from scara_drake.tuning.cost import Aim
from scara_drake.tuning.search import Tuned, tune


def run(options: argparse.Namespace, console: Console) -> None:
    """Search, write the scenario with the best gains, and print what they changed.

    Raises:
        ValueError: bad input; one line.
        RuntimeError: the run with the start gains fails.
    """
    start = load_scenario(options.scenario, parse_overrides(options.set))
    output = options.output or Path("runs") / f"{start.name}_tuned.yaml"
    check_output("--output", output, ".yaml", ".yml")
    start = with_files_from(start, output.parent)
    with ExitStack() as shown:
        progress = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("trials, lowest cost {task.fields[cost]}"),
            TimeRemainingColumn(),
            console=Console(stderr=True),
        )
        bar = progress.add_task(start.name, total=options.trials, cost="")

        def show(done: int, cost: float) -> None:
            if not progress.live.is_started:  # not before: bad input is one line
                shown.enter_context(progress)
            progress.update(bar, completed=done, cost=f"{cost:.4f}")

        result = tune(
            start,
            trials=options.trials,
            seed=options.seed,
            duration=options.duration,
            study=options.study,
            aim=Aim(options.tracking, options.effort_weight),
            jobs=options.jobs,
            show=show,
        )
    result.scenario.name = output.stem
    output.parent.mkdir(parents=True, exist_ok=True)
    write_whole(output, dump_scenario(result.scenario))
    console.print(_figures_table(result, options.tracking))
    if result.scenario.controller == start.controller:
        console.print("No trial was better than the gains it started from.")
    else:
        console.print(_gains_table(start.controller, result.scenario.controller))
    if result.failed:
        console.print(f"{result.failed} of {result.trials} trials failed and have no cost.")
    if result.interrupted:
        console.print("Stopped early; these are the best gains so far.")
    console.print(f"Scenario: {output}")


def with_files_from(scenario: Scenario, folder: Path) -> Scenario:
    """Return the scenario such that, written in `folder`, it finds the files that it uses now."""
    found_from = getattr(scenario.operator, "found_from", None)
    return scenario if found_from is None else replace(scenario, operator=found_from(folder))


def _figures_table(result: Tuned, tracking: str) -> Table:
    count = "1 trial" if result.trials == 1 else f"{result.trials} trials"
    table = Table(
        title=f"{result.scenario.name}: {count}", title_justify="left", box=box.SIMPLE_HEAD
    )
    second = " s" if tracking == "itae" else ""
    for heading in ("", "before", "after", "ratio"):
        table.add_column(heading, justify="right" if heading else "left")
    for what, scale, units, before, after in (
        (
            tracking.upper(),
            1e3,
            (f"mm{second}", f"mrad{second}"),
            result.start.tracking,
            result.best.tracking,
        ),
        ("effort variation", 1.0, ("N", "N m"), result.start.effort, result.best.effort),
    ):
        for index, joint in enumerate(joints.JOINT_NAMES):
            unit = units[min(index, 1)]
            first, last = scale * before[index], scale * after[index]
            ratio = f"{last / first:.2f}" if first > 0.0 else ""
            table.add_row(f"{joint} {what}", f"{first:.4g} {unit}", f"{last:.4g} {unit}", ratio)
    table.add_row(
        "cost",
        f"{result.start_cost:.4f}",
        f"{result.best_cost:.4f}",
        f"{result.best_cost / result.start_cost:.2f}",
    )
    return table


def _gains_table(start: Any, best: Any) -> Table:
    table = Table(title="Gains", title_justify="left", box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0))
    table.add_column("")
    for joint in joints.JOINT_NAMES:
        table.add_column(joint, justify="right")
    for field in dataclasses.fields(start):
        before, after = getattr(start, field.name), getattr(best, field.name)
        if isinstance(before, list) and before != after and len(before) == len(joints.JOINT_NAMES):
            pairs = zip(before, after, strict=True)
            table.add_row(field.name, *(f"{a:.4g}\n{b:.4g}" for a, b in pairs))
    return table
