"""Files that are written whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def whole_file(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path beside `path`; what is written there becomes `path` at the end.

    If the block fails the temporary file is removed, and `path` is what it was before. The folder
    has to be there.

    Raises:
        OSError: the folder cannot be written.
    """
    target = Path(path)
    # With the process in its name: two that write the same file do not meet.
    partial = target.with_name(f".{target.name}.{os.getpid()}.partial")
    try:
        yield partial
        os.replace(partial, target)
    finally:
        partial.unlink(missing_ok=True)


def write_whole(path: str | Path, text: str) -> None:
    """Write a text as UTF-8, with its line ends as they are.

    Raises:
        OSError: the folder is not there or cannot be written.
    """
    with whole_file(path) as partial:
        partial.write_text(text, encoding="utf-8", newline="")
