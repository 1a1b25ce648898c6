"""What is shown of a task: where to touch, to trace, to reach and to cut; and the pipe to cut."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scara_drake.display import look
from scara_drake.recordings.surfaces import facing
from scara_drake.scenario import Scenario
from scara_drake.tasks import CutPipe, ReachInto, TouchPoints, TraceLine

Array = NDArray[np.float64]

MARK: Final[look.Color] = (1.0, 0.62, 0.05, 0.85)

LINE: Final = 0.003  # radius of a line [m]


def marks_of(scenario: Scenario) -> list[look.Part]:
    """Return the parts, in W."""
    task, pipe = scenario.task, scenario.environment.cut
    parts = [] if pipe is None else [_along(pipe.pose(), 0.0, pipe.radius, pipe.length, look.PIPE)]
    if type(task) in _MARKS:
        parts += _MARKS[type(task)](task, scenario)
    return [part._replace(name=str(index)) for index, part in enumerate(parts)]


def _points(task: TouchPoints, scenario: Scenario) -> Iterator[look.Part]:
    for point in task.points:
        yield _ball(point, task.tolerance)


def _line(task: TraceLine, scenario: Scenario) -> Iterator[look.Part]:
    for start, end in pairwise(np.array(task.points)):
        X, length = look.at(*(start + end) / 2), float(np.linalg.norm(end - start))
        X[:3, :3] = facing(end - start)
        yield look.Part("", "cylinder", (LINE, length), X, MARK)


def _goal(task: ReachInto, scenario: Scenario) -> Iterator[look.Part]:
    yield _ball(task.goal, task.tolerance)


def _cut(task: CutPipe, scenario: Scenario) -> Iterator[look.Part]:
    pipe = scenario.environment.cut
    if pipe is not None:
        yield _along(pipe.pose(), task.mark, 1.03 * pipe.radius, 2 * task.tolerance, MARK)


def _ball(point: ArrayLike, radius: float) -> look.Part:
    return look.Part("", "sphere", (radius,), look.at(*np.asarray(point)), MARK)


def _along(X_WS: Any, place: float, radius: float, length: float, color: look.Color) -> look.Part:
    X = X_WS.GetAsMatrix4() @ look.at(0.0, 0.0, place)
    return look.Part("", "cylinder", (radius, length), X, color)


_MARKS: Final[dict[type, Callable[[Any, Scenario], Iterator[look.Part]]]] = {
    TouchPoints: _points,
    TraceLine: _line,
    ReachInto: _goal,
    CutPipe: _cut,
}
