"""Files that a command will write: found out before it begins whether it can."""

from __future__ import annotations

import os
from pathlib import Path

from scara_drake.common.checks import shown


def check_output(option: str, path: Path | None, *suffixes: str) -> None:
    """Accept a file that can be written, in a folder that is there or can be made.

    Nothing is made. None is accepted.

    Raises:
        ValueError: otherwise; names the option.
    """
    if path is None:
        return
    said = f"{option}: {shown(str(path), 200)}"
    if path.suffix not in suffixes or path.is_dir():
        raise ValueError(f"{said}, allowed a file that ends in {suffixes[0]}")
    folder = path.absolute().parent
    while not folder.exists() and folder != folder.parent:
        folder = folder.parent
    if not folder.is_dir():
        raise ValueError(f"{said}, allowed a file in a folder: {shown(str(folder), 200)} is none")
    if not os.access(folder, os.W_OK | os.X_OK) or (path.exists() and not os.access(path, os.W_OK)):
        raise ValueError(f"{said}, allowed a file that may be written")
