"""Recordings as flat tables, one row a sample."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import pandas as pd
import xarray as xr

from scara_drake.common.files import whole_file

AT_ONCE = 4096  # rows


def to_table(recording: xr.Dataset) -> pd.DataFrame:
    """Return a recording as a table, one row a sample, by time [s].

    A variable with dims beside the time makes a column for each entry, such as ``q_measured.d1``;
    the units are those of the variables.
    """
    columns = {}
    for name, variable in recording.data_vars.items():
        dims = [dim for dim in variable.dims if dim != "time"]
        if "time" not in variable.dims:
            continue
        for labels in product(*(recording[dim].values for dim in dims)):
            column = variable.sel(dict(zip(dims, labels, strict=True)))
            columns[".".join([str(name), *map(str, labels)])] = column.values
    return pd.DataFrame(columns, index=pd.Index(recording.time.values, name="time"))


def write_table(recording: xr.Dataset, path: str | Path) -> None:
    """Write a recording as CSV, whole or not at all; a lazily opened one is read in pieces.

    Raises:
        OSError: the file cannot be written.
    """
    with whole_file(path) as partial, open(partial, "w", encoding="utf-8", newline="") as file:
        for start in range(0, max(1, recording.sizes["time"]), AT_ONCE):
            piece = recording.isel(time=slice(start, start + AT_ONCE))
            to_table(piece).to_csv(file, header=start == 0)
