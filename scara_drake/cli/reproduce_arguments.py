"""The arguments of `scara-drake reproduce`."""

from __future__ import annotations

from pathlib import Path
from typing import Any


def add_reproduce(commands: Any) -> None:
    """Add the command `reproduce`."""
    parser = commands.add_parser(
        "reproduce",
        help="run every table, figure and equation of the paper, and report",
        description="Run the paper's tables, figures and equations, judge each claim, write a "
        "report.",
        epilog="Exit status: 0, or 1 where an experiment broke off or a verdict is not the known "
        "one, or 2 for bad input.",
    )
    parser.add_argument(
        "--only",
        action="extend",
        nargs="+",
        metavar="NAME",
        help="table_10, figure_16, figures_16_17, equation_47, or an experiment's name",
    )
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("runs"),
        metavar="FOLDER",
        help="for reproduction.html and reproduction.md with its pictures (default runs)",
    )
    parser.add_argument("--jobs", type=int, metavar="N", help="side by side (default all cores)")
    parser.add_argument(
        "--seed",
        type=int,
        default=0,
        help="of all that is drawn (default 0, of which the known verdicts are)",
    )
    parser.add_argument("--accept", action="store_true", help="make these verdicts the known ones")
    parser.set_defaults(module="scara_drake.cli.reproduce", extra="")
