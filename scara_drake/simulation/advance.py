"""Advances a run in blocks: journal, pacing, what may end it, what is shown of it."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass

from scara_drake.display.controls import OverviewButton, StopButton
from scara_drake.recordings.dataset import BY_DURATION
from scara_drake.recordings.samples import Keeper
from scara_drake.scenario import Scenario
from scara_drake.simulation.interrupt import DeferredInterrupt
from scara_drake.simulation.pacing import Pacing, Timing
from scara_drake.simulation.progress import ProgressLine
from scara_drake.simulation.steppers import Stepper


@dataclass(frozen=True)
class Ended:
    """What a run was.

    Attributes:
        simulated: [s].
        wall: [s].
        ended_by: "duration", "interrupt" (Ctrl-C), "stop button", or "signal" and its name.
        engine: what ran it, "compiled" or "drake".
        engine_reason: why not what was asked for first; "" if it was.
        timing: how well it kept to the clock, if it was to.
    """

    simulated: float
    wall: float
    ended_by: str
    engine: str = ""
    engine_reason: str = ""
    timing: Timing | None = None

    @property
    def interrupted(self) -> bool:
        """Whether it ended before its time."""
        return self.ended_by != BY_DURATION

    @property
    def real_time_factor(self) -> float:
        """Simulated seconds per second."""
        return self.simulated / self.wall if self.wall > 0.0 else math.inf


@dataclass(frozen=True)
class Watch:
    """What may end a run before its time, and what is shown of it."""

    interrupt: DeferredInterrupt
    stop: StopButton
    overview: OverviewButton
    line: ProgressLine

    def why_end(self) -> str:
        """Return who wants the run to end; "" for nobody."""
        if self.interrupt.pressed:
            return self.interrupt.reason()
        return "stop button" if self.stop.pressed() else ""


def advance(
    keeper: Keeper,
    stepper: Stepper,
    scenario: Scenario,
    watch: Watch,
    pacing: Pacing | None = None,
) -> Ended:
    """Advance a run to its end, its samples into a keeper that has begun.

    A pacing is that of the stepper; what it has measured is kept with the samples.

    If it fails the error has a note that names the file where what was recorded is kept.

    Raises:
        OSError: the file cannot be written.
    """
    with _failures_in(keeper, stepper):
        watch.interrupt.raise_if_pressed()
        stepper.begin()
        start = now = time.perf_counter()
        ended_by = BY_DURATION
        for edge in _edges(scenario, stepper.block):
            stepper.advance_to(edge)
            keeper.append(*stepper.drain())
            now = time.perf_counter()
            if pacing is not None:
                pacing.look(edge)
            watch.line.show(edge, edge / (now - start))
            watch.overview.follow()
            if edge < scenario.duration and (why := watch.why_end()):
                ended_by = why
                break
    timing = None if pacing is None else pacing.timing()
    keeper.end(ended_by, stepper.time, {} if timing is None else timing.notes())
    return Ended(stepper.time, now - start, ended_by, timing=timing)


@contextmanager
def _failures_in(keeper: Keeper, stepper: Stepper) -> Iterator[None]:
    """Keep what made a run fail, and tell the error in which file it is."""
    try:
        yield
    except BaseException as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        with suppress(OSError):  # the disk may be full: then the journal just ends
            keeper.append(*stepper.drain())
            if keeper.has_samples:
                keeper.end(f"error: {reason[:200]}", stepper.time)
        if keeper.has_samples and keeper.path is not None:
            error.add_note(f"what was recorded is in {keeper.path}")
        raise


def _edges(scenario: Scenario, block: float) -> Sequence[float]:
    """Return the ends of blocks [s]: between two ticks, so that rounding skips none."""
    ticks = max(1, round(block / scenario.time_step))
    count = math.ceil(scenario.duration / (ticks * scenario.time_step)) - 1
    edges = [(index * ticks + 0.5) * scenario.time_step for index in range(1, count + 1)]
    return [*edges, scenario.duration]
