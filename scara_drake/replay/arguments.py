"""The arguments of a replay, for both of its command lines; nothing heavy is imported."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Final

LOOPBACK: Final = "127.0.0.1"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of a replay to a parser."""
    parser.add_argument(
        "recording", type=Path, metavar="FILE", help="a recording, or the journal of a run"
    )
    parser.add_argument("--speed", type=float, default=1.0, help="2 plays twice as fast")
    parser.add_argument("--html", type=Path, metavar="FILE.html", help="write a page instead")
    parser.add_argument("--open", action="store_true", help="open a browser and wait for it")
    parser.add_argument("--port", type=int, help="of the scene (default: the first free from 7000)")
    parser.add_argument(
        "--host",
        default=LOOPBACK,
        help=f"where the scene is to be seen from (default {LOOPBACK}: this machine alone)",
    )
