"""Recorded joystick traces: reading and checking a CSV file."""

import csv
import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from scara_drake.vectors import STICK_NAMES

Array = NDArray[np.float64]

COLUMNS = ("time", *STICK_NAMES)
AXIS_LIMIT = 1.05  # a little beyond 1 for a stick calibrated badly; JoystickSource clips it


def load_trace(path: str | Path) -> tuple[Array, Array]:
    """Load a joystick trace from a CSV file with the columns time, x, y, z, mast_axis, mast_hat.

    Returns:
        times (n,) [s] and axes (n, 5) in the order of STICK_NAMES, without unit. The columns may
        stand in any order and others may stand beside them.

    Raises:
        ValueError: no such file, no such column, no rows, a value that is not a finite number, an
            axis outside ±1.05, or times that do not increase; names the line and the column.
    """
    file = Path(path)
    if not file.is_file():
        raise ValueError(f"trace: '{file}', allowed a CSV file that exists")
    try:
        with file.open(newline="", encoding="utf-8-sig") as stream:
            rows = list(csv.reader(stream))
    except (UnicodeDecodeError, csv.Error) as error:
        raise ValueError(f"trace: '{file}', allowed CSV text in UTF-8 ({error})") from None
    header = [name.strip() for name in rows[0]] if rows else []
    missing = [name for name in COLUMNS if name not in header]
    if missing:
        raise ValueError(
            f"{file.name}: no column {', '.join(missing)}, allowed {','.join(COLUMNS)}"
        )
    columns = [(name, header.index(name)) for name in COLUMNS]
    table = [
        [_number(row, column, f"{file.name}: line {line}") for column in columns]
        for line, row in enumerate(rows[1:], start=2)
        if row
    ]
    if not table:
        raise ValueError(f"{file.name}: no rows, allowed one or more")
    values = np.array(table)
    late = np.flatnonzero(np.diff(values[:, 0]) <= 0.0)
    if late.size:
        before, after = values[late[0] : late[0] + 2, 0]
        raise ValueError(
            f"{file.name}: time {after:g} s after {before:g} s, allowed times that increase"
        )
    return values[:, 0].copy(), values[:, 1:].copy()


def _number(row: list[str], column: tuple[str, int], where: str) -> float:
    name, index = column
    text = row[index] if index < len(row) else ""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ValueError(f"{where}, {name}: '{text}', allowed a finite number")
    if name != "time" and abs(value) > AXIS_LIMIT:
        raise ValueError(f"{where}, {name}: {text}, allowed {-AXIS_LIMIT} to {AXIS_LIMIT}")
    return value
