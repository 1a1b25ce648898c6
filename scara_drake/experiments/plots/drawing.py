"""What the pictures share: their size, their colours, one legend outside of all axes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from scara_drake.plotting import DESIRED, FIRST, LAW, LIMIT, MEASURED, SECOND

# Of runs beside each other; the first is what the figure is about.
COLORS: Final = (MEASURED, FIRST, SECOND, "#7b4fa3", "#8c5a3c", "0.45")
ALLOWED: Final[dict[str, Any]] = {"color": LIMIT, "linestyle": "--", "linewidth": 1.0}
SAID: Final[dict[str, Any]] = {"color": LAW, "linestyle": ":", "linewidth": 1.4}  # by the paper
ASKED: Final[dict[str, Any]] = {"color": DESIRED, "linestyle": "--", "linewidth": 1.2}
SETTLED: Final = slice(1.0, None)  # before it the drives take up the weight of the arm [s]
WIDTH: Final = 8.0  # [in], 800 pixels
LEGEND_WIDTH: Final = 115  # characters in a row of a legend
HANDLE: Final = 7  # of them that a line and the space around it take


def panels(rows: int, columns: int = 1, height: float = 2.1, **shared: Any) -> tuple[Figure, Any]:
    """Return a figure and its axes, (rows, columns) without the dimensions that are 1.

    Args:
        rows: of axes.
        columns: of axes.
        height: of a row [in].
        **shared: of `Figure.subplots`; all rows share their x axis unless it says otherwise.
    """
    figure = Figure(figsize=(WIDTH, 0.5 + height * rows), layout="constrained")
    return figure, figure.subplots(rows, columns, **{"sharex": True, **shared})


def each(ax: Axes, values: xr.DataArray, x: xr.DataArray, scale: float = 1.0, **line: Any) -> None:
    """Draw a line for each value of the dimension that x has not, in COLORS and named by it.

    Args:
        ax: where to draw.
        values: over the dimension of x and one more.
        x: what they are drawn over.
        scale: from the unit of the data to that of the axes.
        **line: of `Axes.plot`.
    """
    (dim,) = (name for name in values.dims if name not in x.dims)
    for color, name in zip(COLORS, values[dim].values, strict=False):
        one = scale * values.sel({dim: name})
        ax.plot(x, one, **{"color": color, "label": str(name), **line})


def named(ax: Axes, x: str, y: str, title: str = "") -> None:
    """Name the axes, with units, and draw a light grid."""
    ax.set_xlabel(x)
    ax.set_ylabel(y)
    ax.grid(alpha=0.3)
    if title:
        ax.set_title(title, loc="left", fontsize="medium")


def legend(figure: Figure) -> Figure:
    """Put one legend of all axes above them, where it covers no curve, and return the figure."""
    found: dict[str, Artist] = {}
    for ax in figure.axes:
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
            found.setdefault(label, handle)
    columns = min(len(found), LEGEND_WIDTH // (HANDLE + max(len(label) for label in found)))
    figure.legend(
        list(found.values()),
        list(found),
        loc="outside upper left",
        ncols=max(columns, 1),
        frameon=False,
        fontsize="medium",
    )
    return figure


def ranged(ax: Axes, values: xr.DataArray, also: Sequence[float] = ()) -> None:
    """Let the y axis show some values, in the unit of the axes, and some numbers beside them."""
    shown = np.concatenate([np.ravel(values), np.asarray(also, dtype=np.float64)])
    low, high = float(np.nanmin(shown)), float(np.nanmax(shown))
    room = 0.08 * (high - low) or 1.0
    ax.set_ylim(low - room, high + room)
