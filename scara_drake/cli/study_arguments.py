"""The arguments of `scara-drake tune` and `sweep`. Nothing heavy is imported."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any, Final

TUNE_EPILOG: Final = """\
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
SWEEP_EPILOG: Final = """\
A study names a scenario, the fields to vary and the figures to keep; docs/studies.md has them all.
Every run is kept in the store as it ends: the same command, given again after an interrupt or a
kill, goes on where it was.

  scara-drake sweep payload_delay --picture runs/payload_delay.png
  scara-drake sweep my_study.yaml --store runs/mine.nc --backend dask --address HOST:PORT
"""


def add_scenario(parser: argparse.ArgumentParser, what: str) -> None:
    """Add what names a scenario, and what is set in it."""
    parser.add_argument("scenario", help=what)
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="override a field, such as controller.phi=0.5",
    )


def add_tune(commands: Any) -> None:
    """Add the command `tune`."""
    parser = commands.add_parser(
        "tune",
        help="search a controller's gains for the lowest cost of a scenario",
        description="Search a controller's gains for the lowest cost of a scenario.",
        epilog=TUNE_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_scenario(parser, "name of a shipped scenario, or a YAML file: the start")
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
        "--jobs", type=int, default=1, metavar="N", help="runs side by side (default 1)"
    )
    parser.set_defaults(module="scara_drake.cli.tune", extra="tune")


def add_sweep(commands: Any) -> None:
    """Add the command `sweep`."""
    parser = commands.add_parser(
        "sweep",
        help="run a study: a scenario over parameters, draws or seeds",
        description="Run a study: a scenario over parameters, draws or seeds.",
        epilog=SWEEP_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("study", help="name of a shipped study, or a YAML file")
    parser.add_argument("--store", type=Path, metavar="OUT.nc", help="default runs/STUDY.nc")
    parser.add_argument(
        "--jobs", type=int, metavar="N", help="runs side by side on this machine (default: cores)"
    )
    parser.add_argument(
        "--backend", default="local", metavar="WHERE", help="local (default), dask or ray"
    )
    parser.add_argument(
        "--address", metavar="HOST:PORT", help="of the cluster (default: workers on this machine)"
    )
    parser.add_argument("--picture", type=Path, metavar="OUT.png", help="draw the result")
    parser.set_defaults(module="scara_drake.cli.sweep", extra="")
