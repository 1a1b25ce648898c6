"""The task's drawing and the surfaces around it, seen along an axis, under the tool's path."""

from __future__ import annotations

from itertools import product
from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Polygon
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from scara_drake import plotting
from scara_drake.display import look
from scara_drake.metrics.task_of import task_of
from scara_drake.recordings.surfaces import Block, facing, read_blocks, read_scenario

Array = NDArray[np.float64]

AXES: Final = ("x", "y", "z")
MARGIN: Final = 0.06  # [m] around the path and the task
MARK: Final = "#333333"
PATH: Final = look.MEASURED[:3]
SOLID: Final = look.SURFACE[:3]


def draw_path(recording: xr.Dataset, ax: Axes, first: int, second: int) -> None:
    """Draw what the tool did as seen along the third axis; `first` goes right, `second` up."""
    path = recording.p_WE_measured.values
    places = [path]
    for block in blocks(recording):
        _solid(ax, corners(block)[:, [first, second]])
    places.append(_task(recording, ax, first, second))
    ax.plot(path[:, first], path[:, second], color=PATH, linewidth=1.0, label="tool")
    ax.plot(*path[0, [first, second]], "o", color=PATH, markersize=5, label="start")
    shown = np.concatenate(places)[:, [first, second]]
    low, high = np.nanmin(shown, axis=0) - MARGIN, np.nanmax(shown, axis=0) + MARGIN
    ax.set_xlim(low[0], high[0])
    ax.set_ylim(low[1], high[1])
    ax.set_aspect("equal", adjustable="box")
    plotting.finish(ax, f"{AXES[first]} [m]", f"{AXES[second]} [m]")


def blocks(recording: xr.Dataset) -> list[Block]:
    """Return the solids of a recording's scenario, a pipe to cut among them."""
    text = recording.attrs.get("scenario", "")
    try:
        found = read_blocks(text)
        cut = read_scenario(text)["environment"].get("cut")
    except (ValueError, LookupError, TypeError, AttributeError):
        return []
    if isinstance(cut, dict):
        X_WB = np.eye(4)
        X_WB[:3, :3] = facing(np.array(cut["direction"], dtype=float))
        X_WB[:3, 3] = np.array(cut["point"], dtype=float)
        found.append(Block([float(cut["radius"]), float(cut["length"])], X_WB))
    return found


def corners(block: Block) -> Array:
    """Return points (n, 3) [m] whose hull is a solid."""
    if len(block.size) == 3:
        half = np.array(block.size) / 2.0
        points = np.array(list(product((-1.0, 1.0), repeat=3))) * half
    else:
        radius, length = block.size
        angle = np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)
        ring = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
        ends = [np.column_stack([ring, np.full(48, end * length)]) for end in (-0.5, 0.5)]
        points = np.concatenate(ends)
    return np.asarray(points @ block.X_WB[:3, :3].T + block.X_WB[:3, 3])


def _ring(middle: Array, radius: float) -> Circle:
    return Circle((middle[0], middle[1]), radius, fill=False, edgecolor=MARK)


def _solid(ax: Axes, points: Array) -> None:
    hull = points[ConvexHull(points).vertices]
    ax.add_patch(Polygon(hull, facecolor=(*SOLID, 0.25), edgecolor=SOLID, linewidth=0.8))


def _task(recording: xr.Dataset, ax: Axes, first: int, second: int) -> Array:
    """Draw the task; return the places (n, 3) [m] that have to be in the picture."""
    task: Any = task_of(recording)
    if task is None:
        return np.empty((0, 3))
    if hasattr(task, "points"):
        points = np.array(task.points)
        style = "-" if hasattr(task, "force") else "none"
        ax.plot(
            points[:, first], points[:, second], color=MARK, linestyle=style, marker=".",
            label="task",
        )  # fmt: skip
        if style == "none":
            for number, point in enumerate(points, 1):
                ax.add_patch(_ring(point[[first, second]], task.tolerance))
                ax.annotate(
                    str(number),
                    point[[first, second]],
                    color=MARK,
                    fontsize=9,
                    xytext=(7, 5),
                    textcoords="offset points",
                )
        return points
    if hasattr(task, "goal"):
        goal = np.array(task.goal)
        ax.add_patch(_ring(goal[[first, second]], task.tolerance))
        way = np.array([task.opening, task.goal])
        ax.plot(way[:, first], way[:, second], ":", color=MARK, label="straight way")
        return way
    return np.asarray(task.places())
