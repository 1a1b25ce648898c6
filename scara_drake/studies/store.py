"""The store of a study: a journal that grows by a run at a time, and NetCDF when all are there.

The journal is beside the NetCDF file, by its name with the suffix ``.journal``: a line that names
the format, and blocks with checksums (`common.blocks`). What is cut off at any byte has all runs up
to there; a run that is in it is not done again.

| kind | content |
|---|---|
| HEAD | JSON: what the study is |
| DONE | JSON: number of a run, its figures, what ended it, what is missing and why, its engine |
"""

from __future__ import annotations

import json
import os
import warnings
from io import FileIO
from pathlib import Path
from types import TracebackType
from typing import Any, Final, NamedTuple

import xarray as xr

from scara_drake.common.blocks import FRAME, BlockWriter, whole_blocks
from scara_drake.common.checks import shown
from scara_drake.common.claimed_file import claim_as_it_is
from scara_drake.recordings.files import load_recording, save_recording

MAGIC: Final = b"scara_drake study 1\n"
HEAD, DONE = b"HEAD", b"DONE"
MARK: Final = "study"  # attribute of the NetCDF file that says what the study is


class Row(NamedTuple):
    """What is kept of a run.

    Attributes:
        figures: in the order of the study's metrics; NaN where there is none.
        ended_by: "duration", or "error: " and why.
        missing: which figures there are not, and why.
        engine: that ran it.
    """

    figures: tuple[float, ...]
    ended_by: str
    missing: str
    engine: str


class Store:
    """The rows of a study on disk. Nothing is written before the first one is added.

    Attributes:
        rows: by the number of the run.
        result: the whole result, if it is there already.
    """

    def __init__(self, path: str | Path, description: str) -> None:
        """Open a store, or begin one.

        Args:
            path: of the NetCDF file that it becomes.
            description: what the study is; a store of another is refused.

        Raises:
            ValueError: the file is of another study, or another process is writing it.
            OSError: the folder cannot be written.
        """
        self._path = Path(path)
        self.journal = self._path.with_suffix(".journal")
        self._description = description
        self.rows: dict[int, Row] = {}
        self._writer: BlockWriter | None = None
        self._file = FileIO(os.devnull)
        self.result = self._finished()
        if self.result is not None:
            return
        self._file = claim_as_it_is(self.journal)
        try:
            self._read()
            self.result = self._finished()  # another process may have just ended
        except BaseException:
            self._file.close()
            raise

    def add(self, number: int, row: Row) -> None:
        """Keep a row: it is in the file when this returns.

        Raises:
            OSError: it cannot be written.
        """
        if self._writer is None:
            self._file.truncate(self._end)
            self._file.seek(self._end)
            self._writer = BlockWriter(self._file, self._checksum)
            if self._end == 0:
                self._writer.write(HEAD, self._description.encode(), MAGIC)
        self._writer.write(DONE, json.dumps([number, *row]).encode())
        self.rows[number] = row

    def finish(self, result: xr.Dataset) -> None:
        """Write the whole result, and let the journal go.

        Raises:
            OSError: it cannot be written; the journal is kept.
        """
        save_recording(result.assign_attrs({MARK: self._description}), self._path)
        self.journal.unlink()
        self.rows.clear()

    def close(self) -> None:
        """Let others have the store; remove the journal if there is nothing in it."""
        if self._file.name != os.devnull and os.fstat(self._file.fileno()).st_size == 0:
            self.journal.unlink(missing_ok=True)
        self._file.close()

    def _finished(self) -> xr.Dataset | None:
        """Return the result if the NetCDF file is there, and is of this study."""
        if not self._path.exists():
            return None
        try:
            found = load_recording(self._path)
        except ValueError as error:
            raise ValueError(f"store: {error}") from None
        if found.attrs.pop(MARK, None) != self._description:
            raise self._refusal(self._path)
        return found

    def _read(self) -> None:
        """Read the rows that are whole.

        Raises:
            ValueError: the file is of another study, or none of ours.
        """
        self._end, self._checksum = 0, 0
        content = self._description.encode()
        size = os.fstat(self._file.fileno()).st_size
        begun = self._file.read(len(MAGIC))
        blocks = whole_blocks(self._file)
        if begun != MAGIC:
            if not MAGIC.startswith(begun):
                raise self._refusal(self.journal)
            return
        head = next(blocks, None)
        if head is None:
            # Cut off before the head was whole, so there is nothing in it; or damaged.
            if size >= len(MAGIC) + FRAME.size + len(content):
                raise self._refusal(self.journal)
            return
        if head.content != content:
            raise self._refusal(self.journal)
        self._end, self._checksum = self._file.tell(), head.checksum
        for block in blocks:
            number, figures, *words = json.loads(block.content)
            self.rows[number] = Row(tuple(figures), *words)
            self._end, self._checksum = self._file.tell(), block.checksum
        if size > self._end:
            warnings.warn(
                f"{self.journal}: the last {size - self._end} bytes are no whole run; what they "
                "were is run again",
                stacklevel=4,
            )

    def _refusal(self, path: Path) -> ValueError:
        return ValueError(
            f"store: {shown(str(path), 200)} is of another study, or of another version, allowed "
            "the store of this one, or a new file"
        )

    def __enter__(self) -> Store:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


class Memory:
    """The rows of a study that is kept in memory alone; as a `Store`."""

    def __init__(self) -> None:
        self.rows: dict[int, Row] = {}
        self.result: xr.Dataset | None = None

    def add(self, number: int, row: Row) -> None:
        """Keep a row."""
        self.rows[number] = row

    def finish(self, result: xr.Dataset) -> None:
        """Nothing is written."""

    def __enter__(self) -> Memory:
        return self

    def __exit__(self, *error: object) -> None:
        """There is nothing to close."""


def open_store(path: str | Path | None, description: dict[str, Any]) -> Store | Memory:
    """Open the store of a study, or begin one; without a path it is in memory.

    Raises:
        ValueError: the file is of another study, or another process is writing it.
        OSError: the folder cannot be written.
    """
    return Memory() if path is None else Store(path, json.dumps(description, sort_keys=True))
