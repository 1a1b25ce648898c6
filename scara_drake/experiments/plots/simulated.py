"""Pictures of the simulated experiments in the form of the paper's figures."""

from __future__ import annotations

from typing import Final

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from scara_drake.plotting import FIRST, LAW, SECOND, finish

WINDOW: Final = (2.7, 4.8)  # in which the paper sees errors and chattering [s]
SETTLED: Final = slice(1.0, None)  # before it the drives take up the weight of the arm [s]


def figures_16_17(data: xr.Dataset) -> Figure:
    """Draw the mast's motion, and the error that its weight leaves in each run."""
    figure = _figure(2)
    above, below = figure.axes
    above.plot(data.time, data.q_desired.isel(run=0), "k--", label="desired")
    for name in data.run.values:
        one = data.sel(run=name)
        above.plot(data.time, one.q_measured, label=name)
        below.plot(data.time, 1e3 * (one.q_desired - one.q_measured), label=name)
    below.axhline(2.0, color=LAW, linestyle=":", label="the paper's 2 mm")
    _named(above, "", "d1 [m]")
    _named(below, "time [s]", "error [mm]")
    return figure


def figures_18_19(data: xr.Dataset) -> Figure:
    """Draw joints 2 and 4 on their sines, and their errors in each run."""
    figure = _figure(3)
    above, *others = figure.axes
    joints = ("theta2", "theta4")
    for joint, color, ax in zip(joints, (FIRST, SECOND), others, strict=True):
        one = data.sel(joint=joint)
        above.plot(data.time, one.q_measured.isel(run=0), color=color, label=f"{joint} measured")
        above.plot(data.time, one.q_desired.isel(run=0), "k--", linewidth=0.8)
        error = 1e3 * (one.q_desired - one.q_measured)
        for name in data.run.values:
            ax.plot(data.time, error.sel(run=name), label=name)
        _range(ax, error.sel(time=SETTLED))
        _named(ax, "time [s]" if ax is others[-1] else "", f"{joint} error [mrad]")
    above.plot([], [], "k--", linewidth=0.8, label="desired")
    _named(above, "", "position [rad]")
    return figure


def figures_20_27(data: xr.Dataset) -> Figure:
    """Draw the tool's way and its error by cause, and the errors of joints 2, 4 and the mast."""
    figure = Figure(figsize=(13.0, 8.0), layout="constrained")
    (way, parts), (joints, mast) = figure.subplots(2, 2)
    one = data.sel(run="normalised")
    for name, style in (("commanded", "k:"), ("reference", "--"), ("measured", "-")):
        p = one[f"p_WE_{name}"]
        way.plot(p.sel(axis="x"), p.sel(axis="y"), style, label=name)
    way.set_aspect("equal", adjustable="datalim")
    for part in data.part.values:
        length = (one.tool_error.sel(part=part) ** 2).sum("axis") ** 0.5
        parts.semilogy(data.time, 1e3 * length.clip(1e-8), label=part)
    error = 1e3 * (data.q_desired - data.q_measured)
    for joint, color in (("theta2", FIRST), ("theta4", SECOND)):
        joints.plot(data.time, error.sel(run="normalised", joint=joint), color=color, label=joint)
    for name in ("normalised", "mast in mm and N"):
        mast.plot(data.time, error.sel(run=name, joint="d1"), label=name)
    mast.axhline(2.0, color=LAW, linestyle=":", label="the paper's 2 mm")
    shown = error.sel(time=SETTLED)
    _range(joints, shown.sel(run="normalised", joint=["theta2", "theta4"]))
    _range(mast, shown.sel(run=["normalised", "mast in mm and N"], joint="d1"), 2.1)
    _named(way, "x [m]", "y [m]")
    _named(parts, "time [s]", "tool error [mm]")
    _named(joints, "time [s]", "error [mrad]")
    _named(mast, "time [s]", "d1 error [mm]")
    return figure


def figures_29_30(data: xr.Dataset) -> Figure:
    """Draw joint 2 and its error by ISMC and by SMC, a row for each reading of the delay."""
    readings = [str(name) for name in data.reading.values]
    figure = Figure(figsize=(11.0, 2.0 * len(readings)), layout="constrained")
    rows = figure.subplots(len(readings), 2, sharex=True)
    for (left, right), reading in zip(rows, readings, strict=True):
        left.plot(data.time, data.q_desired, "k--", linewidth=0.8, label="desired")
        for name in data.controller.values:
            q = data.q_measured.sel(reading=reading, controller=name)
            left.plot(data.time, q, label=name)
            right.plot(data.time, 1e3 * (data.q_desired - q), label=name)
        for ax in (left, right):
            ax.axvspan(*WINDOW, color="0.9", label="the paper's window")
        _range(left, data.q_desired)
        right.set_yscale("symlog", linthresh=1.0)
        left.set_title(f"reading: {reading}", loc="left", fontsize="small")
        below = "time [s]" if reading == readings[-1] else ""
        _named(left, below, "theta2 [rad]", legend=False)
        _named(right, below, "error [mrad]", legend=reading == readings[0])
    return figure


def _figure(rows: int) -> Figure:
    figure = Figure(figsize=(9.0, 2.6 * rows), layout="constrained")
    figure.subplots(rows, 1, sharex=True)
    return figure


def _named(ax: Axes, x: str, y: str, legend: bool = True) -> None:
    """Finish axes, with the legend beside them, where it covers no curve."""
    finish(ax, x, y)
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize="small")
    if not legend:
        ax.legend_.remove()  # type: ignore[union-attr]  # it was made above


def _range(ax: Axes, values: xr.DataArray, at_least: float = -np.inf) -> None:
    low, high = float(values.min()), max(float(values.max()), at_least)
    room = 0.1 * (high - low) or 1.0
    ax.set_ylim(low - room, high + room)
