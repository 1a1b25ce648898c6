"""The command `scara-drake replay`: play a recording again."""

from __future__ import annotations

import argparse

from rich.console import Console

from scara_drake.replay.player import play


def run(options: argparse.Namespace, console: Console) -> None:
    """Play a recording; see `scara_drake.replay`.

    Raises:
        SystemExit: it failed; with its exit status.
    """
    if status := play(options):
        raise SystemExit(status)
