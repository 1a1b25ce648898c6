"""Recorded joystick traces: reading and checking a CSV file, making one from a recording."""

import csv
import re
import warnings
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from scara_drake.common.files import whole_file
from scara_drake.vectors import STICK_NAMES

Array = NDArray[np.float64]

COLUMNS = ("time", *STICK_NAMES)
AXIS_LIMIT = 1.05  # a little beyond 1 for a stick calibrated badly; JoystickSource clips it
LATEST_START = 10.0  # [s]; a trace that starts later would leave the stick still so long
LONGEST_GAP = 60.0  # [s], from row to row
SAMPLED = 100  # rows: from so many on a trace is taken for one of a device,
SLOWEST = 1.0  # [s] and no device is read so seldom; milliseconds are
CLOCK_TOLERANCE = 1e-9  # [s]; k * period and the decimal of a file differ in the last bits
LONGEST_TEXT = 60  # of a file's, in a message

# A number as other tools write it: no underscores, no digits of other scripts, no words.
_NUMBER: Final = re.compile(r"\s*[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\s*", re.ASCII)


def load_trace(path: str | Path, from_first_row: bool = False) -> tuple[Array, Array]:
    """Load a joystick trace from a CSV file with the columns time, x, y, z, mast_axis, mast_hat.

    Args:
        path: of the file.
        from_first_row: count the times from the first row on, as for a trace with Unix times.

    Returns:
        times (n,) [s] and axes (n, 5) in the order of STICK_NAMES, without unit. The columns may
        stand in any order and others may stand beside them.

    Raises:
        ValueError: no such file, no such column or one twice, no rows, a value that is not a finite
            number, an axis outside ±1.05, times that do not increase, that start after 10 s or
            leave a gap of more than 60 s, or 1 s from row to row in a long trace; names the line
            and the column.
    """
    file = Path(path)
    if not file.is_file():
        raise ValueError(f"trace: '{file}', allowed a CSV file that exists")
    times, axes = _columns(file)
    late = np.flatnonzero(np.diff(times) <= 0.0)
    if late.size:
        before, after = times[late[0] : late[0] + 2]
        raise ValueError(
            f"{file.name}: time {after:g} s after {before:g} s, allowed times that increase"
        )
    if from_first_row:
        times = times - times[0]
    _check_clock(file.name, times)
    return times, axes


def save_trace(recording: xr.Dataset, path: str | Path) -> None:
    """Save the stick of a recording as a trace that, played again, gives the same recording.

    A log sees a tick before its update: what it has at t was sampled at the stick's last tick
    before t. The rows have the times of those ticks; the first, before t = 0, is what the stick
    started from. The file appears whole or not at all.

    Args:
        recording: of a run with a joystick operator, device or trace.
        path: of the CSV file; see `load_trace`.

    Raises:
        ValueError: the recording has no stick, or was logged more seldom than the stick was
            sampled.
        OSError: the file cannot be written.
    """
    axes = recording.get("joystick_axes")
    if axes is None or not recording.sizes["time"] or not np.isfinite(axes).all():
        raise ValueError("recording: no joystick_axes, allowed one of a run with a Joystick")
    period, times = float(axes.attrs["period"]), recording.time.values
    logged = float(np.max(np.diff(times), initial=0.0))
    if logged > period + CLOCK_TOLERANCE:
        raise ValueError(
            f"recording: a sample every {logged:g} s, allowed at most {period:g} s, the stick's"
        )
    # The stick's last tick before each time; a log that is faster has some twice.
    ticks = np.ceil((times - CLOCK_TOLERANCE) / period) - 1.0
    first = np.flatnonzero(np.diff(ticks, prepend=-np.inf))
    table = pd.DataFrame(axes.values[first], columns=list(STICK_NAMES))
    table.insert(0, "time", np.round(ticks[first] * period, 9))
    with whole_file(path) as partial:
        table.to_csv(partial, index=False, lineterminator="\n")


def _check_clock(name: str, times: Array) -> None:
    """Check that the times are seconds from about 0 on.

    Raises:
        ValueError: they are not.
    """
    if abs(times[0]) > LATEST_START:
        raise ValueError(
            f"{name}: the first time is {times[0]:.10g} s, allowed at most {LATEST_START:g} s; "
            f"operator.trace_from_first_row: true counts from it"
        )
    gap = float(np.max(np.diff(times), initial=0.0))
    if times.size >= SAMPLED:
        usual = float(np.median(np.diff(times)))
        if usual >= SLOWEST:
            raise ValueError(
                f"{name}: {usual:g} s from row to row in {times.size} rows, allowed less than "
                f"{SLOWEST:g} s; times are in seconds"
            )
    if gap > LONGEST_GAP:
        raise ValueError(
            f"{name}: a gap of {gap:g} s between two rows, allowed at most {LONGEST_GAP:g} s; "
            "times are in seconds"
        )


def _columns(file: Path) -> tuple[Array, Array]:
    """Read the columns of a file as numbers, fast; where that fails, say which entry is wrong."""
    try:
        with file.open(newline="", encoding="utf-8-sig") as stream:
            header = [name.strip() for name in next(csv.reader(stream), [])]
        _check_header(file.name, header)
        table = _read(file, header)
        plain = all(dtype.kind in "iuf" for dtype in table.dtypes)  # all entries are numbers
        values = table.to_numpy(np.float64) if plain else np.full((1, len(COLUMNS)), np.nan)
        if not np.isfinite(values).all() or (np.abs(values[:, 1:]) > AXIS_LIMIT).any():
            table = _read(file, header, dtype=str, skip_blank_lines=False).fillna("")
            table = table[(table != "").any(axis=1)]
            values = np.array([_numbers(file.name, name, table[name]) for name in COLUMNS]).T
    except (UnicodeDecodeError, csv.Error, pd.errors.ParserError) as error:
        reason = " ".join(str(error).split())
        raise ValueError(f"trace: '{file}', allowed CSV text in UTF-8 ({reason})") from None
    if not len(values):
        raise ValueError(f"{file.name}: no rows, allowed one or more")
    return values[:, 0].copy(), values[:, 1:].copy()


def _read(file: Path, header: list[str], **how: Any) -> pd.DataFrame:
    """Read the rows below the header; the columns of a trace, in their order."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", pd.errors.ParserWarning)  # of entries beyond the header
        table = pd.read_csv(
            file,
            header=None,
            names=range(len(header)),
            index_col=False,
            skiprows=1,
            keep_default_na=False,
            encoding="utf-8-sig",
            **how,
        )
    picked = table[[header.index(name) for name in COLUMNS]]
    picked.columns = pd.Index(COLUMNS)
    return picked


def _check_header(name: str, header: list[str]) -> None:
    missing = [column for column in COLUMNS if column not in header]
    if missing:
        raise ValueError(f"{name}: no column {', '.join(missing)}, allowed {','.join(COLUMNS)}")
    twice = [column for column in COLUMNS if header.count(column) > 1]
    if twice:
        raise ValueError(f"{name}: column {', '.join(twice)} twice, allowed once")


def _numbers(file: str, name: str, column: pd.Series) -> Array:
    """Return the numbers of a column, and refuse what is none or out of bounds by its line."""
    plain = column.str.fullmatch(_NUMBER)
    values = pd.to_numeric(column.where(plain), errors="coerce").to_numpy(np.float64)
    wrong = ~np.isfinite(values)
    limit = np.inf if name == "time" else AXIS_LIMIT
    for bad, allowed in (
        (wrong, "a finite number"),
        (np.abs(values) > limit, f"{-AXIS_LIMIT} to {AXIS_LIMIT}"),
    ):
        if bad.any():
            row = int(np.argmax(bad))
            text = " ".join(str(column.iloc[row]).split())[:LONGEST_TEXT]
            quoted = f"'{text}'" if bad is wrong else text
            line = int(column.index[row]) + 2
            raise ValueError(f"{file}: line {line}, {name}: {quoted}, allowed {allowed}")
    return values
