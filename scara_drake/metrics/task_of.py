"""The training task of a recording, read without Drake, and how far it was done and when."""

from __future__ import annotations

from itertools import pairwise
from typing import Any, Final, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from scara_drake.common.schema import build
from scara_drake.metrics.stretches import stretches
from scara_drake.recordings.surfaces import KIND, read_scenario
from scara_drake.tasks import CutPipe, ReachInto, Task, TouchPoints, TraceLine

Array = NDArray[np.float64]

KINDS: Final[dict[str, type[Task]]] = {
    kind.__name__: kind for kind in (TouchPoints, TraceLine, ReachInto, CutPipe)
}
CELL: Final = 0.005  # [m], a line is traced cell by cell
MOST_CELLS: Final = 400
BOUNCE: Final = 0.05  # [s], contacts nearer to each other than this are one


def task_of(recording: xr.Dataset) -> Task | None:
    """Return the task of the scenario that a recording was made of; None where there is none.

    Raises:
        ValueError: the task in its scenario is not valid.
    """
    text = recording.attrs.get("scenario")
    data = read_scenario(text).get("task") if text else None
    if not isinstance(data, dict):
        return None
    name = str(data.get(KIND, TouchPoints.__name__))
    if name not in KINDS:
        raise ValueError(f"task: '{name}', allowed {', '.join(KINDS)}")
    fields = {key: value for key, value in data.items() if key != KIND}
    task: Task = build(KINDS[name], fields, "task.")
    return task


class Progress(NamedTuple):
    """How far a task was done.

    Attributes:
        share: of it, 0 to 1.
        seconds: from the start until it was done [s]; NaN where it was not.
        marks: instants that belong to it, such as of each touch [s].
    """

    share: float
    seconds: float
    marks: tuple[float, ...] = ()


def progress(recording: xr.Dataset, task: Task) -> Progress:
    """Return how far the task of a recording was done within its time."""
    within = recording.sel(time=slice(None, float(recording.time[0]) + task.most_time))
    return PROGRESS[type(task)](within, task)


def forces(recording: xr.Dataset) -> Array:
    """Force of the environment on the tool (n, 3) [N]; zero where there is no surface."""
    return np.nan_to_num(recording.f_env_on_tool_W.values)


def elapsed(recording: xr.Dataset) -> Array:
    """Time from the first sample on (n,) [s]."""
    t = recording.time.values
    return np.asarray(t - t[0], dtype=np.float64)


def touching(recording: xr.Dataset, surface: str) -> NDArray[np.bool_]:
    """Whether the tool is in a surface (n,)."""
    return np.asarray(recording.penetration.sel(surface=surface).values > 0.0)


def to_line(points: Array, places: Array) -> Array:
    """Vectors (n, 3) from places (n, 3) to what of a line through points (m, 3) is nearest."""
    best = np.full_like(places, np.inf)
    for begin, end in pairwise(points):
        way = end - begin
        share = np.clip((places - begin) @ way / (way @ way), 0.0, 1.0)
        offset = begin + share[:, None] * way - places
        nearer = (offset**2).sum(axis=1) < (best**2).sum(axis=1)
        best[nearer] = offset[nearer]
    return best


def along_surface(offsets: Array, force: Array) -> Array:
    """Lengths (n,) of vectors (n, 3) without their part along the force, which is the normal's."""
    size = np.linalg.norm(force, axis=1, keepdims=True)
    normal = np.divide(force, size, out=np.zeros_like(force), where=size > 0.0)
    across = offsets - (offsets * normal).sum(axis=1, keepdims=True) * normal
    return np.asarray(np.linalg.norm(across, axis=1))


def cells_of(points: Array) -> Array:
    """Middles (m, 3) of the cells of a line."""
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    size = max(CELL, float(lengths.sum()) / MOST_CELLS)
    found = []
    for begin, end, length in zip(points[:-1], points[1:], lengths, strict=True):
        count = max(int(np.ceil(length / size)), 1)
        found.append(begin + (np.arange(count)[:, None] + 0.5) / count * (end - begin))
    return np.concatenate(found)


def _touched(recording: xr.Dataset, task: TouchPoints) -> Progress:
    t, p, f = elapsed(recording), recording.p_WE_measured.values, forces(recording)
    pressed = touching(recording, task.surface) & (np.linalg.norm(f, axis=1) >= task.least_force)
    marks: list[float] = []
    after = -1.0
    for point in np.array(task.points):
        near = np.linalg.norm(p - point, axis=1) <= task.tolerance
        at = np.flatnonzero(pressed & near & (t > after))
        if not at.size:
            break
        after = float(t[at[0]])
        marks.append(after)
    done = len(marks) == len(task.points)
    return Progress(len(marks) / len(task.points), after if done else np.nan, tuple(marks))


def _traced(recording: xr.Dataset, task: TraceLine) -> Progress:
    t, f = elapsed(recording), forces(recording)
    on = touching(recording, task.surface)
    p, t, f = recording.p_WE_measured.values[on], t[on], f[on]
    firsts = []
    for cell in cells_of(np.array(task.points)):
        near = np.flatnonzero(along_surface(cell - p, f) <= task.tolerance)
        firsts.append(t[near[0]] if near.size else np.inf)
    done = bool(np.isfinite(firsts).all())
    share = float(np.isfinite(firsts).mean())
    return Progress(share, float(max(firsts)) if done else np.nan)


def _reached(recording: xr.Dataset, task: ReachInto) -> Progress:
    t, p = elapsed(recording), recording.p_WE_measured.values
    depth = task.depth_of(p)
    inside = np.flatnonzero(depth > 0.0)
    if not inside.size:
        return Progress(0.0, np.nan)
    marks = [float(t[inside[0]])]
    near = np.linalg.norm(p - np.array(task.goal), axis=1) <= task.tolerance
    stays = [each for each in stretches(t, near) if each.length >= task.stay]
    if not stays:
        return Progress(0.25, np.nan, tuple(marks))
    marks.append(stays[0].start + task.stay)
    out = np.flatnonzero((depth < 0.0) & (t > marks[-1]))
    if not out.size:
        return Progress(0.75, np.nan, tuple(marks))
    return Progress(1.0, float(t[out[0]]), (*marks, float(t[out[0]])))


def _cut(recording: xr.Dataset, task: CutPipe) -> Progress:
    t, left = elapsed(recording), recording.cut_left.values
    through = np.flatnonzero(left <= task.left)
    share = 1.0 if through.size else float((1.0 - left.min()) / (1.0 - task.left))
    return Progress(share, float(t[through[0]]) if through.size else np.nan)


PROGRESS: Final[dict[type, Any]] = {
    TouchPoints: _touched,
    TraceLine: _traced,
    ReachInto: _reached,
    CutPipe: _cut,
}
