"""The journal of a run: an append-only file of blocks, readable up to the last whole block.

NetCDF (HDF5) files that are cut at any byte are lost; a run therefore writes this journal while it
goes, flushed after each block, and the NetCDF file is made from it at the end.
"""

from __future__ import annotations

import json
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

Array = NDArray[np.float64]

_METADATA_KEY = b"scara_drake"


class Journal:
    """Writes blocks of samples, each sample one time and `width` values (Arrow stream format)."""

    def __init__(self, path: str | Path, metadata: dict[str, Any], width: int):
        self._width = width
        self._schema = pa.schema(
            [("time", pa.float64()), ("values", pa.list_(pa.float64(), width))],
            metadata={_METADATA_KEY: json.dumps(metadata).encode()},
        )
        self._file = open(path, "wb")  # noqa: SIM115 - `close` closes it
        self._writer = pa.ipc.new_stream(self._file, self._schema)

    def append(self, times: Array, values: Array) -> None:
        """Append samples at times (n,) with values (n, width), and flush them to the file."""
        if times.size == 0:
            return
        flat = pa.array(np.ascontiguousarray(values, dtype=np.float64).ravel())
        columns = [pa.array(times), pa.FixedSizeListArray.from_arrays(flat, self._width)]
        self._writer.write_batch(pa.RecordBatch.from_arrays(columns, schema=self._schema))
        self._file.flush()

    def close(self) -> None:
        """End the stream and close the file."""
        self._writer.close()
        self._file.close()

    def __enter__(self) -> Journal:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def read_journal(path: str | Path) -> tuple[dict[str, Any], Array, Array]:
    """Return the metadata, times (n,) and values (n, width) of all whole blocks of a journal.

    Raises:
        ValueError: the file is not a journal.
    """
    try:
        stream = pa.ipc.open_stream(pa.memory_map(str(path)))
        metadata = json.loads(stream.schema.metadata[_METADATA_KEY])
        width = stream.schema.field("values").type.list_size
    except (pa.ArrowInvalid, KeyError, TypeError, OSError):
        raise ValueError(f"journal: '{path}', allowed a journal written by a run") from None
    times, values = [np.empty(0)], [np.empty((0, width))]
    while True:
        try:
            batch = stream.read_next_batch()
        except (StopIteration, pa.ArrowInvalid, OSError):
            break  # the end, or a block that was being written when the run was cut off
        times.append(batch.column("time").to_numpy())
        values.append(batch.column("values").flatten().to_numpy().reshape(-1, width))
    return metadata, np.concatenate(times), np.concatenate(values)
