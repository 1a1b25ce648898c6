"""The command `scara-drake tune`: search a controller's gains for the lowest cost of a scenario."""

from __future__ import annotations

import argparse
import dataclasses
import os
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich import box
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from scara_drake import joints
from scara_drake.common.resources import resource
from scara_drake.operator.joystick import Joystick
from scara_drake.scenario import Scenario, dump_scenario, load_scenario, parse_overrides

if TYPE_CHECKING:
    from scara_drake.tuning.search import Tuned  # its extra may not be installed

EPILOG = """\
The cost of a run compares it, joint by joint, with the run of the start gains (0):

  J = mean((E + e) / (E0 + e)) + W mean((V + v) / (V0 + v))

E is the tracking error of a joint: rmse, sqrt(mean(error^2)), or itae, the integral of time times
|error|. V = sum |tau_k - tau_(k-1)| is the total variation of its effort. Both count from t = 1 s
on, or from the middle of a run of less than 2 s. e is the E of a constant error of 1 um or 1 urad,
v is 0.1 % of the effort limit. The start costs 1 + W; it is the first trial, so the result is
never worse.

Every entry of every list of gains is searched between a quarter of its start value and four times
it. A boundary layer phi follows from the rule that the sampled loop must not chatter: it is the
smallest that the rule bears, over a margin between 0 and 1 that is searched as well.

With --study every trial is kept: the same command, given again after an interrupt or a kill, goes
on where it was, and a larger --trials adds to it. Ctrl-C writes the best gains so far.

  scara-drake tune joint_sine --trials 60 --duration 3 --study runs/joint_sine.db
  scara-drake run runs/joint_sine_tuned.yaml
"""


def add_parser(commands: Any) -> None:
    """Add the command to the subparsers of the command line."""
    parser = commands.add_parser(
        "tune",
        help="search a controller's gains for the lowest cost of a scenario",
        description=__doc__,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("scenario", help="name of a shipped scenario, or a YAML file: the start")
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="override a field, such as controller.phi=0.5",
    )
    parser.add_argument(
        "--trials",
        type=int,
        default=100,
        metavar="N",
        help="in all, the study's included (default 100)",
    )
    parser.add_argument("--seed", type=int, default=0, help="of the search (default 0)")
    parser.add_argument(
        "--duration", type=float, metavar="T", help="of a run [s] (default: the scenario's)"
    )
    parser.add_argument("--study", type=Path, metavar="FILE.db", help="keep the trials, to go on")
    parser.add_argument(
        "--output", type=Path, metavar="FILE.yaml", help="default runs/SCENARIO_tuned.yaml"
    )
    parser.add_argument("--tracking", default="rmse", metavar="WHAT", help="rmse (default) or itae")
    parser.add_argument(
        "--effort-weight", type=float, default=0.1, metavar="W", help="in the cost (default 0.1)"
    )
    parser.add_argument(
        "--jobs", type=int, default=1, metavar="N", help="processes that simulate (default 1)"
    )
    parser.set_defaults(command=run)


def run(options: argparse.Namespace, console: Console) -> None:
    """Search, write the scenario with the best gains, and print what they changed.

    Raises:
        ValueError: bad input, or the extra `tune` is not installed; one line.
        RuntimeError: the run with the start gains fails.
    """
    try:
        from scara_drake.tuning.search import tune  # its extra may not be installed
    except ModuleNotFoundError as error:
        raise ValueError(f"tune: {error}, allowed with the extra 'tune' installed") from None
    start = load_scenario(options.scenario, parse_overrides(options.set))
    output = options.output or Path("runs") / f"{start.name}_tuned.yaml"
    if output.suffix not in (".yaml", ".yml") or output.is_dir():
        raise ValueError(f"--output: '{output}', allowed a file that ends in .yaml")
    start = with_trace_from(start, output.parent)
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
            tracking=options.tracking,
            effort_weight=options.effort_weight,
            jobs=options.jobs,
            show=show,
        )
    result.scenario.name = output.stem
    write_scenario(result.scenario, output)
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


def with_trace_from(scenario: Scenario, folder: Path) -> Scenario:
    """Return the scenario such that, written in `folder`, it finds the trace that it plays now."""
    operator = scenario.operator
    if not (isinstance(operator, Joystick) and operator.device == "trace"):
        return scenario
    trace = operator.trace_path().resolve()
    shipped = (resource("diagrams") / operator.trace).resolve()
    if trace == shipped and not (folder / operator.trace).is_file():
        return scenario  # it is found by its name, wherever the package is
    scenario = replace(scenario)
    scenario.operator = replace(operator, trace=str(trace))
    return scenario


def write_scenario(scenario: Scenario, path: Path) -> None:
    """Write a scenario as YAML, whole or not at all.

    It is written under a temporary name beside `path`, then renamed.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f".{path.name}.partial")
    try:
        partial.write_text(dump_scenario(scenario), encoding="utf-8")
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)


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
