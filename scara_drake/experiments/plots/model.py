"""The model, drawn from its joint frames in the form of the paper's Figure 2."""

from __future__ import annotations

from typing import Any, Final

import xarray as xr
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator

from scara_drake.plotting import FIRST, SECOND

LENGTH: Final = 0.35  # of an arrow [m]


def axes(data: xr.Dataset) -> Figure:
    """Draw the arm at home, with the axis of each joint as an arrow."""
    figure = Figure(figsize=(7.0, 5.5), layout="constrained")
    ax: Any = figure.add_subplot(projection="3d")  # matplotlib's stubs know no axes in space
    p = data.origin.values
    ax.plot(*p.T, "o-", color=FIRST, linewidth=3.0, label="links, from joint to joint")
    for name, start, axis in zip(data.joint.values, p, data.axis.values, strict=False):
        ax.quiver(*start, *(LENGTH * axis), color=SECOND, linewidth=2.0)
        ax.text(*(start + 1.15 * LENGTH * axis), str(name), fontsize="small")
    ax.plot([], [], color=SECOND, label="axes of the joints")
    for axis in (ax.xaxis, ax.yaxis, ax.zaxis):
        axis.set_major_locator(MultipleLocator(0.4))
    ax.set_xlabel("x [m]")
    ax.set_ylabel("y [m]")
    ax.set_zlabel("z [m]")
    ax.set_zlim(p[:, 2].min(), p[:, 2].max() + 1.5 * LENGTH)
    ax.set_aspect("equal")
    ax.legend(loc="upper left", fontsize="small")
    return figure
