"""The tool's error by its cause, sample by sample.

It is the sum of four::

    commanded - measured =  (commanded - received)   the channel
                          + (received - limited)     the limiter of the commands, which is ours
                          + (limited - reference)    the inverse kinematics
                          + (reference - measured)   the controller

where the reference is the forward kinematics of the desired joints.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Final

import xarray as xr

from scara_drake import metrics

STATIONS: Final = ("commanded", "received", "desired", "reference", "measured")
PARTS: Final = ("channel", "command limiter", "inverse kinematics", "controller")


def tool_errors(data: xr.Dataset) -> xr.DataArray:
    """Split the tool's error (part, ..., axis) [m] into its four parts, which add up."""
    stations = [data[f"p_WE_{name}"] for name in STATIONS]
    parts = [one - other for one, other in pairwise(stations)]
    errors = xr.concat(parts, xr.IndexVariable("part", list(PARTS)))
    errors.attrs = {"units": "m", "long_name": "error of the tool by its cause"}
    return errors


def length(vectors: xr.DataArray) -> xr.DataArray:
    """Return the length of vectors (..., axis)."""
    return (vectors**2).sum("axis") ** 0.5


def rms(errors: xr.DataArray, *some: str) -> float:
    """Return the RMS length [mm] of some parts of the tool's error together, or of all."""
    together = errors.sel(part=list(some or PARTS)).sum("part")
    return 1e3 * float(metrics.rmse(length(together)))
