"""The command `scara-drake report`: the after-action report of a recording."""

from __future__ import annotations

import argparse

from rich.console import Console

from scara_drake.cli.outputs import check_output
from scara_drake.debrief import save_report
from scara_drake.recordings.files import load_recording


def run(options: argparse.Namespace, console: Console) -> None:
    """Write the report of a recording.

    Raises:
        ValueError: no recording, or a wrong name of the page.
        OSError: the page cannot be written.
    """
    target = options.html or options.recording.with_suffix(".html")
    check_output("--html", target, ".html")
    save_report(load_recording(options.recording), target)
    console.print(f"Page: {target}", soft_wrap=True, markup=False, highlight=False)
