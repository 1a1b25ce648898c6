"""Run a scenario: in blocks, with a journal, pacing, progress and a clean end."""

from __future__ import annotations

import copy
import math
import shutil
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, nullcontext, suppress
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Protocol, runtime_checkable

import xarray as xr
from pydrake.geometry import Meshcat
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram

from scara_drake.common import checks
from scara_drake.common.finite import naming_nan
from scara_drake.diagram import make_diagram
from scara_drake.display.camera import show_whole
from scara_drake.display.controls import OverviewButton, StopButton
from scara_drake.recordings.dataset import BY_DURATION
from scara_drake.recordings.files import load_recording
from scara_drake.recordings.journal import Journal
from scara_drake.recordings.recorder import drain, metadata
from scara_drake.scenario import Scenario
from scara_drake.simulation.interrupt import DeferredInterrupt
from scara_drake.simulation.progress import ProgressLine
from scara_drake.wiring.show import show_robot

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
class Ended:
    """What a run was.

    Attributes:
        simulated: [s].
        wall: [s].
        late: how often the pacing started afresh.
        ended_by: "duration", "interrupt" (Ctrl-C), "stop button", or "signal" and its name.
    """

    simulated: float
    wall: float
    late: int
    ended_by: str

    @property
    def interrupted(self) -> bool:
        """Whether it ended before its time."""
        return self.ended_by != BY_DURATION

    @property
    def real_time_factor(self) -> float:
        """Simulated seconds per second."""
        return self.simulated / self.wall if self.wall > 0.0 else math.inf


@dataclass(frozen=True)
class Run(Ended):
    """What a run was, and its recording."""

    recording: xr.Dataset


def simulate(
    scenario: Scenario,
    duration: float | None = None,
    q0: Sequence[float] | None = None,
    realtime_rate: float = 0.0,
    meshcat: Meshcat | None = None,
    progress: bool = False,
) -> xr.Dataset:
    """Simulate a scenario and return its recording.

    Its attribute `ended_by` says what ended it: "duration", "interrupt" (Ctrl-C) or "stop button".
    If the run fails, what was recorded is kept in a journal, which the error names.

    Drake does not free a Diagram that has systems written in Python: each call leaves about 2 MB in
    the process. A study of thousands of runs should renew its processes, as the search for gains
    does, by ``max_tasks_per_child`` of ``concurrent.futures.ProcessPoolExecutor``.

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
    folder = Path(tempfile.mkdtemp(prefix="scara_drake_"))
    journal = folder / "run.journal"
    try:
        recording = run(scenario, journal, realtime_rate, meshcat, progress).recording
    except BaseException:
        if not journal.exists():  # nothing was recorded
            shutil.rmtree(folder)
        raise
    shutil.rmtree(folder)
    return recording


def run(
    scenario: Scenario,
    journal: Path,
    realtime_rate: float = 0.0,
    meshcat: Meshcat | None = None,
    progress: bool = False,
) -> Run:
    """Simulate a scenario, keeping its samples in a journal, and read that; see `simulate`.

    Raises:
        ValueError: a value is out of its bounds; nothing has been written then.
        OSError: the journal cannot be written.
    """
    with Journal(journal) as writer:
        ended = run_into(writer, scenario, realtime_rate, meshcat, progress)
        return Run(**asdict(ended), recording=load_recording(journal))


def run_into(
    journal: Journal,
    scenario: Scenario,
    realtime_rate: float = 0.0,
    meshcat: Meshcat | None = None,
    progress: bool = False,
    signals: DeferredInterrupt | None = None,
) -> Ended:
    """Simulate a scenario into a journal; see `simulate`.

    Memory stays flat: the log is moved to the journal after every block. An interrupt (Ctrl-C), or
    what else `signals` listens to, and the Stop button of the meshcat end the run early, cleanly.
    If it fails the error has a note that says where what was recorded is kept.

    Raises:
        ValueError: a value is out of its bounds; nothing has been written then.
        OSError: the journal cannot be written.
    """
    checks.number("realtime_rate", realtime_rate, 0.0, 100.0)
    diagram = make_diagram(scenario, meshcat)
    if realtime_rate > 0.0:
        _warm_up(diagram, scenario.time_step)
    simulator = Simulator(diagram)
    simulator.set_target_realtime_rate(realtime_rate)
    description = metadata(diagram)
    journal.begin(description, max(stop for _, stop in description["columns"].values()))
    with (
        StopButton(meshcat) as stop,
        OverviewButton(meshcat, show_whole, partial(show_robot, scenario=scenario)) as overview,
        ProgressLine(scenario.name, scenario.duration, progress) as line,
        nullcontext(signals) if signals else DeferredInterrupt() as interrupt,
        _closing(diagram),
        _failures_in(journal, diagram, simulator),
        naming_nan(diagram, simulator.get_context()),
    ):
        interrupt.raise_if_pressed()
        simulator.Initialize()
        simulator.ResetStatistics()
        start = paced = now = time.perf_counter()
        ended_by, late = BY_DURATION, 0
        for edge in _edges(scenario):
            simulator.AdvanceTo(edge)
            journal.append(*drain(diagram, simulator.get_mutable_context()))
            now = time.perf_counter()
            if realtime_rate > 0.0 and (now - paced) - edge / realtime_rate > MAX_LAG:
                simulator.ResetStatistics()
                paced = now - edge / realtime_rate
                late += 1
            line.show(edge, edge / (now - start))
            overview.follow()
            if edge < scenario.duration and (interrupt.pressed or stop.pressed()):
                ended_by = interrupt.reason() or "stop button"
                break
    simulated = simulator.get_context().get_time()
    journal.end(ended_by, simulated)
    return Ended(simulated, now - start, late, ended_by)


@contextmanager
def _failures_in(journal: Journal, diagram: Diagram, simulator: Simulator) -> Iterator[None]:
    """Write into a journal what made a run fail, and tell the error where the journal is."""
    try:
        yield
    except BaseException as error:
        context = simulator.get_mutable_context()
        reason = " ".join(str(error).split()) or type(error).__name__
        with suppress(OSError):  # the disk may be full: then the journal just ends
            journal.append(*drain(diagram, context))
            if journal.has_samples:
                journal.end(f"error: {reason[:200]}", context.get_time())
        if journal.has_samples:
            error.add_note(f"what was recorded is in {journal.path}")
        raise


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
