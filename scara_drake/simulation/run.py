"""Run a scenario: what builds it, chooses its engine, and ends it cleanly."""

from __future__ import annotations

import copy
import logging
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, nullcontext, suppress
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Protocol, runtime_checkable

import xarray as xr
from pydrake.geometry import Meshcat
from pydrake.systems.framework import Diagram

from scara_drake.common import checks
from scara_drake.diagram import make_diagram
from scara_drake.display.camera import show_whole
from scara_drake.display.cell import scene_of_run
from scara_drake.display.controls import OverviewButton, StopButton
from scara_drake.engine.errors import LeftTheModelError, NotCompilableError
from scara_drake.metrics.scores import score_attributes
from scara_drake.recordings.black_box import BlackBox
from scara_drake.recordings.recorder import metadata
from scara_drake.recordings.samples import Keeper, Samples
from scara_drake.scenario import Scenario
from scara_drake.simulation.advance import Ended, Watch, advance
from scara_drake.simulation.interrupt import DeferredInterrupt
from scara_drake.simulation.kernels import compile_kernels
from scara_drake.simulation.pacing import Clocked, Paced, Pacing
from scara_drake.simulation.priority import real_time_priority, undisturbed
from scara_drake.simulation.progress import ProgressLine
from scara_drake.simulation.steppers import (
    AUTO,
    COMPILED,
    DRAKE,
    ENGINES,
    DrakeStepper,
    compiled_stepper,
)
from scara_drake.wiring.show import Watching, show_robot


@runtime_checkable
class Closable(Protocol):
    """A system that holds something beyond the run, such as a device."""

    def close(self) -> None:
        """Let go of it; called once, after the run."""


@dataclass(frozen=True, kw_only=True)
class Run(Ended):
    """What a run was, and its recording."""

    recording: xr.Dataset


@dataclass(frozen=True)
class Live:
    """What makes a run more than a computation.

    Attributes:
        realtime_rate: 1.0 for real time, 0.0 for as fast as it goes.
        priority: a run in real time asks the system for priority, and says what it has got.
        meshcat: draws the run, with a Stop button.
        station: looks at it too.
    """

    realtime_rate: float = 0.0
    priority: bool = False
    meshcat: Meshcat | None = None
    station: Watching | None = None

    @property
    def seen(self) -> bool:
        """Whether somebody looks at the run while it goes on."""
        watched = self.meshcat is not None or self.station is not None
        return watched or self.realtime_rate > 0.0


def simulate(
    scenario: Scenario,
    duration: float | None = None,
    q0: Sequence[float] | None = None,
    realtime_rate: float = 0.0,
    meshcat: Meshcat | bool | None = None,
    progress: bool = False,
    engine: str = AUTO,
) -> xr.Dataset:
    """Simulate a scenario and return its recording.

    Its attribute `ended_by` says what ended it: "duration", "interrupt" (Ctrl-C) or "stop button",
    and `engine` what ran it: "compiled" or "drake", for a reason that `engine_reason` tells.
    If the run fails, what was recorded is kept in a journal, which the error names.

    Args:
        scenario: from `load_scenario`; it is not changed.
        duration: [s], in place of the scenario's.
        q0: posture (6,) at t = 0 [m, rad], in place of the scenario's.
        realtime_rate: 1.0 for real time, 0.0 for as fast as it goes.
        meshcat: draws the run, with a Stop button; True opens a scene for it, in a notebook in the
            cell, where it stays to be played again, elsewhere at an address that is printed.
        progress: shows a line with the simulated time and the real-time factor.
        engine: "compiled" runs the Diagram as one compiled function; "drake" by Drake's Simulator;
            "auto" compiles what can be, and takes Drake for the rest, for what meets a joint limit
            or touches a surface with another link than the tool, and for what is drawn or paced.

    Raises:
        ValueError: a value is out of its bounds, or a part of the Diagram cannot be compiled.
        LeftTheModelError: the compiled run met what only Drake computes; it tells when.
    """
    scenario = copy.copy(scenario)
    if duration is not None:
        scenario.duration = duration
    if q0 is not None:
        scenario.q0 = [float(q) for q in q0]
    samples = Samples()
    try:
        with scene_of_run(meshcat) as scene:
            live = Live(realtime_rate, meshcat=scene)
            run_into(samples, scenario, live, progress, engine=engine)
    except BaseException as error:
        with suppress(OSError):  # the disk may be full: then nothing is kept
            if samples.has_samples:
                journal = Path(tempfile.mkdtemp(prefix="scara_drake_")) / "run.journal"
                samples.write(journal)
                error.add_note(f"what was recorded is in {journal}")
        raise
    return scored(samples)


def run(scenario: Scenario, engine: str = AUTO) -> Run:
    """Simulate a scenario, and say what the run was; of one that fails nothing is kept.

    Raises:
        ValueError, RuntimeError: as `simulate`.
    """
    samples = Samples()
    ended = run_into(samples, scenario, engine=engine)
    return Run(**asdict(ended), recording=scored(samples))


def scored(samples: Samples) -> xr.Dataset:
    """Return the recording of samples, with the score of its task where it has one."""
    recording = samples.recording()
    recording.attrs |= score_attributes(recording)
    return recording


def run_into(
    keeper: Keeper,
    scenario: Scenario,
    live: Live | None = None,
    progress: bool = False,
    signals: DeferredInterrupt | None = None,
    engine: str = AUTO,
) -> Ended:
    """Simulate a scenario into what keeps its samples; see `simulate`.

    With a journal memory stays flat: the samples are moved there after every block. An interrupt
    (Ctrl-C), or what else `signals` listens to, and the Stop button of the meshcat end the run
    early, cleanly. If it fails the error has a note that names the file where what was recorded is
    kept.

    Raises:
        ValueError: a value is out of its bounds; nothing has been kept then.
        OSError: the journal cannot be written.
    """
    live, keeper = live or Live(), with_black_box(keeper, scenario)
    rate, meshcat = live.realtime_rate, live.meshcat
    checks.number("realtime_rate", rate, 0.0, 100.0)
    check_engine(engine, live.seen)
    diagram = make_diagram(scenario, meshcat, live.station)
    if rate > 0.0:
        compile_kernels(scenario)  # none of them shall stall the run
    with (
        StopButton(meshcat) as stop,
        OverviewButton(meshcat, show_whole, partial(show_robot, scenario=scenario)) as overview,
        ProgressLine(scenario.name, scenario.duration, progress, rate > 0.0) as line,
        nullcontext(signals) if signals else DeferredInterrupt() as interrupt,
        _closing(diagram),
    ):
        watch, reason = Watch(interrupt, stop, overview, line), ""
        if engine != DRAKE and not live.seen:
            try:
                compiled = compiled_stepper(diagram, scenario)
                begin(keeper, diagram, COMPILED)
                return replace(advance(keeper, compiled, scenario, watch), engine=COMPILED)
            except (NotCompilableError, LeftTheModelError) as error:
                if engine == COMPILED:
                    raise
                reason = str(error)
        begin(keeper, diagram, DRAKE, reason)
        pacing = _pacing(diagram, scenario, rate)
        drake = DrakeStepper(diagram, pacing)
        with _before_others(pacing, live.priority):
            ended = advance(keeper, drake, scenario, watch, pacing)
        return replace(ended, engine=DRAKE, engine_reason=reason)


def with_black_box(keeper: Keeper, scenario: Scenario) -> Keeper:
    """Return what also keeps the seconds before each fault of a supervised run."""
    live = getattr(scenario.operator, "is_live", False)  # and has a supervisor in any case
    if (scenario.supervision is None and not live) or isinstance(keeper, BlackBox):
        return keeper
    return BlackBox(keeper, scenario.logging.period)


def check_engine(engine: str, seen: bool) -> None:
    """Check what is to run a Diagram, which somebody watches or not.

    Raises:
        ValueError: there is no such engine, or it cannot draw a run or keep it in real time.
    """
    checks.choice("engine", engine, ENGINES)
    if engine == COMPILED and seen:
        raise ValueError("engine: 'compiled', allowed auto, drake where a run is drawn or paced")


def begin(keeper: Keeper, diagram: Diagram, engine: str, reason: str = "") -> None:
    """Begin to keep samples, anew if that has begun: what is said of the run, and what runs it."""
    description = metadata(diagram)
    notes = {"engine": engine, "engine_reason": reason}
    description["notes"] |= {name: value for name, value in notes.items() if value}
    keeper.begin(description, max(stop for _, stop in description["columns"].values()))


def _pacing(diagram: Diagram, scenario: Scenario, rate: float) -> Pacing | None:
    """Return what paces a run, if it is paced; it tells all systems that look at the clock."""
    if rate <= 0.0:
        return None
    systems = diagram.GetSystems()
    clocks = [system.clock for system in systems if isinstance(system, Clocked) and system.clock]
    paces = [system.pace for system in systems if isinstance(system, Paced)]
    return Pacing(rate, scenario.time_step, clocks, paces)


@contextmanager
def _before_others(pacing: Pacing | None, priority: bool) -> Iterator[None]:
    """Keep a run in real time from being disturbed, by Python and, if wanted, by other programs."""
    if pacing is None:
        yield
    elif not priority:
        with undisturbed():
            yield
    else:
        with undisturbed(), real_time_priority() as got:
            logging.getLogger(__name__).info("Runs with %s", got)
            yield


@contextmanager
def _closing(diagram: Diagram) -> Iterator[None]:
    """Let all systems let go of what they hold at the end, however it comes."""
    with ExitStack() as stack:
        for system in diagram.GetSystems():
            if isinstance(system, Closable):
                stack.callback(system.close)
        yield
