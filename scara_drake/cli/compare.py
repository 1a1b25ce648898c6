"""The command `scara-drake compare`: recordings beside each other."""

from __future__ import annotations

import argparse

from rich.console import Console

from scara_drake.cli.outputs import check_output
from scara_drake.comparison import compare
from scara_drake.comparison.report import report


def run(options: argparse.Namespace, console: Console) -> None:
    """Print the tables of a comparison, and write its page.

    Raises:
        ValueError: not recordings, or a wrong name of the page.
        OSError: the page cannot be written.
    """
    check_output("--html", options.html, ".html")
    comparison = compare(*options.recordings)
    console.print(report(comparison))
    if options.html:
        comparison.save_html(options.html)
        console.print(f"Page: {options.html}", soft_wrap=True, markup=False, highlight=False)
