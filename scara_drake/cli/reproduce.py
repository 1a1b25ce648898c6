"""The command `scara-drake reproduce`: run the paper, judge it, and report."""

from __future__ import annotations

import argparse
import time
import warnings
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

from rich.console import Console
from rich.table import Table

from scara_drake.cli.compile import compile_all
from scara_drake.cli.outputs import check_output
from scara_drake.common import checks
from scara_drake.common.parallel import job_count
from scara_drake.experiments import EXPERIMENTS
from scara_drake.reproduction import baseline
from scara_drake.reproduction.contents import Contents, contents, counts_table
from scara_drake.reproduction.markdown import PICTURES, save_markdown
from scara_drake.reproduction.page import save_page
from scara_drake.reproduction.run import Outcome, run_experiments
from scara_drake.reproduction.selection import select
from scara_drake.reproduction.watch import Watch
from scara_drake.scenario import load_scenario, scenario_names

MOST_SEED: Final = 10**9  # experiments count on from it
DIFFERENT: Final = 1  # exit status: an experiment broke off, or a verdict is not the known one


def run(options: argparse.Namespace, console: Console) -> int:
    """Run what is asked for, write both reports, and say what differs from the known verdicts.

    Returns:
        0 where nothing broke off and every verdict is the known one, or is accepted.

    Raises:
        ValueError: an argument is out of its bounds; nothing has been run then.
        OSError: a report or the known verdicts cannot be written.
    """
    selection = select(options.only or [], EXPERIMENTS)
    jobs = _checked_jobs(options)
    known = baseline.read()
    begin = time.perf_counter()
    outcomes = _run_all(selection.experiments, options.seed, jobs)
    now = baseline.verdicts_of(
        {name: each.experiment for name, each in outcomes.items() if each.experiment}
    )
    asked = known if not options.only else {name: known[name] for name in now if name in known}
    broken = [name for name, each in outcomes.items() if not each.experiment]
    expected = {name: claims for name, claims in asked.items() if name not in broken}
    differences = baseline.differences(expected, now)
    found = contents(selection, outcomes, differences, options.seed)
    # A report says what differs from the verdicts that are known when it is read.
    shown = replace(found, differences=[]) if options.accept else found
    written = [save_page(shown, options.out), save_markdown(shown, options.out)]
    _tell(found, console)
    console.print(f"Written: {' and '.join(map(str, written))}", highlight=False, soft_wrap=True)
    count = f"{len(outcomes)} experiment{'s' * (len(outcomes) != 1)}"
    console.print(f"{count} in {time.perf_counter() - begin:.0f} s")
    if options.accept:
        baseline.write(known, now, EXPERIMENTS)
        console.print(f"Accepted: {baseline.PATH}", highlight=False, soft_wrap=True)
        differences = []
    return DIFFERENT if found.failed or differences else 0


def _checked_jobs(options: argparse.Namespace) -> int:
    """Check the arguments; return how many experiments run side by side.

    Raises:
        ValueError: one is out of its bounds.
    """
    checks.number("--seed", options.seed, 0, MOST_SEED)
    if options.accept and options.seed != baseline.SEED:
        allowed = f"allowed with --seed {baseline.SEED}"
        raise ValueError(f"--accept: with --seed {options.seed}, {allowed}")
    if options.accept:
        check_output("--accept", baseline.PATH, baseline.PATH.suffix)
    for name in ("reproduction.html", "reproduction.md", f"{PICTURES}/figure.png"):
        check_output("--out", options.out / name, Path(name).suffix)
    return job_count(options.jobs)


def _run_all(names: Sequence[str], seed: int, jobs: int) -> dict[str, Outcome]:
    """Run experiments and return what became of them, in the order of the names."""
    # Once, before several processes need them: numba's cache has no lock.
    if jobs > 1 and len(names) > 1:
        compile_all(load_scenario(name) for name in scenario_names())
    outcomes = {}
    with Watch(Console(stderr=True, soft_wrap=True), len(names)) as watch:
        for outcome in run_experiments(names, seed, jobs, watch.began):
            watch.ended(outcome)
            outcomes[outcome.name] = outcome
    for outcome in outcomes.values():
        for note in outcome.notes:
            warnings.warn(f"{outcome.name}: {note}", stacklevel=2)
    return {name: outcomes[name] for name in names}


def _tell(found: Contents, console: Console) -> None:
    """Say how many verdicts of each kind there are, what broke off, and what differs."""
    heads, rows = counts_table(found)
    table = Table(*heads)
    for row in rows:
        table.add_row(*row)
    console.print(table)
    for outcome in found.failed:
        console.print(outcome.trace, markup=False, highlight=False, soft_wrap=True)
        console.print(f"broke off: {outcome.name}: {outcome.error}", markup=False, soft_wrap=True)
    for difference in found.differences:
        console.print(str(difference), markup=False, highlight=False, soft_wrap=True)
    if found.differences and found.seed != baseline.SEED:
        said = f"The known verdicts are those of seed {baseline.SEED}; this was seed {found.seed}."
        console.print(said, highlight=False, soft_wrap=True)
