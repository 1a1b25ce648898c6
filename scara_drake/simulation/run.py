"""Run a scenario: in blocks, with a journal, pacing, progress and a clean end."""

from __future__ import annotations

import copy
import math
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, runtime_checkable

import xarray as xr
from pydrake.geometry import Meshcat
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram

from scara_drake.common import checks
from scara_drake.common.finite import naming_nan
from scara_drake.diagram import make_diagram
from scara_drake.display.controls import StopButton
from scara_drake.recordings.dataset import to_dataset
from scara_drake.recordings.journal import Journal, read_journal
from scara_drake.recordings.recorder import drain, metadata
from scara_drake.scenario import Scenario
from scara_drake.simulation.interrupt import DeferredInterrupt
from scara_drake.simulation.progress import ProgressLine

# Simulated time between two looks at the log, the Stop button and the clock.
BLOCK = 0.1  # [s]
# A run that is later than this behind the clock starts its pacing afresh, without a sprint.
MAX_LAG = 0.2  # [s]


@runtime_checkable
class Closable(Protocol):
    """A system that holds something beyond the run, such as a device."""

    def close(self) -> None:
        """Let go of it; called once, after the run."""


@dataclass(frozen=True)
class Run:
    """What a run gave, beside its recording."""

    recording: xr.Dataset
    simulated: float  # [s]
    wall: float  # [s]
    interrupted: bool
    late: int  # how often the pacing started afresh

    @property
    def real_time_factor(self) -> float:
        """Simulated seconds per second."""
        return self.simulated / self.wall if self.wall > 0.0 else math.inf


def simulate(
    scenario: Scenario,
    duration: float | None = None,
    q0: Sequence[float] | None = None,
    realtime_rate: float = 0.0,
    meshcat: Meshcat | None = None,
    progress: bool = False,
) -> xr.Dataset:
    """Simulate a scenario and return its recording.

    Args:
        scenario: from `load_scenario`; it is not changed.
        duration: [s], in place of the scenario's.
        q0: posture (6,) at t = 0 [m, rad], in place of the scenario's.
        realtime_rate: 1.0 for real time, 0.0 for as fast as it goes.
        meshcat: draws the run, with a Stop button.
        progress: shows a line with the simulated time and the real-time factor.

    Raises:
        ValueError: a value is out of its bounds.
    """
    scenario = copy.copy(scenario)
    if duration is not None:
        scenario.duration = duration
    if q0 is not None:
        scenario.q0 = [float(q) for q in q0]
    with tempfile.TemporaryDirectory(prefix="scara_drake_") as folder:
        journal = Path(folder) / "run.journal"
        return run(scenario, journal, realtime_rate, meshcat, progress).recording


def run(
    scenario: Scenario,
    journal: Path,
    realtime_rate: float = 0.0,
    meshcat: Meshcat | None = None,
    progress: bool = False,
) -> Run:
    """Simulate a scenario, keeping its samples in a journal; see `simulate`.

    Memory stays flat: the log is moved to the journal after every block. An interrupt (Ctrl-C) and
    the Stop button of the meshcat end the run early and cleanly.

    Raises:
        ValueError: a value is out of its bounds; nothing has been written then.
    """
    checks.number("realtime_rate", realtime_rate, 0.0, 100.0)
    diagram = make_diagram(scenario, meshcat)
    if realtime_rate > 0.0:
        _warm_up(diagram, scenario.time_step)
    simulator = Simulator(diagram)
    simulator.set_target_realtime_rate(realtime_rate)
    description = metadata(diagram)
    width = max(stop for _, stop in description["columns"].values())
    interrupted, late = False, 0
    journal.parent.mkdir(parents=True, exist_ok=True)
    with (
        Journal(journal, description, width) as writer,
        StopButton(meshcat) as stop,
        ProgressLine(scenario.name, scenario.duration, progress) as line,
        DeferredInterrupt() as interrupt,
        _closing(diagram),
        naming_nan(diagram, simulator.get_context()),
    ):
        simulator.Initialize()
        simulator.ResetStatistics()
        start = paced = now = time.perf_counter()
        for edge in _edges(scenario):
            simulator.AdvanceTo(edge)
            writer.append(*drain(diagram, simulator.get_mutable_context()))
            now = time.perf_counter()
            if realtime_rate > 0.0 and (now - paced) - edge / realtime_rate > MAX_LAG:
                simulator.ResetStatistics()
                paced = now - edge / realtime_rate
                late += 1
            line.show(edge, edge / (now - start))
            interrupted = interrupt.pressed or stop.pressed()
            if interrupted:
                break
        wall = now - start
    simulated = simulator.get_context().get_time()
    return Run(to_dataset(*read_journal(journal)), simulated, wall, interrupted, late)


def _edges(scenario: Scenario) -> Sequence[float]:
    """Return the ends of the blocks: between two ticks, so that rounding skips none."""
    ticks = max(1, round(BLOCK / scenario.time_step))
    count = math.ceil(scenario.duration / (ticks * scenario.time_step)) - 1
    edges = [(block * ticks + 0.5) * scenario.time_step for block in range(1, count + 1)]
    return [*edges, scenario.duration]


@contextmanager
def _closing(diagram: Diagram) -> Iterator[None]:
    """Let all systems let go of what they hold at the end, however it comes."""
    with ExitStack() as stack:
        for system in diagram.GetSystems():
            if isinstance(system, Closable):
                stack.callback(system.close)
        yield


def _warm_up(diagram: Diagram, time_step: float) -> None:
    """Run two ticks on a context of their own, so that no compilation stalls the paced run."""
    simulator = Simulator(diagram)
    simulator.AdvanceTo(2.5 * time_step)
