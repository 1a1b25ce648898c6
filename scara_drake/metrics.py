"""Figures of merit of recordings: pure functions, dims in, dims out."""

from __future__ import annotations

import xarray as xr


def tracking_error(recording: xr.Dataset) -> xr.DataArray:
    """Joint error e = q_desired - q_measured (time, joint) [m, rad]."""
    return recording.q_desired - recording.q_measured


def tool_error(recording: xr.Dataset) -> xr.DataArray:
    """Distance |p_desired - p_measured| of the tool (time) [m]."""
    offset = recording.p_WE_desired - recording.p_WE_measured
    return (offset**2).sum("axis", skipna=False) ** 0.5


def rmse(error: xr.DataArray) -> xr.DataArray:
    """Root of the mean square over time, sqrt(mean(e²))."""
    return (error**2).mean("time") ** 0.5


def peak(error: xr.DataArray) -> xr.DataArray:
    """Largest magnitude over time, max |e|."""
    return abs(error).max("time")


def chatter(effort: xr.DataArray) -> xr.DataArray:
    """Mean change from sample to sample, mean |u_k - u_(k-1)|, in the unit of the effort."""
    return abs(effort.diff("time")).mean("time")


def contact_force(recording: xr.Dataset) -> xr.DataArray:
    """Magnitude |f| of the contact force (time) [N]; NaN where the Diagram has no surface."""
    return (recording.f_env_on_tool_W**2).sum("axis", skipna=False) ** 0.5
