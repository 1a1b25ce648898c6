"""Runs a compiled Diagram, piece by piece, as Drake's Simulator runs the Diagram itself."""

from __future__ import annotations

import math
from pathlib import Path
from typing import cast

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import SceneGraph
from pydrake.systems.framework import Diagram

from scara_drake.dynamics.arm import arm_parameters
from scara_drake.dynamics.equations import JOINTS, WORK
from scara_drake.engine.build import program_of
from scara_drake.engine.errors import LeftTheModelError, NotCompilableError
from scara_drake.engine.faults import first_not_finite, input_not_finite
from scara_drake.engine.graph import Graph, graph_of
from scara_drake.engine.source import buffer_size
from scara_drake.engine.start import Start
from scara_drake.engine.watch import watched
from scara_drake.engine.writer import AT_LIMIT, NEAR, NOT_FINITE
from scara_drake.joints import JOINT_NAMES
from scara_drake.scenario import Scenario

Array = NDArray[np.float64]

ROUNDING = 1e-9  # [s]


class CompiledStepper:
    """A Diagram at t = 0, and what advances it.

    Args:
        diagram: of `make_diagram`.
        scenario: whose diagram it is.
        folder: where compiled functions are kept.

    Raises:
        NotCompilableError: a part of the Diagram can only run in Drake; names it.
    """

    block = 5.0  # [s]; each call of the function looks its kernels up anew

    def __init__(self, diagram: Diagram, scenario: Scenario, folder: Path) -> None:
        graph = graph_of(diagram)
        self._plant, self._context = graph.plant, diagram.CreateDefaultContext()
        self._duration, self._log_period = scenario.duration, scenario.sample_period
        self._period = graph.plant.time_step()
        scene_graph = cast(SceneGraph, diagram.GetSubsystemByName("scene_graph"))
        arm = _arm_of(graph)
        links, surfaces = watched(graph.plant, scene_graph, scenario.environment)
        own = graph.plant.GetMyContextFromRoot(self._context)
        arrays = {
            "arm": arm,
            "work": WORK.zeros(),
            "segments": links,
            "surfaces": surfaces,
            "no_force": np.zeros(JOINTS),
            "state": np.array(graph.plant.GetPositionsAndVelocities(own)),
        }
        self._program = program_of(graph, self._period, arrays, folder)
        self._buffers = self._program.store.views
        self._cursor = np.zeros(2 + len(self._program.source.slow), dtype=np.int64)
        self._stop = np.zeros(2, dtype=np.int64)
        self._tick = 0
        self._last = math.ceil(self._duration / self._period - ROUNDING / self._period)
        self._width = sum(buffer_size(graph, buffer) for buffer in graph.recorded)
        self._times, self._records = np.empty(0), np.empty((0, self._width))

    @property
    def time(self) -> float:
        """How far it is [s]."""
        return min(self._tick * self._period, self._duration)

    def begin(self) -> None:
        """Let all blocks begin with what the others have.

        Raises:
            LeftTheModelError: a link touches a surface from the start.
        """
        if self._buffers["surfaces"].size:
            self._look_for_contact()
        Start(self._program.graph, self._buffers).run()

    def advance_to(self, time: float) -> None:
        """Advance to a time [s].

        Raises:
            LeftTheModelError: a joint is at its limit, or a link touches a surface.
            RuntimeError: NaN or infinity arrives on a port that has to be finite; names the system,
                the port, the time and the entry.
        """
        end = self._last + 1 if time >= self._duration else math.ceil(time / self._period)
        rows = math.ceil((end - self._tick) * self._period / self._log_period) + 2
        self._times, self._records = np.empty(rows), np.empty((rows, self._width))
        self._cursor[0] = 0
        store = self._program.store
        while self._tick < end:
            self._tick = self._program.advance(
                self._tick,
                end - self._tick,
                self._last,
                self._duration,
                self._period,
                self._log_period,
                self._cursor,
                self._stop,
                self._times,
                self._records,
                store.address,
                store.places,
                *self._program.others,
            )
            self._look_why()

    def drain(self) -> tuple[Array, Array]:
        """Return the samples since the last call to `advance_to`: times (n,), values (n, width)."""
        taken, self._cursor[0] = self._cursor[0], 0
        return self._times[:taken], self._records[:taken]

    def _look_why(self) -> None:
        """Find out why the function came back.

        Raises:
            LeftTheModelError: a joint is at its limit, or a link touches a surface.
            RuntimeError: NaN or infinity arrives on a port, or at the plant.
        """
        reason, index = self._stop
        self._stop[:] = 0
        graph, buffers, time = self._program.graph, self._buffers, self._tick * self._period
        if reason == NOT_FINITE:
            name, inputs = self._program.source.guards[index]
            raise RuntimeError(input_not_finite(graph.nodes[name], inputs, buffers, time))
        if reason == AT_LIMIT:
            work = WORK.unpack(buffers["work"])
            if not np.isfinite(work.effort).all():
                raise RuntimeError(first_not_finite(graph, buffers, time))
            joint = JOINT_NAMES[int(work.beyond[()]) - 1]
            raise LeftTheModelError(self.time, f"{joint} is at its limit")
        if reason == NEAR:
            self._look_for_contact()

    def _look_for_contact(self) -> None:
        """Ask Drake whether a link touches a surface.

        Raises:
            LeftTheModelError: one does.
        """
        own = self._plant.GetMyMutableContextFromRoot(self._context)
        self._plant.SetPositions(own, self._buffers["state"][:JOINTS])
        query = self._plant.get_geometry_query_input_port().Eval(own)
        for pair in query.ComputePointPairPenetration():
            frames = (query.inspector().GetFrameId(each) for each in (pair.id_A, pair.id_B))
            bodies = (self._plant.GetBodyFromFrameId(frame).name() for frame in frames)
            what = " touches ".join(sorted(bodies))
            raise LeftTheModelError(self.time, what)


def _arm_of(graph: Graph) -> Array:
    """Return the plant as the array that is stepped.

    Raises:
        NotCompilableError: it is no arm of six joints.
    """
    try:
        return arm_parameters(graph.plant)
    except ValueError as error:
        raise NotCompilableError(str(error)) from None
