"""Runs a compiled Diagram, piece by piece, as Drake's Simulator runs the Diagram itself."""

from __future__ import annotations

import math
from pathlib import Path
from typing import cast

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import SceneGraph
from pydrake.systems.framework import Diagram

from scara_drake.engine.arm import arm_parameters
from scara_drake.engine.build import program_of
from scara_drake.engine.dynamics import WORK
from scara_drake.engine.errors import LeftTheModelError
from scara_drake.engine.graph import STATE, graph_of
from scara_drake.engine.source import buffer_size
from scara_drake.engine.start import Start
from scara_drake.engine.watch import watched_links, watched_surfaces
from scara_drake.engine.writer import AT_LIMIT, NEAR, NOT_FINITE
from scara_drake.environment.surfaces import Environment

Array = NDArray[np.float64]

WATCH = 5  # ticks between two looks at what the links may touch
ROUNDING = 1e-9  # [s]


class CompiledStepper:
    """A Diagram at t = 0, and what advances it.

    Args:
        diagram: of `make_diagram`.
        environment: what the diagram's robot may touch.
        duration: of the run [s].
        log_period: from sample to sample [s].
        folder: of the cache.

    Raises:
        NotCompilableError: a part of the Diagram can only run in Drake; names it.
    """

    def __init__(
        self,
        diagram: Diagram,
        environment: Environment,
        duration: float,
        log_period: float,
        folder: Path,
    ) -> None:
        graph = graph_of(diagram)
        self._plant = graph.plant
        self._duration, self._log_period = duration, log_period
        self._period = graph.plant.time_step()
        self._program = program_of(graph, self._period, folder)
        scene_graph = cast(SceneGraph, diagram.GetSubsystemByName("scene_graph"))
        self._watched = (
            watched_links(graph.plant, scene_graph),
            watched_surfaces(environment),
        )
        if self._watched[0].shape[0] == 0:
            self._watched = (self._watched[0], self._watched[1][:0])
        self._arm, self._work = arm_parameters(graph.plant), WORK.zeros()
        self._context = diagram.CreateDefaultContext()
        own = graph.plant.GetMyContextFromRoot(self._context)
        self._state = np.array(graph.plant.GetPositionsAndVelocities(own))
        self._buffers = self._program.buffers()
        self._kernels = self._program.kernels()
        self._cursor = np.zeros(2 + len(self._program.source.slow), dtype=np.int64)
        self._stop = np.zeros(2, dtype=np.int64)
        self._tick = 0
        self._last = math.ceil(duration / self._period - ROUNDING / self._period)
        self._width = sum(buffer_size(graph, buffer) for buffer in graph.recorded)
        Start(graph, self._buffers, self._state).run()

    def advance_to(self, time: float) -> tuple[Array, Array]:
        """Advance to a time [s] and return the samples since: times (n,) and values (n, width).

        Raises:
            LeftTheModelError: a joint is at its limit, or a link touches a surface.
            RuntimeError: NaN or infinity arrives on a port that has to be finite; names the system,
                the port, the time and the entry.
        """
        end = self._last + 1 if time >= self._duration else math.ceil(time / self._period)
        rows = math.ceil((end - self._tick) * self._period / self._log_period) + 2
        times, records = np.empty(rows), np.empty((rows, self._width))
        self._cursor[0], watch = 0, WATCH
        while self._tick < end:
            self._tick = self._program.advance(
                self._tick,
                min(end - self._tick, 1 if watch == 1 else end),
                self._last,
                self._duration,
                self._period,
                self._log_period,
                watch,
                self._cursor,
                times,
                records,
                self._stop,
                self._arm,
                self._work,
                *self._watched,
                self._state,
                *self._buffers.values(),
                *self._kernels,
            )
            watch = self._after_stop()
        return times[: self._cursor[0]], records[: self._cursor[0]]

    def _after_stop(self) -> int:
        """Say why the run came back, or return how many ticks lie between two looks from here."""
        reason, index = self._stop
        self._stop[:] = 0
        if reason == NOT_FINITE:
            self._refuse_not_finite(*self._program.source.guards[index])
        if reason == AT_LIMIT:
            joint = int(WORK.unpack(self._work).beyond[()])
            raise LeftTheModelError(self._tick * self._period, f"joint {joint} is at its limit")
        if reason == NEAR:
            self._look_for_contact()
            return 1
        return WATCH

    def _refuse_not_finite(self, name: str, inputs: list[str]) -> None:
        time = self._tick * self._period
        for port in inputs:
            buffer = self._program.graph.nodes[name].reads[port]
            values = self._state if buffer == STATE else self._buffers[str(buffer)]
            for index in np.flatnonzero(~np.isfinite(values)):
                raise RuntimeError(
                    f"{name}: port '{port}' at t = {time:.6g} s: {port}[{index}] is {values[index]}"
                )

    def _look_for_contact(self) -> None:
        """Ask Drake whether a link touches a surface.

        Raises:
            LeftTheModelError: one does.
        """
        own = self._plant.GetMyMutableContextFromRoot(self._context)
        self._plant.SetPositions(own, self._state[:6])
        query = self._plant.get_geometry_query_input_port().Eval(own)
        for pair in query.ComputePointPairPenetration():
            frames = (query.inspector().GetFrameId(each) for each in (pair.id_A, pair.id_B))
            bodies = (self._plant.GetBodyFromFrameId(frame).name() for frame in frames)
            what = " touches ".join(sorted(bodies))
            raise LeftTheModelError(self._tick * self._period, what)
