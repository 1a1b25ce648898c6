"""Labelled variables of the studies."""

from __future__ import annotations

from typing import Any

import xarray as xr


def labelled(dims: tuple[str, ...], values: Any, units: str, long_name: str) -> xr.Variable:
    """Return a variable with its unit and its meaning."""
    return xr.Variable(dims, values, {"units": units, "long_name": long_name})
