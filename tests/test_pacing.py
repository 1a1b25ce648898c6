"""The lateness of ticks on clocks that a test turns, and what becomes of it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem
from strategies import examples

import scara_drake as sd
from scara_drake.cli.summary import timing_words
from scara_drake.common.pace import Pace
from scara_drake.operator.devices.clock import WallClock
from scara_drake.recordings.journal import Journal, survey
from scara_drake.simulation.pacing import BINS, FIRST, MAX_LAG, STEP, Pacing
from scara_drake.simulation.steppers import DrakeStepper

TICK = 1e-3  # [s]


class Turned:
    """A clock that shows what it is set to [s]."""

    def __init__(self) -> None:
        self.time = 100.0

    def __call__(self) -> float:
        return self.time


def paced(lateness: list[float], rate: float = 1.0, clock: WallClock | None = None) -> Pacing:
    """Ticks that are done so late after their time [s], each below the limit of the pacing."""
    now = Turned()
    pacing = Pacing(rate, TICK, [clock] if clock else [], now=now)
    for index, late in enumerate(lateness, 1):
        now.time = 100.0 + index * TICK / rate + late
        assert not pacing.tick(index * TICK)
    return pacing


@given(
    st.lists(st.floats(FIRST, MAX_LAG - 1e-6), min_size=1, max_size=300),
    st.sampled_from([0.5, 1.0, 4.0]),
)
@examples(100)
def test_quantiles_are_those_of_the_ticks_to_a_step_of_the_histogram(
    lateness: list[float], rate: float
) -> None:
    timing = paced(lateness, rate).timing()
    assert timing.ticks == len(lateness)
    np.testing.assert_allclose(timing.worst, max(lateness), atol=1e-9)
    for share, told in ((0.99, timing.p99), (0.999, timing.p999)):
        true = np.quantile(lateness, share, method="inverted_cdf")
        assert true - 1e-9 <= told <= true + STEP + 1e-9
    surely = sum(late > 1e-3 + STEP for late in lateness)
    perhaps = sum(late > 1e-3 - STEP for late in lateness)
    assert surely <= timing.late_ticks <= perhaps


def test_what_is_below_or_beyond_the_histogram_is_counted_at_its_ends() -> None:
    timing = paced([-1.0, -0.5, MAX_LAG - 1e-9]).timing()
    assert timing.ticks == 3
    assert timing.late_ticks == 1
    assert timing.worst == pytest.approx(MAX_LAG)
    assert timing.p99 <= FIRST + BINS * STEP


def test_a_step_that_ends_between_ticks_counts_for_no_tick() -> None:
    pacing = Pacing(1.0, TICK, now=Turned())
    for time in (1.0, 1.5, 2.0, 2.2, 2.9, 3.0):
        pacing.tick(time * TICK)
    assert pacing.timing().ticks == 3


def test_the_systems_that_look_at_the_clock_see_how_late_the_run_is() -> None:
    clock, pace, now = WallClock(), Pace(), Turned()
    pacing = Pacing(1.0, TICK, [clock], [pace], now)
    for tick, late in enumerate((0.0, 2e-3, 3e-3, -4e-4), 1):
        now.time = 100.0 + tick * TICK + late
        pacing.tick(tick * TICK)
        assert clock.lateness == pytest.approx(max(late, 0.0), abs=1e-9)
        assert pace.lateness == pytest.approx(late)
    pacing.look(4 * TICK)
    assert pace.late_ticks == 2
    assert pace.p99 == pytest.approx(3e-3, abs=STEP)
    pace.pictures_dropped = 5
    assert pacing.timing().pictures_dropped == 5


def test_after_a_stall_the_time_is_given_up_and_counted() -> None:
    now = Turned()
    pacing = Pacing(1.0, TICK, now=now)
    now.time += 0.5
    assert pacing.tick(TICK)
    now.time += TICK
    assert not pacing.tick(2 * TICK)
    timing = pacing.timing()
    assert timing.restarts == 1
    assert timing.given_up == pytest.approx(0.5 - TICK)
    assert timing.late_ticks == 1


@pytest.mark.parametrize(("speed", "overruns"), [(1.0, 0), (0.95, 0), (0.85, 1), (0.1, 1)])
def test_an_overrun_is_a_second_below_nine_tenths(speed: float, overruns: int) -> None:
    now, pace = Turned(), Pace()
    pacing = Pacing(1.0, TICK, (), [pace], now)
    for look in range(1, 40):
        now.time = 100.0 + 0.1 * look
        pacing.look(0.1 * look * speed)
    assert pacing.timing().overruns == overruns
    assert pace.factor == pytest.approx(speed)


def test_overruns_are_counted_once_each() -> None:
    now = Turned()
    pacing = Pacing(1.0, TICK, now=now)
    simulated = 0.0
    for speed in [1.0] * 20 + [0.5] * 20 + [1.0] * 20 + [0.5] * 20:
        now.time += 0.1
        simulated += 0.1 * speed
        pacing.look(simulated)
    assert pacing.timing().overruns == 2


def test_half_a_second_of_half_speed_is_no_overrun_where_the_second_makes_it_good() -> None:
    now = Turned()
    pacing = Pacing(1.0, TICK, now=now)
    for look, simulated in enumerate([0.05, 0.1, 0.2, 0.4, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1], 1):
        now.time = 100.0 + 0.1 * look
        pacing.look(simulated)
    assert pacing.timing().overruns == 0


class Ticking(LeafSystem):
    """Runs a function a thousand times a second."""

    def __init__(self, tick: Callable[[float], None]) -> None:
        super().__init__()
        self.DeclarePeriodicPublishEvent(TICK, 0.0, lambda context: tick(context.get_time()))


def ticking(tick: Callable[[float], None]) -> Diagram:
    builder = DiagramBuilder()
    builder.AddSystem(Ticking(tick))
    return builder.Build()


def test_drake_tells_of_each_tick_and_does_not_sprint_after_a_stall() -> None:
    """Beside the stall the clock goes as the simulation does: no time of the machine counts."""
    now, stalls = Turned(), {50: 0.3, 120: 0.1}

    def tick(time: float) -> None:
        now.time += TICK + stalls.get(round(time / TICK), 0.0)

    pacing = Pacing(1.0, TICK, now=now)
    pacing.rate = 0.0  # Drake itself waits for nothing
    stepper = DrakeStepper(ticking(tick), pacing)
    stepper.begin()
    stepper.advance_to(0.2005)
    timing = pacing.timing()
    assert timing.ticks == 200
    assert timing.restarts == 1
    assert timing.given_up == pytest.approx(0.3, abs=2 * TICK)
    assert timing.late_ticks == 1 + 81  # the shorter stall is made up, or would be by a faster run
    steps = stepper._simulator.get_num_steps_taken()  # since Drake's own pacing began afresh
    assert 149 <= steps <= 152


def test_a_run_in_real_time_says_and_records_how_it_kept_to_the_clock(tmp_path) -> None:
    scenario = sd.load_scenario("joint_sine", {"duration": 0.2})
    recording = sd.simulate(scenario, realtime_rate=2.0)
    assert recording.attrs["ticks"] == 200
    assert 0 <= recording.attrs["late_ticks"] <= 200
    assert recording.attrs["lateness_p99"] <= recording.attrs["lateness_worst"]
    assert "ticks" not in sd.simulate(scenario).attrs


def test_a_journal_keeps_what_is_known_at_the_end_only(tmp_path) -> None:
    with Journal(tmp_path / "run.journal") as journal:
        journal.begin({"notes": {"device": "fake"}}, 1)
        journal.append(np.zeros(1), np.zeros((1, 1)))
        journal.end("duration", 1.0, {"ticks": 7})
        assert survey(journal.path).description["notes"] == {"device": "fake", "ticks": 7}


def test_the_summary_says_what_was_late() -> None:
    good = paced([-5e-4] * 2000).timing()
    assert timing_words(good).startswith("In real time: 0 of 2000 ticks more than 1 ms late; p99 -")
    bad = good._replace(overruns=2, restarts=3, given_up=1.5, pictures_dropped=4)
    words = timing_words(bad)
    assert words.startswith("Not in real time: ")
    for told in ("2 times slower than 0.9", "1.50 s given up in 3 stalls", "4 pictures"):
        assert told in words
