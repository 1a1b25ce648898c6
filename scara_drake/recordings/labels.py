"""Labelled variables of the studies."""

from __future__ import annotations

from typing import Any

import xarray as xr


def labelled(
    dims: tuple[str, ...], values: Any, units: str, long_name: str, measured: bool = False
) -> xr.Variable:
    """Return a variable with its unit and its meaning; `measured` marks a wall time."""
    attributes = {"units": units, "long_name": long_name}
    if measured:
        attributes["measured"] = "wall time of this machine"
    return xr.Variable(dims, values, attributes)
