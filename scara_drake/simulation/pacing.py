"""How well a run keeps to the clock: the lateness of each tick, overruns, and time given up."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable, Iterable
from typing import Final, NamedTuple, Protocol, runtime_checkable

import numpy as np

from scara_drake.common.pace import Pace

# A run that is later than this gives the time up: its pacing starts afresh, without a sprint.
MAX_LAG: Final = 0.2  # [s]
LATE: Final = 1e-3  # [s], a tick that is later is counted
# Slower than this for so long is an overrun.
OVERRUN_FACTOR: Final = 0.9
OVERRUN_TIME: Final = 1.0  # [s]
# Of the histogram: from its first edge on, in steps, up to where the pacing starts afresh.
FIRST: Final = -5e-3  # [s]
STEP: Final = 1e-5  # [s]
BINS: Final = round((MAX_LAG - FIRST) / STEP)


class Timing(NamedTuple):
    """How well a run kept to the clock.

    The lateness of a tick is the clock less the simulated time once the tick is done; below zero
    it waits for the clock.

    Attributes:
        ticks: how many there were.
        late_ticks: of these, by more than 1 ms.
        p99: lateness that 99 % of the ticks stay below [s].
        p999: the same of 99.9 % [s].
        worst: largest lateness [s].
        overruns: how often the real-time factor was below 0.9 for a second.
        restarts: how often the pacing started afresh, 0.2 s behind.
        given_up: how much time was given up in these restarts [s].
        pictures_dropped: pictures of the scene that were not sent, as the run was behind.
    """

    ticks: int
    late_ticks: int
    p99: float
    p999: float
    worst: float
    overruns: int
    restarts: int
    given_up: float
    pictures_dropped: int

    def notes(self) -> dict[str, str | int | float]:
        """Return the attributes of a recording that tell it."""
        return {
            "ticks": self.ticks,
            "late_ticks": self.late_ticks,
            "lateness_p99": self.p99,
            "lateness_p999": self.p999,
            "lateness_worst": self.worst,
            "overruns": self.overruns,
            "clock_restarts": self.restarts,
            "time_given_up": self.given_up,
            "pictures_dropped": self.pictures_dropped,
        }


class Late(Protocol):
    """What is told how far the simulation is behind the clock [s]."""

    lateness: float


@runtime_checkable
class Clocked(Protocol):
    """A system that reads the clock, if it has one, and how late the run is beside it."""

    clock: Late | None


@runtime_checkable
class Paced(Protocol):
    """A system that looks at how the run keeps to the clock."""

    pace: Pace


class Pacing:
    """Follows a run in real time by the clock; it computes nothing that the run does.

    Args:
        rate: simulated seconds per second.
        time_step: of a tick [s].
        clocks: are told the lateness at each tick, zero where the run waits for the clock.
        paces: are told it too, below zero then, and the rest of it ten times a second.
        now: the clock [s].

    Attributes:
        rate: simulated seconds per second.
    """

    def __init__(
        self,
        rate: float,
        time_step: float,
        clocks: Iterable[Late] = (),
        paces: Iterable[Pace] = (),
        now: Callable[[], float] = time.perf_counter,
    ) -> None:
        self.rate = rate
        self._per_second, self._per_tick, self._now = 1.0 / rate, 1.0 / time_step, now
        self._paces = tuple(paces)
        self._clocks = tuple(clocks)
        self._counts = [0] * BINS  # a list: its entries are counted up faster than an array's
        self._last, self._worst = 0, -math.inf
        self._restarts, self._given_up = 0, 0.0
        self._overruns, self._running_over = 0, False
        self.begin()

    def begin(self, simulated: float = 0.0) -> None:
        """Begin to pace at a simulated time [s]."""
        now = self._now()
        self._origin = now - simulated * self._per_second
        self._seen = deque([(now, simulated)])

    def tick(self, simulated: float) -> bool:
        """Count a tick that is done, at a simulated time [s]; what is no whole tick is not counted.

        Returns:
            Whether the run is so late that its pacing has started afresh.
        """
        lateness = self._now() - self._origin - simulated * self._per_second
        for clock in self._clocks:
            clock.lateness = lateness if lateness > 0.0 else 0.0
        for pace in self._paces:
            pace.lateness = lateness
        tick = int(simulated * self._per_tick + 1e-6)
        if tick != self._last:
            self._last = tick
            place = int((lateness - FIRST) / STEP)
            self._counts[0 if place < 0 else place if place < BINS else BINS - 1] += 1
            if lateness > self._worst:
                self._worst = lateness
        if lateness <= MAX_LAG:
            return False
        self._restarts += 1
        self._given_up += lateness
        self._origin += lateness
        return True

    def look(self, simulated: float) -> None:
        """Look back on the last second, at a simulated time [s]: was it too slow?"""
        now = self._now()
        self._seen.append((now, simulated))
        if self._paces:
            so_far = self.timing()
            for pace in self._paces:
                pace.late_ticks, pace.p99 = so_far.late_ticks, so_far.p99
        while len(self._seen) > 2 and now - self._seen[1][0] >= OVERRUN_TIME:
            self._seen.popleft()
        wall = now - self._seen[0][0]
        if wall < OVERRUN_TIME:
            return
        factor = (simulated - self._seen[0][1]) / wall
        for pace in self._paces:
            pace.factor = factor
        over = factor * self._per_second < OVERRUN_FACTOR
        self._overruns += over and not self._running_over
        self._running_over = over

    def timing(self) -> Timing:
        """Return how well the run has kept to the clock so far."""
        counts = np.cumsum(self._counts)
        ticks = int(counts[-1])
        late = ticks - int(counts[round((LATE - FIRST) / STEP) - 1])
        worst = self._worst if ticks else 0.0

        def quantile(share: float) -> float:
            place = int(np.searchsorted(counts, share * ticks))
            return min(FIRST + (place + 1) * STEP, worst)

        return Timing(
            ticks=ticks,
            late_ticks=late,
            p99=quantile(0.99),
            p999=quantile(0.999),
            worst=worst,
            overruns=self._overruns,
            restarts=self._restarts,
            given_up=self._given_up,
            pictures_dropped=sum(pace.pictures_dropped for pace in self._paces),
        )
