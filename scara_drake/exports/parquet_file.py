"""Recordings as Parquet, one row a sample, with the units in the schema."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Final

import pyarrow as pa
import pyarrow.parquet as pq
import xarray as xr

from scara_drake.common.files import whole_file
from scara_drake.recordings.table import AT_ONCE, columns, description, pieces, to_table

ROWS: Final = 4 * AT_ONCE  # of a group


def write(recording: xr.Dataset, path: Path) -> None:
    """Write a recording as Parquet.

    Each field of the schema has ``units`` and ``long_name`` in its metadata, the schema the
    attributes of the recording; pandas shows all of it as ``attrs`` of the table.

    Raises:
        OSError: the file cannot be written.
    """
    schema = _schema(recording)
    with whole_file(path) as partial, pq.ParquetWriter(partial, schema, compression="zstd") as file:
        for piece in pieces(recording, ROWS):
            table = to_table(piece).reset_index()
            file.write_table(pa.Table.from_pandas(table, schema, preserve_index=False).cast(schema))


def _schema(recording: xr.Dataset) -> pa.Schema:
    said = description(recording)
    fields = [
        pa.field(
            column.name,
            pa.float64(),
            metadata={"units": column.unit, "long_name": column.long_name},
        )
        for column in columns(recording)
    ]
    texts = {
        str(name): str(value) for name, value in said.items() if name not in ("units", "long_names")
    }
    return pa.schema(fields, metadata={**texts, "PANDAS_ATTRS": json.dumps(said)})
