"""What a hand wants: to go from rest to rest, and to sweep a range of frequencies."""

import math
from dataclasses import asdict, dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common import checks
from scara_drake.common.fields import number
from scara_drake.common.layout import REST, Layout
from scara_drake.common.motion import minimum_jerk

Array = NDArray[np.float64]


@dataclass
class Sweep:
    """A sine on one axis of the hand's target whose frequency rises exponentially.

    It fades in and out over a tenth of its duration. Equal frequencies make a plain sine.

    Attributes:
        axis: 0, 1 or 2: x, y, z.
        amplitude: zero is no sweep.
        low: frequency at the start.
        high: frequency at the end, not below `low`.
        start: of the sweep.
        duration: of the sweep.
    """

    axis: int = 1
    amplitude: float = number(0.0, "m", 0.0, 1.0)
    low: float = number(0.1, "Hz", 1e-3, 100.0)
    high: float = number(10.0, "Hz", 1e-3, 100.0)
    start: float = number(0.0, "s", 0.0)
    duration: float = number(30.0, "s", 1e-2)

    def check_together(self, name: str) -> None:
        """Check the axis, and that the frequency does not fall.

        Raises:
            ValueError: no such axis, or a frequency that falls.
        """
        checks.choice(f"{name}.axis", str(self.axis), ("0", "1", "2"))
        checks.number(f"{name}.high", self.high, self.low, 100.0)

    def parameters(self) -> Array:
        """Return the sweep as `sweep_of` reads it."""
        return SWEEP.pack(**asdict(self))


class SweepRow(NamedTuple):
    """`Sweep` in a kernel."""

    axis: float
    amplitude: float
    low: float
    high: float
    start: float
    duration: float


class Waypoint(NamedTuple):
    """Where the hand's target rests.

    Attributes:
        time: at which it gets there [s].
        place: (3,) [m].
    """

    time: float
    place: Array


class HandPath(NamedTuple):
    """Where the hand wants to be over the time.

    Attributes:
        sweep: of `Sweep.parameters`.
        waypoints: rows (n, 4) of `Waypoint`, flat.
    """

    sweep: Array
    waypoints: Array


SWEEP = Layout(SweepRow)
WAYPOINT = Layout(Waypoint, place=3)
HAND_PATH = Layout(HandPath, sweep=SWEEP.size, waypoints=REST)
sweep_of = SWEEP.reader()
hand_path_of = HAND_PATH.reader()
waypoint_of = WAYPOINT.reader()


@njit(cache=True)
def hand_target_at(t: float, waypoints: Array, sweep: Array, target: Array) -> None:
    """Write where the hand wants to be (3,) [m] at time t [s].

    Args:
        t: [s].
        waypoints: rows (n, 4), as `waypoint_of` reads them, the first before t = 0; from each to
            the next the motion is minimum jerk, at rest at both.
        sweep: of `Sweep.parameters`.
        target: written.
    """
    rows = waypoints.shape[0]
    after = 0
    while after < rows and waypoint_of(waypoints[after]).time <= t:
        after += 1
    last = waypoint_of(waypoints[max(after - 1, 0)])
    target[:] = last.place
    if 0 < after < rows:
        following = waypoint_of(waypoints[after])
        start = max(last.time, 0.0)
        move = minimum_jerk(max(t - start, 0.0) / (following.time - start))
        for i in range(3):
            target[i] += move * (following.place[i] - last.place[i])
    s = sweep_of(sweep)
    age = t - s.start
    if s.amplitude > 0.0 and 0.0 < age < s.duration:
        rate = math.log(s.high / s.low) / s.duration
        cycles = s.low * (math.expm1(rate * age) / rate if rate > 0.0 else age)
        fade = min(10.0 * min(age, s.duration - age) / s.duration, 1.0)
        fade = fade * fade * (3.0 - 2.0 * fade)
        target[int(s.axis)] += s.amplitude * fade * math.sin(2.0 * math.pi * cycles)
