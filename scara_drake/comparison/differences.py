"""Whether the variables of two recordings are equal to the bit, and by how much they differ."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from scara_drake.recordings.signals import SIGNALS

Array = NDArray[np.float64]
TOGETHER: Final = "no times in common"


@dataclass(frozen=True)
class Difference:
    """How a variable of one recording differs from that of another, at the times both have.

    Attributes:
        name: of the variable.
        equal: to the bit; NaN equals NaN.
        largest: largest difference, in its unit; infinite where one has no number.
        relative: the same over the largest value of the entries with the same unit; NaN where that
            is zero.
        where: entry and time [s] of the largest relative difference.
        first: time of the first difference [s]; NaN where there is none.
        remark: what could not be compared.
    """

    name: str
    equal: bool
    largest: float = 0.0
    relative: float = 0.0
    where: str = ""
    first: float = np.nan
    remark: str = ""


def differences(one: xr.Dataset, other: xr.Dataset) -> list[Difference]:
    """Compare all variables over time of two recordings, in the order of `SIGNALS`.

    What is NaN throughout is not there: its Diagram does not have it.
    A recording that is shorter, or sampled more seldom, is compared at the times that both have;
    so are the joints, the surfaces and the like that both have.
    """
    there = [
        {str(name) for name, v in each.data_vars.items() if "time" in v.dims and is_there(v)}
        for each in (one, other)
    ]
    names = dict.fromkeys([*SIGNALS, *map(str, one.data_vars), *map(str, other.data_vars)])
    return [_difference(name, one, other, there) for name in names if name in there[0] | there[1]]


def is_there(variable: xr.DataArray) -> bool:
    """Whether a variable has a number: what a Diagram does not have is NaN throughout."""
    return bool(variable.notnull().any())


def _difference(name: str, one: xr.Dataset, other: xr.Dataset, there: list[set[str]]) -> Difference:
    for names, which in zip(there[::-1], ("first", "second"), strict=True):
        if name not in names:
            return Difference(name, False, np.nan, np.nan, remark=f"only in the {which}")
    a, b = one[name], other[name]
    units = [each.attrs.get("units", each.attrs.get("units_in", "")) for each in (a, b)]
    if units[0] != units[1] or set(a.dims) != set(b.dims):
        said = f"{units[0]} and {units[1]}" if units[0] != units[1] else f"{a.dims} and {b.dims}"
        return Difference(name, False, np.nan, np.nan, remark=f"not the same kind: {said}")
    remark = _other_entries(a, b)
    a, b = xr.align(a, b.transpose(*a.dims), join="inner", copy=False)
    if not a.size:
        return Difference(name, False, np.nan, np.nan, remark=remark or TOGETHER)
    return _compared(name, a, b, remark)


def _other_entries(a: xr.DataArray, b: xr.DataArray) -> str:
    """What of a dim, other than the time, only one of two arrays has."""
    said = []
    for dim in a.dims:
        if dim != "time" and dim in a.coords and dim in b.coords:
            labels = [[str(label) for label in each[dim].values] for each in (a, b)]
            for here, there, which in ((0, 1, "first"), (1, 0, "second")):
                alone = [label for label in labels[here] if label not in labels[there]]
                if alone:
                    said.append(f"{', '.join(alone)} only in the {which}")
    return "; ".join(said)


def _compared(name: str, a: xr.DataArray, b: xr.DataArray, remark: str) -> Difference:
    x, y = (np.ascontiguousarray(each, dtype=np.float64) for each in (a, b))
    nothing = np.isnan(x) & np.isnan(y)
    equal = (x.view(np.int64) == y.view(np.int64)) | nothing
    if equal.all():
        return Difference(name, not remark, remark=remark)
    with np.errstate(invalid="ignore"):
        apart = np.where(equal, 0.0, np.abs(x - y))
    apart[np.isnan(apart)] = np.inf  # a number against none
    scale = _scales(a, np.fmax(np.abs(x), np.abs(y)))
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = np.where(apart > 0.0, apart / scale, 0.0)
    worst = np.unravel_index(int(np.argmax(np.nan_to_num(relative, posinf=np.inf))), x.shape)
    first = np.flatnonzero(~equal.reshape(len(x), -1).all(axis=1))[0]
    entry = "".join(
        f"{a[dim].values[index]} "
        for dim, index in zip(a.dims[1:], worst[1:], strict=True)
        if dim in a.coords
    )
    times = a.time.values
    return Difference(
        name,
        False,
        largest=float(apart.max()),
        relative=float(relative[worst]),
        where=f"{entry}at {times[worst[0]]:.6g} s",
        first=float(times[first]),
        remark=remark,
    )


def _scales(a: xr.DataArray, sizes: Array) -> Array:
    """Largest size of the entries that have the unit of each, of shape (1, ...)."""
    most = np.nanmax(np.where(np.isfinite(sizes), sizes, 0.0), axis=0, keepdims=True)
    coordinate = a.attrs.get("units_in", "")
    if coordinate not in a.coords or most.ndim != 2:
        return np.full_like(most, most.max())
    units = a[coordinate].values
    return np.array([[most[0, units == unit].max() for unit in units]])
