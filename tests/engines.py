"""Runs of one scenario by both engines, and how far their recordings are from each other."""

from __future__ import annotations

import copy

import numpy as np
import xarray as xr

from scara_drake import simulate
from scara_drake.scenario import Scenario

# Of the largest value of a signal.
FREE, IN_CONTACT = 1e-9, 1e-6
BESIDE = 1e-13  # of a posture, a few roundings
# What a recording says of the engine itself, of the clock, and of when it was made.
OF_THE_RUN = {"engine", "engine_reason", "first_posture_seconds", "date_created"}


def both(scenario: Scenario) -> tuple[xr.Dataset, xr.Dataset]:
    """The recordings of a scenario: compiled, and of Drake."""
    return simulate(scenario, engine="compiled"), simulate(scenario, engine="drake")


def differences(compiled: xr.Dataset, drake: xr.Dataset) -> dict[str, float]:
    """How far each signal is from Drake's, see `gaps`; what is said of the runs has to be equal."""
    assert compiled.attrs["engine"] == "compiled"
    assert drake.attrs["engine"] == "drake"
    assert _told(compiled.attrs) == _told(drake.attrs)
    return gaps(compiled, drake)


def gaps(compiled: xr.Dataset, drake: xr.Dataset) -> dict[str, float]:
    """How far each signal is from the other's, over the largest value of that.

    Names, dims, types and attributes of the signals, times and where NaN is have to be equal.
    """
    assert list(compiled.variables) == list(drake.variables)
    found = {}
    for name in map(str, drake.variables):
        ours, theirs = compiled[name], drake[name]
        assert ours.dims == theirs.dims, name
        assert ours.dtype == theirs.dtype, name
        assert ours.attrs == theirs.attrs, name
        if name in drake.coords:
            np.testing.assert_array_equal(ours.values, theirs.values, err_msg=name)
        elif theirs.size:
            known = np.isfinite(theirs.values)
            np.testing.assert_array_equal(np.isfinite(ours.values), known, err_msg=name)
            gap = np.abs(np.where(known, ours.values - theirs.values, 0.0)).max()
            largest = np.abs(np.where(known, theirs.values, 0.0)).max()
            found[name] = float(gap / largest) if gap else 0.0
    return found


def touches(recording: xr.Dataset) -> bool:
    """Whether the tool met a surface."""
    return bool("penetration" in recording and (recording.penetration > 0.0).any())


def worst(scenario: Scenario) -> tuple[str, float, bool]:
    """The signal that differs most, by how much, and whether there was contact."""
    compiled, drake = both(scenario)
    found = differences(compiled, drake)
    name = max(found, key=found.__getitem__)
    return name, found[name], touches(drake)


def grown(scenario: Scenario, recording: xr.Dataset) -> dict[str, float]:
    """How far the run is from one of the same engine that starts a few roundings beside it."""
    beside = copy.copy(scenario)
    beside.q0 = list(recording.q_measured.values[0] * (1.0 + BESIDE))
    return gaps(recording, simulate(beside, engine="compiled"))


def _told(attributes: dict[str, object]) -> dict[str, object]:
    return {name: value for name, value in attributes.items() if name not in OF_THE_RUN}
