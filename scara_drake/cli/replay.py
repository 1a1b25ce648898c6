"""The command `scara-drake replay`: play a recording again."""

from __future__ import annotations

import argparse

from rich.console import Console

from scara_drake.replay.player import main


def run(options: argparse.Namespace, console: Console) -> None:
    """Play a recording; the arguments are those of `scara_drake.replay`.

    Raises:
        SystemExit: it failed; with its exit status.
    """
    if status := main(options.arguments):
        raise SystemExit(status)
