"""The newest record of one process, in memory that another one reads; neither ever waits.

A lock could be held by a process that is stopped. Here the writer counts before and after it
writes, and adds a checksum; a reader that meets a record half written looks again, and then keeps
what it had. The memory is a file without a name: it is gone with the last process that has it,
however those end.
"""

from __future__ import annotations

import mmap
import tempfile
import zlib
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

HEADER: Final = np.dtype([("count", "u8"), ("checksum", "u8")])
ATTEMPTS: Final = 3  # of a reader
IN_MEMORY: Final = Path("/dev/shm")  # where there is one, no disk is written
Record = NDArray[Any]  # () of a structured dtype


class Mailbox:
    """A place for the newest record.

    Args:
        memory: shared by the processes.
        offset: where the place begins in it [bytes].
        dtype: of the record.
    """

    def __init__(self, memory: mmap.mmap, offset: int, dtype: np.dtype[Any]) -> None:
        self._dtype = dtype
        self._header = np.frombuffer(memory, HEADER, 1, offset)
        self._bytes = np.frombuffer(memory, np.uint8, dtype.itemsize, offset + HEADER.itemsize)

    def write(self, record: Record) -> None:
        """Put a record () in the place of the one that is there. Only one process may do so."""
        data = record.tobytes()
        count = int(self._header["count"][0])
        self._header["count"] = count + 1  # odd: somebody is writing
        self._bytes[:] = np.frombuffer(data, np.uint8)
        self._header["checksum"] = zlib.crc32(data)
        self._header["count"] = count + 2

    def read(self) -> Record | None:
        """Return the newest record (), or None: there is none yet, or it is being written."""
        for _ in range(ATTEMPTS):
            count = int(self._header["count"][0])
            data, checksum = self._bytes.tobytes(), int(self._header["checksum"][0])
            if count == 0:
                return None
            if count == int(self._header["count"][0]) and zlib.crc32(data) == checksum:
                return np.frombuffer(data, self._dtype)[0]
        return None


def size_of(dtype: np.dtype[Any]) -> int:
    """Return the bytes of a place for records of a type, in whole cache lines."""
    line = 64
    return -(-(HEADER.itemsize + dtype.itemsize) // line) * line


def make_memory(size: int) -> BinaryIO:
    """Return a new file of zeros [bytes], without a name, for `map_memory` here and in a child."""
    folder = IN_MEMORY if IN_MEMORY.is_dir() else None
    file = tempfile.TemporaryFile(dir=folder)  # noqa: SIM115  # its owner closes it
    file.truncate(size)
    return file


def map_memory(descriptor: int, size: int) -> mmap.mmap:
    """Return the memory of a file, shared with all who have it."""
    return mmap.mmap(descriptor, size)
