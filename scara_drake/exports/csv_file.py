"""Recordings as CSV, one row a sample, with the units in a file beside it.

The file beside it, ``NAME.csv-metadata.json``, is that of the W3C's "CSV on the Web": any program
reads the CSV as the plain table that it is, and who wants the units finds them.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import xarray as xr

from scara_drake.common.files import whole_file
from scara_drake.recordings.table import columns, description, pieces, to_table


def write(recording: xr.Dataset, path: Path) -> None:
    """Write a recording as CSV, and its units beside it.

    A number reads back to the bit; a cell without one is empty.

    Raises:
        OSError: a file cannot be written.
    """
    beside = path.with_name(f"{path.name}-metadata.json")
    with whole_file(beside) as metadata, whole_file(path) as partial:
        text = json.dumps(_metadata(recording, path.name), indent=1, ensure_ascii=False)
        metadata.write_text(text + "\n", encoding="utf-8")
        with open(partial, "w", encoding="utf-8", newline="") as file:
            for number, piece in enumerate(pieces(recording)):
                to_table(piece).to_csv(file, header=number == 0, lineterminator="\n")


def _metadata(recording: xr.Dataset, name: str) -> dict[str, Any]:
    said = description(recording)
    units, long_names = said.pop("units"), said.pop("long_names")
    head = [column.name for column in columns(recording)]
    return {
        "@context": "http://www.w3.org/ns/csvw",
        "url": name,
        "dc:title": str(said.get("scenario_name", "")),
        "dc:description": said,
        "tableSchema": {
            "columns": [
                {
                    "name": column,
                    "datatype": "double",
                    "dc:description": long_names[column],
                    "schema:unitText": units[column],
                }
                for column in head
            ],
            "primaryKey": "time",
        },
    }
