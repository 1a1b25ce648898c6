"""A blade that is moved by hand along a pipe: the kernels of a cut without plant and controller."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from scara_drake.cut_state import PIPE_STATE, PipeState
from scara_drake.environment import Blade, PipeCut
from scara_drake.environment.cut_law import cut_pipe
from scara_drake.joints import HOME
from scara_drake.kinematics import forward_kinematics, tool_kinematics_kernel

Array = NDArray[np.float64]


@njit
def _move(twist, period, q, parameters, cells, kerf, state, force, effort, log):
    p, R, J, robot = np.empty(3), np.empty((3, 3)), np.empty((6, 6)), np.empty(12)
    for tick in range(log.shape[0]):
        tool_kinematics_kernel(q, p, R, J)
        v = np.linalg.solve(J, twist)
        before = np.dot(effort, v)
        q += period * v
        tool_kinematics_kernel(q, p, R, J)
        v = np.linalg.solve(J, twist)
        robot[:6], robot[6:] = q, v
        cut_pipe(period, robot, parameters, cells, kerf, state, force, effort)
        log[tick, :-1] = state
        # The force that acts from one end of the step to the other.
        log[tick, -1] = 0.5 * (before + np.dot(effort, v)) * period


class CutRig:
    """The tool at home, before an upright pipe that it points at.

    Args:
        gap: from the tool to the pipe [m].
        period: of a step [s].
        blade: fields of the blade.
        pipe: fields of the pipe.

    Attributes:
        ahead, aside, axis: of the tool, in W: the feed, across it in the plane of the blade, and
            the blade's axis.
        work: done on the tool by what the blade feels [J].
        works: that after each tick of the last move (n,) [J].
    """

    def __init__(
        self, gap: float = 1e-4, period: float = 1e-3, blade: dict | None = None, **pipe: Any
    ) -> None:
        X_WE = forward_kinematics(HOME)
        self.aside, self.axis, self.ahead = X_WE[:3, :3].T
        radius = pipe.get("radius", PipeCut().radius)
        point = X_WE[:3, 3] + self.ahead * (radius + gap)
        self.pipe = PipeCut(
            point=point.tolist(), direction=self.axis.tolist(), blade=Blade(**blade or {}), **pipe
        )
        self.pipe.check_together("pipe")
        self.period, self.q = period, np.array(HOME)
        self.cells = np.ones(self.pipe.cells_around * self.pipe.cells_through)
        self._kerf = np.zeros(self.cells.size)
        self._parameters = self.pipe.parameters()
        self._state = PIPE_STATE.zeros(speed=abs(self.pipe.blade.speed), left=1.0)
        self.force, self._effort, self.work = np.zeros(3), np.zeros(6), 0.0
        self.works = np.zeros(0)

    def move(
        self, linear: ArrayLike = (0, 0, 0), angular: ArrayLike = (0, 0, 0), ticks: int = 1
    ) -> PipeState:
        """Move the tool with a velocity [m/s] and a rate [rad/s] in W; return what came of it.

        Of the ticks (ticks,), and `work` likewise.
        """
        twist = np.concatenate([angular, linear], dtype=np.float64)
        log = np.empty((ticks, PIPE_STATE.size + 1))
        pipe = (self._parameters, self.cells, self._kerf, self._state)
        _move(twist, self.period, self.q, *pipe, self.force, self._effort, log)
        self.works = self.work + np.cumsum(log[:, -1])
        self.work = float(self.works[-1])
        return PipeState(*log[:, :-1].T)

    def feed(self, speed: float, way: float) -> PipeState:
        """Move it straight ahead at a speed [m/s]."""
        return self.move(speed * self.ahead, ticks=round(way / speed / self.period))

    @property
    def state(self) -> PipeState:
        """Of pipe and blade, numbers."""
        return PipeState(*self._state)

    def areas(self) -> Array:
        """Of the cells (n,) [m²]."""
        pipe = self.pipe
        edges = np.linspace(pipe.radius - pipe.wall, pipe.radius, pipe.cells_through + 1)
        rings = np.pi * np.diff(edges**2) / pipe.cells_around
        return np.repeat(rings, pipe.cells_around)

    def removed(self) -> float:
        """Volume that the cells no longer have [m³]."""
        return float((1.0 - self.cells) @ self.areas()) * self.pipe.blade.kerf
