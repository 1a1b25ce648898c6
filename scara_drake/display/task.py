"""What an operator's task looks like: points, a line, a goal, and a pipe with its cut so far."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydrake.geometry import Box, Cylinder, Meshcat, Rgba, Sphere
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.systems.framework import Context, LeafSystem

from scara_drake.display import look
from scara_drake.environment import PipeCut
from scara_drake.environment.place import facing
from scara_drake.tasks import CutPipe, ReachInto, Task, TouchPoints, TraceLine

Array = NDArray[np.float64]

PERIOD = 0.25  # of the pictures of a cut [s]
SEGMENTS = 40  # of the mark around a pipe
LINE = 0.006  # radius of a line [m]
BAND = 0.024  # width of the mark around a pipe [m]
_ROOT = "task"


class TaskAnnotations(LeafSystem):
    """Draws a task in Meshcat; of the mark around a pipe, what is cut is dark.

    Input port cells (n), which may stay unconnected: of a pipe to cut, what of each cell is left.
    Publish (every PERIOD, where there is a pipe): the mark, at the time of the context.

    Args:
        meshcat: where to draw.
        task: what to draw; None is a pipe without one.
        pipe: that is cut, if there is one.
    """

    __slots__ = ()  # so that it can be freed, see `Collectable`

    def __init__(self, meshcat: Meshcat, task: Task | None, pipe: PipeCut | None) -> None:
        super().__init__()
        self._meshcat, self._task, self._pipe = meshcat, task, pipe
        size = 1 if pipe is None else pipe.cells_around * pipe.cells_through
        self._cells = self.DeclareVectorInputPort("cells", size)
        self.DeclareInitializationPublishEvent(self._draw)
        self.DeclareForcedPublishEvent(self._draw)
        if pipe is not None:
            self.DeclarePeriodicPublishEvent(PERIOD, 0.0, self._color_mark)

    def _draw(self, context: Context) -> None:
        meshcat, task = self._meshcat, self._task
        meshcat.Delete(_ROOT)
        if isinstance(task, TouchPoints):
            for index, point in enumerate(task.points):
                _ball(meshcat, f"point_{index}", point, task.tolerance)
        if isinstance(task, TraceLine):
            points = np.array(task.points)
            for index, (start, end) in enumerate(pairwise(points)):
                _tube(meshcat, f"line_{index}", start, end)
        if isinstance(task, ReachInto):
            _ball(meshcat, "goal", task.goal, task.tolerance)
            X_WO = RigidTransform(facing(task.outward), np.array(task.opening))
            for bar in look.edge_frame(task.size, look.EDGE_WIDTH / 2):
                path = f"{_ROOT}/{bar.name}"
                meshcat.SetObject(path, Box(*bar.size), Rgba(*look.TASK))
                meshcat.SetTransform(path, X_WO @ RigidTransform(bar.X))
        if self._pipe is not None:
            mark = task.mark if isinstance(task, CutPipe) else 0.0
            _mark(meshcat, self._pipe, mark)
            self._color_mark(context)

    def _color_mark(self, context: Context) -> None:
        if self._pipe is None or not self._cells.HasValue(context):
            return
        left = self._cells.Eval(context).reshape(-1, self._pipe.cells_around).mean(axis=0)
        for index, cells in enumerate(np.array_split(left, SEGMENTS)):
            path, whole = f"{_ROOT}/mark/{index}", bool(cells.mean() > 0.5)
            self._meshcat.SetProperty(path, "visible", whole, context.get_time())


def _ball(meshcat: Meshcat, name: str, place: ArrayLike, radius: float) -> None:
    path = f"{_ROOT}/{name}"
    meshcat.SetObject(path, Sphere(radius), Rgba(*look.TASK))
    meshcat.SetTransform(path, RigidTransform(np.array(place, dtype=np.float64)))


def _tube(meshcat: Meshcat, name: str, start: Array, end: Array) -> None:
    path, along = f"{_ROOT}/{name}", end - start
    R = RotationMatrix.MakeFromOneVector(along, 2)
    meshcat.SetObject(path, Cylinder(LINE, float(np.linalg.norm(along))), Rgba(*look.TASK))
    meshcat.SetTransform(path, RigidTransform(R, (start + end) / 2))


def _mark(meshcat: Meshcat, pipe: PipeCut, place: float) -> None:
    """Draw a mark of segments around a pipe, over a dark band that shows where they are gone."""
    X_WM = pipe.pose() @ RigidTransform(np.array([0.0, 0.0, place]))
    meshcat.SetObject(f"{_ROOT}/cut", Cylinder(pipe.radius + 1e-3, BAND), Rgba(*look.CUT))
    meshcat.SetTransform(f"{_ROOT}/cut", X_WM)
    # The first cells of a ring begin at the angle 0, as `np.array_split` parts them.
    edges = np.cumsum([0, *(part.size for part in _parts(pipe.cells_around))])
    for index, (low, high) in enumerate(pairwise(edges.tolist())):
        angle, wide = np.pi * (low + high) / edges[-1], 2 * np.pi * (high - low) / edges[-1]
        R = RotationMatrix.MakeZRotation(angle)
        place_M = R @ np.array([pipe.radius + 2e-3, 0.0, 0.0])
        path = f"{_ROOT}/mark/{index}"
        segment = Box(2e-3, max(wide, 1e-3) * (pipe.radius + 2e-3), BAND)
        meshcat.SetObject(path, segment, Rgba(*look.TASK))
        meshcat.SetTransform(path, X_WM @ RigidTransform(R, place_M))


def _parts(cells: int) -> list[Array]:
    return np.array_split(np.zeros(cells), SEGMENTS)
