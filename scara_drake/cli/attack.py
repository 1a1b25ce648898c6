"""The command `scara-drake attack`: the largest harm within bounds, and the smallest scenario."""

from __future__ import annotations

import argparse
import json
import math
import shlex
import time
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Final

from rich import box
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from scara_drake.attack.bounds import bounds_of
from scara_drake.attack.objectives import OBJECTIVES, thresholds_of
from scara_drake.attack.report import Report, save_smallest
from scara_drake.attack.search import Plan, search
from scara_drake.attack.shrink import shrink
from scara_drake.attack.space import shortened
from scara_drake.attack.trial import Problem, Trial
from scara_drake.cli.outputs import check_output
from scara_drake.common.files import write_whole
from scara_drake.common.parallel import job_count
from scara_drake.scenario import load_scenario, parse_overrides
from scara_drake.stability.certificates import certify

FOUND: Final = 1  # exit status


def run(options: argparse.Namespace, console: Console) -> int:
    """Search, shrink, write and tell.

    Returns:
        1 where a breach was found, else 0.

    Raises:
        ValueError: bad input; one line, and nothing has been run.
        OSError: a file cannot be written.
    """
    start = load_scenario(options.scenario, parse_overrides(options.set))
    scenario = shortened(start, options.duration)
    thresholds = thresholds_of(scenario, options.objective, options.threshold)
    problem = Problem(scenario, bounds_of(scenario, options.bound), thresholds)
    problem.check()
    plan = Plan(options.runs, options.seed, job_count(options.jobs), options.first)
    plan.check()
    output = options.output or Path("runs") / f"{start.name}_attack.yaml"
    check_output("--output", output, ".yaml", ".yml")
    if options.show_bounds:
        console.print(bounds_table(problem))
        return 0
    begin = time.perf_counter()
    trials = _searched(problem, plan)
    found = any(trial.breach for trial in trials)
    shrunk = shrink(problem, trials, plan.jobs) if found else None
    report = Report(problem, plan, trials, shrunk, time.perf_counter() - begin)
    told = output.with_suffix(".json")
    told.parent.mkdir(parents=True, exist_ok=True)
    write_whole(told, json.dumps(report.data(), indent=1) + "\n")
    if found:
        save_smallest(report, output, command_of(options))
    _tell(report, console)
    written = [str(output), str(told)] if found else [str(told)]
    console.print(f"Written: {' and '.join(written)}", highlight=False, soft_wrap=True)
    return FOUND if found else 0


def command_of(options: argparse.Namespace) -> str:
    """Return the command line that finds the same again."""
    words = ["scara-drake", "attack", str(options.scenario)]
    for name in ("set", "bound", "threshold"):
        for text in getattr(options, name):
            words += [f"--{name}", text]
    words += ["--objective", *options.objective, "--runs", str(options.runs)]
    words += ["--seed", str(options.seed), "--duration", f"{options.duration:g}"]
    return shlex.join([*words, "--first"] if options.first else words)


def _searched(problem: Problem, plan: Plan) -> list[Trial]:
    with ExitStack() as shown:
        progress = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("runs, largest harm {task.fields[harm]} of the threshold"),
            TimeRemainingColumn(),
            console=Console(stderr=True),
        )
        bar = progress.add_task(problem.scenario.name, total=plan.runs, harm="")

        def show(trials: Sequence[Trial]) -> None:
            if not progress.live.is_started:
                shown.enter_context(progress)
            harm = max(trial.harm for trial in trials)
            progress.update(bar, completed=len(trials), harm=f"{harm:.3g}")

        return search(problem, plan, show)


def bounds_table(problem: Problem) -> Table:
    """Return what an attack may change."""
    table = Table(box=box.SIMPLE_HEAD)
    for heading in ("field", "bounds", "scenario", "meaning"):
        table.add_column(heading)
    for bound in problem.bounds:
        own = bound.own(problem.scenario)
        shown = "" if own is None else bound.shown(own)
        table.add_row(bound.label, bound.range_shown(), shown, bound.meaning)
    return table


def _tell(report: Report, console: Console) -> None:
    """Print what was tried, what came near, and what was found."""
    console.print(_coverage_table(report))
    console.print(_objectives_table(report))
    proven = [f"In theory: {line}" for line in certify(report.problem.scenario).lines()]
    for sentence in [*sentences(report), *proven]:
        console.print(sentence, markup=False, highlight=False, soft_wrap=True)


def _coverage_table(report: Report) -> Table:
    table = Table(title="What was tried", title_justify="left", box=box.SIMPLE_HEAD)
    for heading in ("field", "bounds", "reached", "gap", "harm alone"):
        table.add_column(heading, justify="right" if heading == "gap" else "left")
    fields = report.coverage().fields
    for bound in report.problem.bounds:
        reached = fields[bound.label]
        span = (
            f"{reached.low:.4g} to {reached.high:.4g}"
            if isinstance(reached.low, float | int) and isinstance(reached.high, float | int)
            else f"{reached.low} to {reached.high}"
        )
        alone = "" if math.isnan(reached.alone) else f"{reached.alone:.3g}"
        table.add_row(bound.label, bound.range_shown(), span, f"{reached.gap:.0%}", alone)
    return table


def _objectives_table(report: Report) -> Table:
    table = Table(title="What came of it", title_justify="left", box=box.SIMPLE_HEAD)
    for heading in ("objective", "as it is", "largest", "at run", "threshold"):
        table.add_column(heading)
    for name, threshold in report.problem.thresholds.items():
        value, number = report.best(name)
        first = report.trials[0].values.get(name, math.nan)
        shown = OBJECTIVES[name].shown
        table.add_row(name, shown(first), shown(value), f"{number}", shown(threshold))
    return table


def sentences(report: Report) -> list[str]:
    """Return the verdict, and what it is worth."""
    runs, counted = len(report.trials), sum(trial.counts for trial in report.trials)
    said = [
        f"{runs} runs of {report.problem.scenario.duration:g} s, {counted} count, in "
        f"{report.seconds:.0f} s; of all pairs of fields {report.coverage().pairs:.0%} of the "
        "cells of ten by ten have a run."
    ]
    said += [f"{number} left out: {reason}" for reason, number in report.left_out().items()]
    if report.cut():
        said.append(f"{report.cut()} met what only Drake computes, and count until then.")
    shrunk = report.shrunk
    if shrunk is None:
        said.append("No breach in these runs, within these bounds. That is no proof.")
        return said
    said.append(f"Breach at run {report.found_at}; made small in {shrunk.runs} runs:")
    said.append(report.sentence())
    said += [
        f"without {name}: {harm:.2g} of the threshold" for name, harm in shrunk.without.items()
    ]
    return said
