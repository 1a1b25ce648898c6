"""What a run asked of the joints, against what they bear."""

from __future__ import annotations

import xarray as xr

from scara_drake import joints


def speed_ratio(rates: xr.DataArray) -> xr.DataArray:
    """Speed over the fastest one that a joint is made for, |v| / v_max (time, joint)."""
    return abs(rates) / xr.DataArray(joints.MAX_SPEED, dims="joint")


def beyond_range(positions: xr.DataArray) -> xr.DataArray:
    """How far a joint is beyond its range (time, joint) [m, rad]; 0 within it."""
    lower = xr.DataArray(joints.LOWER, dims="joint")
    upper = xr.DataArray(joints.UPPER, dims="joint")
    return (lower - positions).clip(min=0.0) + (positions - upper).clip(min=0.0)


def saturated_share(efforts: xr.DataArray) -> xr.DataArray:
    """Share of the time (joint) in which the effort is at its limit."""
    return (abs(efforts) >= 0.999 * xr.DataArray(joints.EFFORT, dims="joint")).mean("time")
