"""The command `scara-drake export`: write a recording in a format of other programs."""

from __future__ import annotations

import argparse
from pathlib import Path

from rich.console import Console

from scara_drake.cli.outputs import check_output
from scara_drake.exports.formats import FORMATS, export, format_of


def run(options: argparse.Namespace, console: Console) -> None:
    """Write a recording, or a journal, in another format.

    Raises:
        ValueError: not a recording, no such format, or a wrong name of the file.
        OSError: the file cannot be written.
    """
    output = options.output or _beside(options.recording, options.to or "csv")
    name = format_of(output, options.to or "")
    check_output("--output", output, FORMATS[name].suffix)
    export(options.recording, output, name)
    console.print(f"{name}: {output}", soft_wrap=True, markup=False, highlight=False)


def _beside(recording: Path, to: str) -> Path:
    """The file beside a recording that has its name."""
    suffix = FORMATS[to].suffix if to in FORMATS else ""
    return recording.with_suffix(f".trace{suffix}" if to == "trace" else suffix)
