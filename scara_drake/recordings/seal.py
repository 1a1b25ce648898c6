"""A checksum of a whole file, at its end, where readers of HDF5 do not look.

A file that another program has written anew has none; it is read as it is.
"""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Final

LABEL: Final = b"\nscara_drake sha256 "
LENGTH: Final = len(LABEL) + hashlib.sha256().digest_size
PIECE: Final = 1 << 20  # [B]


def seal(path: Path) -> None:
    """Append the checksum of a file to it.

    Raises:
        OSError: the file cannot be written.
    """
    digest = _digest(path, path.stat().st_size)
    with open(path, "ab") as file:
        file.write(LABEL + digest)


def is_broken(path: Path) -> bool:
    """Whether a file has a checksum that is not its own.

    Raises:
        OSError: the file cannot be read.
    """
    size = path.stat().st_size - LENGTH
    if size < 0:
        return False
    with open(path, "rb") as file:
        file.seek(size)
        label, digest = file.read(len(LABEL)), file.read()
    return label == LABEL and digest != _digest(path, size)


def _digest(path: Path, size: int) -> bytes:
    found = hashlib.sha256()
    with open(path, "rb") as file:
        while size > 0 and (piece := file.read(min(PIECE, size))):
            found.update(piece)
            size -= len(piece)
    return found.digest()
