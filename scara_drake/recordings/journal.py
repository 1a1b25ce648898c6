"""The journal of a run: an append-only file of blocks, readable up to the last whole block.

NetCDF (HDF5) files that are cut at any byte are lost; a run therefore writes this journal while it
goes, and the NetCDF file is made from it at the end.

The file is a line that names the format, and blocks. A block is its kind (4 bytes), the length of
its content (8 bytes), a CRC-32 (4 bytes), all little-endian, and the content. The checksum covers
kind, length, content and the checksum before it: so no byte can change and no block can go, come or
move without being noticed.

| kind | content |
|---|---|
| HEAD | JSON: the number of values of a sample, and what the run says of itself |
| DATA | times (n,) and values (n, width) as 8-byte floats |
| DONE | JSON: what ended the run, and when, and further attributes of the recording |
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from scara_drake.common.blocks import BlockWriter, whole_blocks
from scara_drake.common.claimed_file import claim
from scara_drake.recordings.dataset import Notes, with_notes

Array = NDArray[np.float64]

MAGIC: Final = b"scara_drake journal 2\n"
HEAD, DATA, DONE = b"HEAD", b"DATA", b"DONE"
AT_ONCE: Final = 4096  # samples
CUT_OFF: Final = "cut off"  # what ended a run whose journal does not say it


class Journal:
    """Writes blocks of samples, each sample one time and `width` values.

    Nobody else can write the file until it is closed. One without samples is removed then.

    Attributes:
        path: of the file.
        left_behind: new name of a journal that was there already, or None.
        has_samples: whether any have been written.
    """

    def __init__(self, path: str | Path):
        """Create the file.

        Raises:
            ValueError: another run is writing it.
            OSError: the folder cannot be written.
        """
        self.path = Path(path)
        self._file, self.left_behind = claim(self.path)
        self._blocks = BlockWriter(self._file)
        self._width = 0
        self.has_samples = False

    def begin(self, description: dict[str, Any], width: int) -> None:
        """Write what the run says of itself; samples have `width` values.

        What has been written before is forgotten.
        """
        self._file.seek(0)
        self._file.truncate()
        self._blocks = BlockWriter(self._file)
        self._width, self.has_samples = width, False
        head = {"width": width, "description": description}
        self._blocks.write(HEAD, json.dumps(head).encode(), MAGIC)

    def append(self, times: Array, values: Array) -> None:
        """Append samples at times (n,) with values (n, width).

        Raises:
            OSError: it cannot be written; the file ends with the block before.
        """
        if times.size:
            if values.shape != (times.size, self._width):
                raise ValueError(f"values: shape {values.shape}, allowed (n, {self._width})")
            self._blocks.write(
                DATA, b"".join(np.asarray(a, "<f8").tobytes() for a in (times, values))
            )
            self.has_samples = True

    def end(self, by: str, at: float, notes: Notes | None = None) -> None:
        """Write what ended the run, and when [s], and further attributes of the recording."""
        done = {"by": by, "at": at, "notes": notes or {}}
        self._blocks.write(DONE, json.dumps(done).encode())

    def remove(self) -> None:
        """Remove the file: its samples are elsewhere now."""
        self.has_samples = False
        self.close()

    def close(self) -> None:
        """Let others have the file; remove it if it has no samples."""
        if not self.has_samples and not self._file.closed:
            self.path.unlink(missing_ok=True)
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


@dataclass(frozen=True)
class Contents:
    """What a journal holds, all of it checked.

    Attributes:
        path: of the file.
        description: what the run says of itself.
        width: number of values of a sample.
        blocks: where the samples of each block are in the file, and how many there are.
        ended_by: what ended the run; `CUT_OFF` if the journal does not say it.
        ended_at: when [s]; the time of the last sample if the journal does not say it.
        lost: bytes after the last whole block.
    """

    path: Path
    description: dict[str, Any]
    width: int
    blocks: tuple[tuple[int, int], ...]
    ended_by: str
    ended_at: float
    lost: int

    @property
    def samples(self) -> int:
        """How many samples there are."""
        return sum(count for _, count in self.blocks)

    def read(self, at_once: int) -> Iterator[tuple[Array, Array]]:
        """Yield the samples in pieces of `at_once`: times (n,), values (n, width)."""
        times, values, count = [np.empty(0)], [np.empty((0, self.width))], 0
        with open(self.path, "rb") as file:
            for start, size in self.blocks:
                file.seek(start)
                numbers = np.fromfile(file, "<f8", size * (1 + self.width))
                times.append(numbers[:size])
                values.append(numbers[size:].reshape(size, self.width))
                count += size
                while count >= at_once:
                    whole, stacked = np.concatenate(times), np.concatenate(values)
                    yield whole[:at_once], stacked[:at_once]
                    times, values, count = [whole[at_once:]], [stacked[at_once:]], count - at_once
        if count:
            yield np.concatenate(times), np.concatenate(values)


def read_journal(path: str | Path) -> tuple[Contents, Array, Array]:
    """Return what a journal holds, and its samples: times (n,) and values (n, width).

    Raises:
        ValueError: as `survey`.
    """
    contents = survey(path)
    times, values = np.empty(contents.samples), np.empty((contents.samples, contents.width))
    start = 0
    for some_times, some_values in contents.read(AT_ONCE):
        end = start + some_times.size
        times[start:end], values[start:end] = some_times, some_values
        start = end
    return contents, times, values


def is_journal(path: str | Path) -> bool:
    """Whether a file begins as a journal does."""
    with open(path, "rb") as file:
        return file.read(len(MAGIC)) == MAGIC


def survey(path: str | Path) -> Contents:
    """Check every block of a journal; what follows a damaged one is lost.

    Raises:
        ValueError: the file is not a journal, or its head is damaged.
    """
    refusal = ValueError(f"journal: '{path}', allowed a journal written by a run, its head whole")
    blocks: list[tuple[int, int]] = []
    head: dict[str, Any] = {}
    done: dict[str, Any] = {"by": CUT_OFF, "at": 0.0}
    try:
        with open(path, "rb") as file:
            whole = len(MAGIC)
            if file.read(whole) != MAGIC:
                raise refusal
            for kind, content, _ in whole_blocks(file):
                if kind == HEAD:
                    head = json.loads(content)
                elif kind == DATA:
                    count = len(content) // (8 * (1 + head["width"]))
                    blocks.append((file.tell() - len(content), count))
                    done["at"] = float(np.frombuffer(content, "<f8", count)[-1])
                else:
                    done = json.loads(content)
                whole = file.tell()
            lost = os.fstat(file.fileno()).st_size - whole
    except OSError:
        raise refusal from None
    if not head:
        raise refusal
    return Contents(
        path=Path(path),
        description=with_notes(head["description"], done.get("notes")),
        width=head["width"],
        blocks=tuple(blocks),
        ended_by=done["by"],
        ended_at=done["at"],
        lost=lost,
    )
