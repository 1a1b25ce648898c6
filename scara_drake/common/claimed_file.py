"""A file that only one process writes at a time."""

from __future__ import annotations

import os
import time
from io import FileIO
from pathlib import Path


def claim(path: str | Path) -> tuple[FileIO, Path | None]:
    """Create a file that nobody else can claim until it is closed; its folder is made if need be.

    A file of that name that a process has left behind is kept: it is renamed, with the time of its
    last change in its name.

    Returns:
        The new file, to write and read, and the new name of what was left behind, if there was.

    Raises:
        ValueError: another process is writing it.
        OSError: the folder cannot be written.
    """
    target = Path(path)
    left_behind = None
    while True:
        file = claim_as_it_is(target)
        if os.fstat(file.fileno()).st_size == 0:
            return file, left_behind
        left_behind = _set_aside(target)
        file.close()


def claim_as_it_is(path: str | Path) -> FileIO:
    """Open a file, or create it, such that nobody else can claim it until it is closed.

    Returns:
        The file, to write and read, at its beginning.

    Raises:
        ValueError: another process is writing it.
        OSError: the folder cannot be written.
    """
    target = Path(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    while True:
        file = FileIO(os.open(target, os.O_RDWR | os.O_CREAT, 0o666), "r+")
        if not _lock(file):
            file.close()
            raise ValueError(f"output: '{target}', allowed one that no other run is writing")
        if _is_at(file, target):  # not removed or renamed since it was opened
            return file
        file.close()


def _lock(file: FileIO) -> bool:
    try:
        import fcntl
    except ModuleNotFoundError:  # Windows, where nothing is simulated
        return True
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def _is_at(file: FileIO, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(file.fileno()), path.stat())
    except FileNotFoundError:
        return False


def _set_aside(path: Path) -> Path:
    stamp = time.strftime("%Y%m%d-%H%M%S", time.localtime(path.stat().st_mtime))
    name, count = f"{path.stem}.{stamp}", 1
    while (kept := path.with_name(f"{name}{path.suffix}")).exists():
        count += 1
        name = f"{path.stem}.{stamp}-{count}"
    path.rename(kept)
    return kept
