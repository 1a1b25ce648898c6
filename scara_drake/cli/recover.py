"""The command `scara-drake recover`: make a recording of a journal."""

from __future__ import annotations

import argparse

from rich.console import Console

from scara_drake.recordings.files import loss, save_journal
from scara_drake.recordings.journal import survey


def run(options: argparse.Namespace, console: Console) -> None:
    """Make a recording of the journal of a run that was cut off; the journal is kept.

    Raises:
        ValueError: not a journal, or the recording is there already.
        OSError: the recording cannot be written.
        SystemExit: the journal is damaged; what was before the damage is recorded.
    """
    survey(options.journal)  # before a word about the output
    output = options.output or options.journal.with_suffix(".nc")
    if output.suffix != ".nc" or output.exists():
        raise ValueError(f"--output: '{output}', allowed a new file that ends in .nc")
    contents = save_journal(options.journal, output)
    say = Console(soft_wrap=True, highlight=False).print
    say(
        f"Recording: {output} ({contents.samples} samples, up to {contents.ended_at:g} s; "
        f"ended by: {contents.ended_by})",
        markup=False,
    )
    if contents.lost:
        say(loss(contents), markup=False)
        raise SystemExit(1)
