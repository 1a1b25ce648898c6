"""The score of a training task, by its recording alone.

The total is 0 to 100: each criterion has a weight, and a value that is worth all of it at `best`,
nothing at `worst`, and a straight line between. All of that counts in proportion to the share of
the task that was done, so that who does nothing has nothing::

    total = share_done * sum of weight * clip((value - worst) / (best - worst), 0, 1)

The weights of a task add up to 100. What is measured ends when the task is done, or its time is up.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any, Final

import numpy as np
import xarray as xr

from scara_drake.metrics.stretches import Stretch, stretches
from scara_drake.metrics.task_of import (
    BOUNCE,
    Progress,
    along_surface,
    elapsed,
    forces,
    progress,
    task_of,
    to_line,
    touching,
)
from scara_drake.tasks import CutPipe, ReachInto, Task, TouchPoints, TraceLine


@dataclass(frozen=True)
class Criterion:
    """One thing that a score judges.

    Attributes:
        name: what it is.
        unit: of the value and its bounds.
        weight: points that it is worth at most.
        best: value from which it is worth all of them.
        worst: value from which it is worth none.
        value: measured; NaN is worth nothing.
    """

    name: str
    unit: str
    weight: float
    best: float
    worst: float
    value: float

    @property
    def points(self) -> float:
        """What the value is worth, 0 to weight, before the share of the task that was done."""
        if not math.isfinite(self.value):
            return 0.0
        share = (self.value - self.worst) / (self.best - self.worst)
        return self.weight * min(max(share, 0.0), 1.0)


@dataclass(frozen=True)
class Score:
    """A training task, scored.

    Attributes:
        task: its kind.
        share: of it that was done, 0 to 1.
        seconds: until it was done [s]; NaN where it was not.
        criteria: what is judged.
        marks: instants that belong to it, from the start [s].
    """

    task: str
    share: float
    seconds: float
    criteria: tuple[Criterion, ...]
    marks: tuple[float, ...] = ()

    @property
    def done(self) -> bool:
        """Whether the task was done within its time."""
        return math.isfinite(self.seconds)

    @property
    def total(self) -> float:
        """0 to 100."""
        return self.share * sum(each.points for each in self.criteria)

    def table(self) -> str:
        """The criteria with their points as JSON, a NaN as null."""
        rows = [asdict(each) | {"points": each.points} for each in self.criteria]
        return json.dumps([{name: _told(value) for name, value in row.items()} for row in rows])


def score(recording: xr.Dataset) -> Score | None:
    """Score a recording: a pure function of its variables; None where there is no task in it.

    Raises:
        ValueError: the task in its scenario is not valid.
    """
    task = task_of(recording)
    if task is None or not recording.sizes.get("time"):
        return None
    made = progress(recording, task)
    start = float(recording.time[0])
    until = made.seconds if math.isfinite(made.seconds) else task.most_time
    window = recording.sel(time=slice(None, start + until + 1e-9))
    criteria = (
        Criterion("share done", "1", 30.0, 1.0, 0.0, made.share),
        Criterion("time", "s", TIME[type(task)], 0.0, task.most_time, made.seconds),
        *CRITERIA[type(task)](window, task, made),
    )
    return Score(type(task).__name__, made.share, made.seconds, criteria, made.marks)


def score_attributes(recording: xr.Dataset) -> dict[str, str | int | float]:
    """Return what a recording says of its score: attributes, none where it has no task."""
    found = score(recording)
    if found is None:
        return {}
    return {"score": round(found.total, 3), "score_table": found.table()}


def _told(value: Any) -> Any:
    """What JSON says of a value: numbers to six digits, as engines differ by roundings."""
    if not isinstance(value, float):
        return value
    return float(f"{value:.6g}") if math.isfinite(value) else None


def squared_force(recording: xr.Dataset) -> float:
    """Integral of the squared force, ∫ |f|² dt by the trapezoidal rule [N² s]."""
    squares = (forces(recording) ** 2).sum(axis=1)
    return float(np.trapezoid(squares, recording.time.values))


def peak_force(recording: xr.Dataset) -> float:
    """Largest force on the tool [N]."""
    return float(np.linalg.norm(forces(recording), axis=1).max())


def mean_force(recording: xr.Dataset) -> float:
    """Mean force on the tool while it is in contact [N]; zero where it never is."""
    size = np.linalg.norm(forces(recording), axis=1)
    return float(size[size > 0.0].mean()) if (size > 0.0).any() else 0.0


def collisions(recording: xr.Dataset, task: Task) -> list[Stretch]:
    """Stretches in which the tool is in a surface that the task does not name."""
    if "penetration" not in recording:
        return []
    asked = task.touchable()
    found: list[Stretch] = []
    for name in recording.surface.values:
        if str(name) not in asked:
            inside = touching(recording, str(name))
            found += merged(recording, inside)
    return sorted(found, key=lambda each: each.start)


def merged(recording: xr.Dataset, inside: Any) -> list[Stretch]:
    """Stretches of a contact, of which those nearer to each other than a bounce are one."""
    found: list[Stretch] = []
    for each in stretches(recording.time.values, inside):
        if found and each.start - found[-1].end < BOUNCE:
            each = Stretch(found.pop().start, each.end, each.open)
        found.append(each)
    return found


def rms(values: Any) -> float:
    """Root of the mean square; NaN of nothing."""
    return float(np.sqrt(np.mean(np.square(values)))) if len(values) else math.nan


def _collisions(window: xr.Dataset, task: Task, weight: float) -> tuple[Criterion, Criterion]:
    found = collisions(window, task)
    time = sum(each.length for each in found)
    return (
        Criterion("collisions", "1", 0.5 * weight, 0.0, 3.0, float(len(found))),
        Criterion("time in collision", "s", 0.5 * weight, 0.0, 2.0, time),
    )


def _of_touch(window: xr.Dataset, task: TouchPoints, made: Progress) -> tuple[Criterion, ...]:
    t, p = elapsed(window), window.p_WE_measured.values
    at = [int(np.searchsorted(t, mark - 1e-9)) for mark in made.marks]
    points = np.array(task.points)[: len(at)]
    away = rms(np.linalg.norm(p[at] - points, axis=1)) if at else math.nan
    least, most, count = task.least_force, task.most_force, len(task.points)
    return (
        Criterion("touches off their marks, RMS", "m", 15.0, 0.0, task.tolerance, away),
        Criterion("largest force", "N", 15.0, 4.0 * least, most, peak_force(window)),
        Criterion(
            "squared force, integral",
            "N^2 s",
            10.0,
            count * (2.0 * least) ** 2,
            count * (0.5 * most) ** 2,
            squared_force(window),
        ),
        *_collisions(window, task, 10.0),
    )


def _of_trace(window: xr.Dataset, task: TraceLine, made: Progress) -> tuple[Criterion, ...]:
    on = touching(window, task.surface)
    force = forces(window)
    offsets = to_line(np.array(task.points), window.p_WE_measured.values[on])
    begun = np.flatnonzero(on)
    size = np.linalg.norm(force, axis=1)[begun[0] :] if begun.size else np.empty(0)
    off = rms(along_surface(offsets, force[on]))
    line, allowed = task.tolerance, task.force_tolerance
    return (
        Criterion("off the line, RMS", "m", 20.0, 0.1 * line, 2.0 * line, off),
        Criterion(
            "force off what is set, RMS", "N", 20.0, 0.0, 2.0 * allowed, rms(size - task.force)
        ),
        Criterion(
            "largest force", "N", 10.0, task.force + allowed, task.most_force, peak_force(window)
        ),
        *_collisions(window, task, 5.0),
    )


def _of_reach(window: xr.Dataset, task: ReachInto, made: Progress) -> tuple[Criterion, ...]:
    p = window.p_WE_measured.values
    inside = p[task.depth_of(p) > 0.0]
    way = np.linalg.norm(to_line(np.array([task.opening, task.goal]), inside), axis=1)
    most = 0.25 * min(task.size)
    return (
        Criterion("off the straight way, RMS", "m", 10.0, 0.0, most, rms(way)),
        Criterion("largest force", "N", 10.0, 0.0, 0.5 * task.most_force, peak_force(window)),
        Criterion(
            "squared force, integral", "N^2 s", 5.0, 0.0, task.most_force**2, squared_force(window)
        ),
        *_collisions(window, task, 25.0),
    )


def _of_cut(window: xr.Dataset, task: CutPipe, made: Progress) -> tuple[Criterion, ...]:
    stalls = merged(window, window.blade_stalled.values > 0.5)
    stalled = sum(each.length for each in stalls)
    cut = float(window.energy_cut[-1])
    spent = float(window.energy_blade[-1]) / cut if cut > 0.0 else math.nan
    off = abs(float(window.kerf_place[-1]) - task.mark)
    bend = float(abs(window.blade_bend).max())
    most = task.most_force
    return (
        Criterion("kerf off the mark", "m", 15.0, 0.2 * task.tolerance, 2.0 * task.tolerance, off),
        Criterion("largest force", "N", 10.0, 0.5 * most, 1.5 * most, peak_force(window)),
        Criterion("stalls", "1", 5.0, 0.0, 5.0, float(len(stalls))),
        Criterion("time stalled", "s", 5.0, 0.0, 5.0, stalled),
        Criterion("blade bent, most", "m", 5.0, 0.0, 0.01, bend),
        Criterion("blade's energy to that of the cut", "1", 5.0, 1.1, 3.0, spent),
        *_collisions(window, task, 10.0),
    )


CRITERIA: Final[dict[type, Callable[..., tuple[Criterion, ...]]]] = {
    TouchPoints: _of_touch,
    TraceLine: _of_trace,
    ReachInto: _of_reach,
    CutPipe: _of_cut,
}
# Points of the time that a task took, from none of what it is given to all of it.
TIME: Final = {
    TouchPoints: 20.0,
    TraceLine: 15.0,
    ReachInto: 20.0,
    CutPipe: 15.0,
}
