"""Recordings as flat tables, one row a sample, a column for each entry of each variable."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import Any, Final, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

AT_ONCE: Final = 4096  # samples of a piece, and of a chunk of a file


class Column(NamedTuple):
    """A column of a table.

    Attributes:
        name: such as ``q_measured_d1``.
        variable: it is an entry of; "time" for the time.
        entry: labels of that entry, by dim.
        unit: of SI.
        long_name: what it is.
    """

    name: str
    variable: str
    entry: dict[str, Any]
    unit: str
    long_name: str


def columns(recording: xr.Dataset) -> list[Column]:
    """Return the columns of a recording's table; the first is the time."""
    found = [Column("time", "time", {}, "s", str(recording.time.attrs.get("long_name", "time")))]
    for name, variable in recording.data_vars.items():
        if "time" not in variable.dims:
            continue
        dims = [str(dim) for dim in variable.dims if dim != "time"]
        for labels in product(*(recording[dim].values.tolist() for dim in dims)):
            entry = dict(zip(dims, labels, strict=True))
            unit, said = _unit(recording, variable, entry), variable.attrs.get("long_name", "")
            column = "_".join([str(name), *map(str, labels)])
            found.append(Column(column, str(name), entry, unit, str(said)))
    return found


def to_table(recording: xr.Dataset) -> pd.DataFrame:
    """Return a recording as a table, one row a sample, by time [s].

    A variable with dims beside the time makes a column for each entry, such as ``q_measured_d1``.
    The attributes ``units`` and ``long_names`` of the table say what is in each column; the others
    are those of the recording.
    """
    head = columns(recording)
    values = {c.name: _values(recording, c) for c in head[1:]}
    table = pd.DataFrame(values, index=pd.Index(recording.time.values, name="time"))
    table.attrs = description(recording)
    return table


def description(recording: xr.Dataset) -> dict[str, Any]:
    """Return what a table has to say beside its numbers: units, long names, attributes."""
    head = columns(recording)
    return {
        "units": {column.name: column.unit for column in head},
        "long_names": {column.name: column.long_name for column in head},
        **{str(name): _plain(value) for name, value in recording.attrs.items()},
    }


def pieces(recording: xr.Dataset, at_once: int = AT_ONCE) -> Iterator[xr.Dataset]:
    """Yield a recording, which may be open and not read, in loaded pieces; one at least."""
    for start in range(0, max(1, recording.sizes["time"]), at_once):
        yield recording.isel(time=slice(start, start + at_once)).load()


def _values(recording: xr.Dataset, column: Column) -> Any:
    variable = recording[column.variable]
    return variable.sel(column.entry).values


def _unit(recording: xr.Dataset, variable: xr.DataArray, entry: dict[str, Any]) -> str:
    """The unit of an entry; of what the joints have different ones of, that of its joint."""
    coordinate = variable.attrs.get("units_in", "")
    if coordinate in recording.coords and "joint" in entry:
        return str(recording[coordinate].sel(joint=entry["joint"]).values)
    return str(variable.attrs.get("units", ""))


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value
