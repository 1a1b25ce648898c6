"""The arguments of `scara-drake attack`. Nothing heavy is imported."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any, Final

from scara_drake.cli.study_arguments import add_scenario

ATTACK_EPILOG: Final = """\
objectives, and the thresholds above which they are a breach:
  energy     energy that coupling and channel make beyond the reserves (1 mJ)
  peak       largest force that the device is asked for (its limit)
  drift      tool from master when the hand is at rest in the end (1 mm)
  press      tool from master while the hand presses, delay removed, rms (15 mm)
  unrest     ripple of the force while the hand presses, over that of a stable press (1)
  invariant  what an end of TDPA gives out beyond its bound, at any tick (1 nJ)

Exit status: 1 where a breach is found, 0 where none is, 2 for bad input. None found is no proof:
the table says how much of the space was tried.

  scara-drake attack bilateral --objective invariant
  scara-drake attack bilateral --set "coupling=!Direct {}" --bound channel.delay=0:0.05
  scara-drake attack bilateral --bound only=channel.jitter,channel.delay --objective press
"""


def add_attack(commands: Any) -> None:
    """Add the command `attack`."""
    parser = commands.add_parser(
        "attack",
        help="search channel, hand and wall of a bilateral scenario for the largest harm",
        description="Search channel, hand and wall of a bilateral scenario, within bounds, for the "
        "largest harm; make what is found as small as it can be, and write it as a scenario.",
        epilog=ATTACK_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_scenario(parser, "name of a shipped scenario, or a YAML file, with a !Master")
    parser.add_argument(
        "--objective",
        nargs="+",
        default=["energy"],
        metavar="NAME",
        help="one or several, of those below (default energy)",
    )
    parser.add_argument(
        "--threshold",
        action="append",
        default=[],
        metavar="NAME=NUMBER",
        help="of an objective, in its unit",
    )
    parser.add_argument(
        "--bound",
        action="append",
        default=[],
        metavar="NAME=LOW:HIGH",
        help="other bounds of a field; NAME=off leaves it alone, only=NAME,NAME all others",
    )
    parser.add_argument(
        "--show-bounds", action="store_true", help="print what may be changed, and end"
    )
    parser.add_argument(
        "--runs", type=int, default=200, metavar="N", help="of the search (default 200)"
    )
    parser.add_argument("--first", action="store_true", help="end the search with the first breach")
    parser.add_argument("--seed", type=int, default=0, help="of the search (default 0)")
    parser.add_argument("--jobs", type=int, metavar="N", help="side by side (default all cores)")
    parser.add_argument(
        "--duration",
        type=float,
        default=3.0,
        metavar="T",
        help="of a run [s]; the hand's times shrink with it (default 3)",
    )
    parser.add_argument(
        "--output",
        type=Path,
        metavar="FILE.yaml",
        help="what is found (default runs/SCENARIO_attack.yaml); beside it FILE.json, what was "
        "tried",
    )
    parser.set_defaults(module="scara_drake.cli.attack", extra="tune")
