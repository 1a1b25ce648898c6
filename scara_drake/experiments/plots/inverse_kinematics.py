"""Figures 8 to 15, and Tables 5, 6 and 8: swarms and paths by the inverse kinematics."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from scara_drake.experiments.inverse_kinematics import (
    figures_8_9,
    figures_10_11,
    figures_12_15,
    table_6,
    table_8,
)
from scara_drake.experiments.plots.drawing import (
    ALLOWED,
    ASKED,
    COLORS,
    SAID,
    legend,
    named,
    panels,
)
from scara_drake.ik.result import POSITION_TOLERANCE, ROTATION_TOLERANCE
from scara_drake.plotting import FIRST, MEASURED, SECOND

# One colour a method, in all figures of this room.
METHOD_COLORS: Final = {
    "default DPSOIJ": MEASURED,
    "literal DPSOIJ": FIRST,
    "DPSO": SECOND,
    "IJ": COLORS[3],
    "IJ, position rows": COLORS[4],
}
OTHERS: Final = {"color": "0.75", "linewidth": 0.8}  # paths beside the one that is looked at
BOUNDS: Final = (1e3 * POSITION_TOLERANCE, ROTATION_TOLERANCE)  # [mm, rad]
TOLERATED: Final = f"tolerance, {BOUNDS[0]:g} mm and {BOUNDS[1]:g} rad"
LINEAR: Final = (1e-3, 1e-4)  # below it an axis of errors is linear, down to none [mm, rad]
Errors = tuple[xr.DataArray, xr.DataArray]  # of position [mm] and of rotation [rad]


def convergence(data: xr.Dataset, solver: str) -> Figure:
    """Draw the errors of the best particle over the iterations, for each posture.

    Args:
        data: of figures_8_9.
        solver: "PSO" or "DPSO".
    """
    figure, axes = panels(2)
    one = data.sel(solver=solver)
    for ax, error in zip(axes, _errors(one), strict=True):
        for color, number in zip(COLORS, data.posture.values, strict=False):
            line = error.sel(posture=number).dropna("iteration")
            ax.plot(line.iteration, line, color=color, label=f"posture {number}")
    (mean,) = figures_8_9.PAPER_ITERATIONS[solver].values
    for ax, bound in zip(axes, BOUNDS, strict=True):
        ax.axhline(bound, **ALLOWED, label=TOLERATED)
        ax.set_yscale("log")
        ax.axvline(mean, **SAID, label=f"the paper's mean, {mean:g} iterations")
    named(axes[0], "", "position error [mm]")
    named(axes[1], "iteration", "rotation error [rad]")
    return legend(figure)


def path_errors(data: xr.Dataset, which: str) -> Figure:
    """Draw an error along the points by each method: of one path, and the largest of all paths.

    Args:
        data: of figures_10_11.
        which: "position" or "rotation".
    """
    figure, axes = panels(2, sharey=True)
    index = ("position", "rotation").index(which)
    error, unit = _errors(data)[index], ("mm", "rad")[index]
    allowed, paper = (BOUNDS[index], figures_10_11.PAPER_IJ[index])
    drawn = (error.sel(path=0), error.max("path"))
    titles = ("the first path", f"the largest of {data.sizes['path']} paths")
    for ax, values, title in zip(axes, drawn, titles, strict=True):
        for name, color in METHOD_COLORS.items():  # the widest lies below
            width = 3.0 if name == "default DPSOIJ" else 1.5
            line = values.sel(solver=name)
            ax.plot(data.point, line, color=color, linewidth=width, label=name)
        ax.axhline(allowed, **ALLOWED, label=f"tolerance, {allowed:g} {unit}")
        ax.axhline(paper, **SAID, label=f"the paper's IJ, {paper:g} {unit}")
        named(ax, "point" if ax is axes[1] else "", f"{which} error [{unit}]", title)
    _from_none(axes[0], index, float(error.max()))  # its axis is shared
    return legend(figure)


def joint_path(data: xr.Dataset, joint: str, solvers: Sequence[str]) -> Figure:
    """Draw a joint along the points, on the path where DPSO jumps most often, and on the others.

    Args:
        data: of figures_12_15.
        joint: "theta3" or "theta4".
        solvers: the methods, an axis each.
    """
    steps = abs(data.q.sel(solver="DPSO", joint=list(figures_12_15.JOINTS)).diff("point"))
    jumps = (steps > figures_12_15.JUMP).sum(["joint", "point"])
    shown = data.path.values[int(jumps.argmax("path"))]
    figure, axes = panels(len(solvers), squeeze=False, sharey=True)
    for ax, solver in zip(axes[:, 0], solvers, strict=True):
        q = data.q.sel(solver=solver, joint=joint)
        for path in data.path.values:
            if path != shown:
                ax.plot(data.point, q.sel(path=path), **OTHERS, label="the other paths")
        own = q.sel(path=shown)
        style = {"color": METHOD_COLORS[solver], "marker": "."}
        ax.plot(data.point, own, **style, label=f"{solver}, path {shown}")
        made = data.q_path.sel(path=shown, joint=joint)
        turns = 2.0 * np.pi * np.round((own - made)[0] / (2.0 * np.pi))
        ax.plot(data.point, made + turns, **ASKED, label="what that path was made from")
        below = "point" if solver == solvers[-1] else ""
        named(ax, below, f"joint {joint[-1]} [rad]")
    return legend(figure)


def reached(data: xr.Dataset) -> Figure:
    """Draw how near the best posture of the arm, and of the arm with its mast, comes (Table 5)."""
    names = {"arm": "arm alone", "full": "arm with its mast"}
    rows = {text: data.sel(joints=name).expand_dims("start", -1) for name, text in names.items()}
    return _by_posture(rows, data.posture.values)


def inverse_jacobian(data: xr.Dataset) -> Figure:
    """Draw where the inverse Jacobian ends from each start, with the mast (Table 6)."""
    names = {"full": "all rows, (1) to (11)", "position": "position rows, (26)"}
    rows = {text: data.sel(rows=name, joints="full") for name, text in names.items()}
    paper = (table_6.PAPER_POSITION.values, table_6.PAPER_ROTATION.values)
    return _by_posture(rows, data.posture.values, {"the paper's IJ": paper})


def swarms(data: xr.Dataset) -> Figure:
    """Draw where PSO and DPSO end by each draw (Table 8)."""
    rows = {str(name): data.sel(solver=name) for name in data.solver.values}
    count = data.sizes["posture"]
    both = (table_8.PAPER_POSITION.values, table_8.PAPER_ROTATION.values)
    paper = {
        "the paper's PSO": [values[:count] for values in both],
        "the paper's DPSO": [values[count:] for values in both],
    }
    return _by_posture(rows, data.posture.values, paper)


def _errors(data: xr.Dataset) -> Errors:
    return 1e3 * data.position_error, data.rotation_error


def _from_none(ax: Axes, index: int, largest: float) -> None:
    """Let an axis of errors be logarithmic but for the least ones, so that none can be shown."""
    ax.set_yscale("symlog", linthresh=LINEAR[index])
    ax.set_ylim(-0.2 * LINEAR[index], 2.0 * largest)


def _by_posture(
    rows: dict[str, xr.Dataset],
    numbers: Sequence[int],
    paper: Mapping[str, Sequence[Sequence[float]]] | None = None,
) -> Figure:
    """Draw the errors of all answers of each row, beside each other at each posture.

    Args:
        rows: position_error and rotation_error over (posture, one more), by name.
        numbers: of the postures.
        paper: errors of position [mm] and of rotation [rad] at each posture, by name.
    """
    figure, axes = panels(2, height=2.6)
    places, width = np.arange(len(numbers)), 0.8 / len(rows)
    for index, ax in enumerate(axes):
        for place, (name, row) in enumerate(rows.items()):
            error = _errors(row)[index]
            (dim,) = (d for d in error.dims if d != "posture")
            apart = 0.6 * np.linspace(-0.5, 0.5, error.sizes[dim] + 2)[1:-1]
            at = places[:, np.newaxis] - 0.4 + width * (place + 0.5 + apart)
            values = error.transpose("posture", dim).values
            ax.plot(at.ravel(), values.ravel(), ".", color=COLORS[place], label=name)
        for marker, (name, said) in zip("_x", (paper or {}).items(), strict=False):
            ax.plot(places, said[index], marker, color="k", markersize=9, label=name)
        ax.axhline(BOUNDS[index], **ALLOWED, label=TOLERATED)
        _from_none(ax, index, max(float(_errors(row)[index].max()) for row in rows.values()))
    axes[1].set_xticks(places, [f"posture {number}" for number in numbers])
    named(axes[0], "", "position error [mm]")
    named(axes[1], "", "rotation error [rad]")
    return legend(figure)
