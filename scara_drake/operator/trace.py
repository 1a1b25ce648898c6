"""Recorded joystick traces: reading and checking a CSV file, making one from a recording."""

import csv
import re
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from scara_drake.common.files import whole_file
from scara_drake.operator.trace_columns import (
    COLUMNS,
    DEFAULTS,
    MORE_COLUMNS,
    bounds,
)
from scara_drake.vectors import (
    BUTTON_NAMES,
    ORIENTATION_NAMES,
    SETTING_NAMES,
    STICK_NAMES,
    DeviceStatus,
)

Array = NDArray[np.float64]

LATEST_START = 10.0  # [s]; a trace that starts later would leave the stick still so long
LONGEST_GAP = 60.0  # [s], from row to row
SAMPLED = 100  # rows: from so many on a trace is taken for one of a device,
SLOWEST = 1.0  # [s] and no device is read so seldom; milliseconds are
CLOCK_TOLERANCE = 1e-9  # [s]; k * period and the decimal of a file differ in the last bits
RECORDED: Final = {"connected": "device_connected", "age": "device_age"}  # where names differ
# Older pandas rounds the last digit of a number otherwise than Python, unless it is told.
EXACTLY: Final = {} if int(pd.__version__.split(".")[0]) > 2 else {"float_precision": "round_trip"}
LONGEST_TEXT = 60  # of a file's, in a message

# A number as other tools write it: no underscores, no digits of other scripts, no words.
_NUMBER: Final = re.compile(r"\s*[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\s*", re.ASCII)


class Trace(NamedTuple):
    """A recorded operator.

    Attributes:
        times: (n,) [s], they increase.
        axes: (n, 5) in the order of `STICK_NAMES`.
        said: (n, 18) in the order of `MORE_COLUMNS`; None where the file has none of them.
    """

    times: Array
    axes: Array
    said: Array | None = None


def load_trace(path: str | Path, from_first_row: bool = False) -> tuple[Array, Array]:
    """Load the stick of a trace; see `load_operator`.

    Returns:
        times (n,) [s] and axes (n, 5) in the order of `STICK_NAMES`.
    """
    trace = load_operator(path, from_first_row)
    return trace.times, trace.axes


def load_operator(path: str | Path, from_first_row: bool = False) -> Trace:
    """Load a trace from a CSV file with the columns time, x, y, z, mast_axis, mast_hat.

    There may be columns of what else a device says, `MORE_COLUMNS`; those that are missing then
    read `DEFAULTS`. The columns may stand in any order and others may stand beside them. Numbers
    are read to the last bit.

    Args:
        path: of the file.
        from_first_row: count the times from the first row on, as for a trace with Unix times.

    Raises:
        ValueError: no such file, no such column or one twice, no rows, a value that is not a finite
            number, an axis outside ±1.05, a button outside 0 to 1, times that do not increase, that
            start after 10 s or leave a gap of more than 60 s, or 1 s from row to row in a long
            trace; names the line and the column.
    """
    file = Path(path)
    if not file.is_file():
        raise ValueError(f"trace: '{file}', allowed a CSV file that exists")
    table = _columns(file)
    times, axes = table["time"], _stack(table, STICK_NAMES)
    late = np.flatnonzero(np.diff(times) <= 0.0)
    if late.size:
        before, after = times[late[0] : late[0] + 2]
        raise ValueError(
            f"{file.name}: time {after:g} s after {before:g} s, allowed times that increase"
        )
    if from_first_row:
        times = times - times[0]
    _check_clock(file.name, times)
    if not set(MORE_COLUMNS) & set(table):
        return Trace(times, axes)
    for name in MORE_COLUMNS:
        table.setdefault(name, np.full(times.size, DEFAULTS[name]))
    return Trace(times, axes, _stack(table, MORE_COLUMNS))


def _stack(table: Mapping[str, Array], names: Sequence[str]) -> Array:
    return np.column_stack([table[name] for name in names])


def save_trace(recording: xr.Dataset, path: str | Path) -> None:
    """Save the operator of a recording as a trace that, played again, gives the same recording.

    Of a supervised run it has all columns: buttons, status of the device, settings, so that a live
    run plays again to the same bits.

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
    columns = dict(zip(STICK_NAMES, axes.values[first].T, strict=True)) | {
        name: values[first] for name, values in _said(recording).items()
    }
    table = pd.DataFrame(columns)
    table.insert(0, "time", np.round(ticks[first] * period, 9))
    with whole_file(path) as partial:
        table.to_csv(partial, index=False, lineterminator="\n")


def _said(recording: xr.Dataset) -> dict[str, Array]:
    """Return the further columns of a supervised run by name; none of another."""
    if "operator_buttons" not in recording:
        return {}
    vectors = {"orientation_axes": ORIENTATION_NAMES, "operator_buttons": BUTTON_NAMES}
    columns = {
        name: recording[variable].values[:, entry]
        for variable, names in vectors.items()
        for entry, name in enumerate(names)
    }
    status = {name: recording[RECORDED.get(name, name)] for name in DeviceStatus._fields}
    settings = {name: recording[f"live_{name}"] for name in SETTING_NAMES}
    return columns | {name: one.values for name, one in (status | settings).items()}


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


def _columns(file: Path) -> dict[str, Array]:
    """Read the columns of a file as numbers, fast; where that fails, say which entry is wrong."""
    try:
        with file.open(newline="", encoding="utf-8-sig") as stream:
            header = [name.strip() for name in next(csv.reader(stream), [])]
        _check_header(file.name, header)
        table = _read(file, header)
        if not (all(dtype.kind in "iuf" for dtype in table.dtypes) and _within_bounds(table)):
            texts = _read(file, header, dtype=str, skip_blank_lines=False).fillna("")
            texts = texts[(texts != "").any(axis=1)]
            columns = {name: _numbers(file.name, str(name), texts[name]) for name in texts}
            table = pd.DataFrame(columns)
    except (UnicodeDecodeError, csv.Error, pd.errors.ParserError) as error:
        reason = " ".join(str(error).split())
        raise ValueError(f"trace: '{file}', allowed CSV text in UTF-8 ({reason})") from None
    if not len(table):
        raise ValueError(f"{file.name}: no rows, allowed one or more")
    return {str(name): table[name].to_numpy(np.float64, copy=True) for name in table}


def _within_bounds(table: pd.DataFrame) -> bool:
    return all(
        np.isfinite(table[name]).all() and table[name].between(*bounds(str(name))).all()
        for name in table
    )


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
            **EXACTLY,
            **how,
        )
    known = [name for name in (*COLUMNS, *MORE_COLUMNS) if name in header]
    picked = table[[header.index(name) for name in known]]
    picked.columns = pd.Index(known)
    return picked


def _check_header(name: str, header: list[str]) -> None:
    missing = [column for column in COLUMNS if column not in header]
    if missing:
        raise ValueError(f"{name}: no column {', '.join(missing)}, allowed {','.join(COLUMNS)}")
    twice = [name for name in (*COLUMNS, *MORE_COLUMNS) if header.count(name) > 1]
    if twice:
        raise ValueError(f"{name}: column {', '.join(twice)} twice, allowed once")


def _numbers(file: str, name: str, column: pd.Series) -> Array:
    """Return the numbers of a column, and refuse what is none or out of bounds by its line."""
    plain = column.str.fullmatch(_NUMBER)
    values = pd.to_numeric(column.where(plain), errors="coerce").to_numpy(np.float64)
    wrong = ~np.isfinite(values)
    low, high = bounds(name)
    for bad, allowed in (
        (wrong, "a finite number"),
        ((values < low) | (values > high), f"{low:g} to {high:g}"),
    ):
        if bad.any():
            row = int(np.argmax(bad))
            text = " ".join(str(column.iloc[row]).split())[:LONGEST_TEXT]
            quoted = f"'{text}'" if bad is wrong else text
            line = int(column.index[row]) + 2
            raise ValueError(f"{file}: line {line}, {name}: {quoted}, allowed {allowed}")
    return values
