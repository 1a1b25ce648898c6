"""The command `scara-drake table`: write a recording as a table, one row a sample."""

from __future__ import annotations

import argparse

from rich.console import Console

from scara_drake.recordings.files import open_recording
from scara_drake.recordings.table import write_table


def run(options: argparse.Namespace, console: Console) -> None:
    """Write a recording, or a journal, as CSV.

    Raises:
        ValueError: not a recording, or a wrong name of the table.
        OSError: the table cannot be written.
    """
    path = options.csv or options.recording.with_suffix(".csv")
    if path.suffix != ".csv" or path.is_dir():
        raise ValueError(f"--csv: '{path}', allowed a file that ends in .csv")
    with open_recording(options.recording) as recording:
        if "time" not in recording.dims:
            raise ValueError(f"recording: '{options.recording}', allowed NetCDF written by a run")
        write_table(recording, path)
    console.print(f"Table: {path}", soft_wrap=True, markup=False, highlight=False)
