"""A file of blocks that only grows, readable up to the last whole block.

A block is its kind (4 bytes), the length of its content (8 bytes), a CRC-32 (4 bytes), all
little-endian, and the content. The checksum covers kind, length, content and the checksum before
it: so no byte can change and no block can go, come or move without being noticed.
"""

from __future__ import annotations

import os
import zlib
from collections.abc import Iterator
from io import FileIO
from struct import Struct, error
from typing import BinaryIO, Final, NamedTuple

FRAME: Final = Struct("<4sQI")  # kind, length, checksum


class Block(NamedTuple):
    """A block of a file.

    Attributes:
        kind: four bytes.
        content: any.
        checksum: of it and of all before it.
    """

    kind: bytes
    content: bytes
    checksum: int


class BlockWriter:
    """Appends blocks to a file, each whole or not at all.

    Args:
        file: to write, at the place for the next block.
        checksum: of the last block before it; 0 where there is none.
    """

    def __init__(self, file: FileIO, checksum: int = 0) -> None:
        self._file, self._checksum = file, checksum

    def write(self, kind: bytes, content: bytes, before: bytes = b"") -> None:
        """Append a block; `before` goes with it, such as the mark of the format.

        Raises:
            OSError: it cannot be written; the file ends with the block before.
        """
        checksum = _checksum(kind, content, self._checksum)
        rest = memoryview(before + FRAME.pack(kind, len(content), checksum) + content)
        start = self._file.tell()
        try:
            while rest:
                rest = rest[self._file.write(rest) :]
        except OSError:
            self._file.truncate(start)
            self._file.seek(start)
            raise
        self._checksum = checksum


def whole_blocks(file: BinaryIO | FileIO) -> Iterator[Block]:
    """Yield block after block, from where the file is read, up to the first that is damaged.

    After each the file is at the end of it.
    """
    before = 0
    size = os.fstat(file.fileno()).st_size
    while True:
        try:
            kind, length, checksum = FRAME.unpack(file.read(FRAME.size))
        except error:
            return
        if length > size - file.tell():
            return
        content = file.read(length)
        if _checksum(kind, content, before) != checksum:
            return
        before = checksum
        yield Block(kind, content, checksum)


def _checksum(kind: bytes, content: bytes, before: int) -> int:
    return zlib.crc32(content, zlib.crc32(FRAME.pack(kind, len(content), before)))
