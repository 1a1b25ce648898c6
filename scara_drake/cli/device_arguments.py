"""The arguments of `scara-drake devices`."""

from __future__ import annotations

from pathlib import Path
from typing import Any


def add_devices(commands: Any) -> None:
    """Add the command that lists, shows and calibrates devices."""
    parser = commands.add_parser("devices", help="list the devices to operate with; try one")
    what = parser.add_mutually_exclusive_group()
    what.add_argument(
        "--watch", type=int, nargs="?", const=0, metavar="INDEX", help="show axes and buttons, live"
    )
    what.add_argument(
        "--calibrate", type=int, metavar="INDEX", help="ask for movements, write a profile"
    )
    parser.add_argument("--profile", default="", help="to watch with, a name or a YAML file")
    parser.add_argument(
        "--seconds", type=float, metavar="T", help="to watch for [s] (default: until Ctrl-C)"
    )
    parser.add_argument("--output", type=Path, metavar="FILE.yaml", help="of the profile")
    parser.add_argument(
        "--patience",
        type=float,
        default=10.0,
        metavar="T",
        help="for a movement, before it is left out [s] (default 10)",
    )
    parser.set_defaults(module="scara_drake.cli.devices", extra="")
