"""How long a channel delays: laws of time."""

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scara_drake.channel.signal_delay import LINES, SINE, STEPS, SignalDelay, delay_at
from scara_drake.common import checks

Array = NDArray[np.float64]

LONGEST = 60.0  # [s]; a ring of it is copied at every tick, so this is a bound against slips


class DelayLaw:
    """A delay that varies with time; the base of those below."""

    def validate(self, name: str) -> None:
        """Check the fields; `name` is the path in the scenario."""
        raise NotImplementedError

    def maximum(self) -> float:
        """Longest delay [s]."""
        raise NotImplementedError

    def parameters(self) -> Array:
        """Return the law (n,) as `delay_at` takes it."""
        raise NotImplementedError

    def at(self, t: float) -> float:
        """Delay [s] at time t [s]."""
        return float(delay_at(self.parameters(), t))

    def make_system(self, initial: ArrayLike, period: float, seed: int = 0) -> SignalDelay:
        """Return the delay of a signal that starts from `initial` (n,); it takes no seed."""
        return SignalDelay(self, initial, period)


@dataclass
class ConstantDelay(DelayLaw):
    """The same delay at all times."""

    delay: float = 0.0  # [s]

    def validate(self, name: str) -> None:
        """Check the delay.

        Raises:
            ValueError: the delay is negative or not finite.
        """
        checks.number(f"{name}.delay", self.delay, 0.0, LONGEST)

    def maximum(self) -> float:
        """Longest delay [s]."""
        return self.delay

    def parameters(self) -> Array:
        """Return the law as `delay_at` takes it."""
        return np.array([SINE, self.delay, 0.0, 0.0, 0.0])


@dataclass
class SineDelay(DelayLaw):
    """amplitude sin(frequency t + phase) + offset, and zero where that is negative.

    The default is the paper's 0.2 sin t. A delay of 0 to 2 s is amplitude 1, offset 1; a cosine has
    the phase pi / 2.
    """

    amplitude: float = 0.2  # [s]
    offset: float = 0.0  # [s]
    frequency: float = 1.0  # [rad/s]
    phase: float = 0.0  # [rad]

    def validate(self, name: str) -> None:
        """Check the fields.

        Raises:
            ValueError: amplitude or frequency is negative, or a field is out of its bounds.
        """
        checks.number(f"{name}.amplitude", self.amplitude, 0.0, LONGEST)
        checks.number(f"{name}.offset", self.offset, -LONGEST, LONGEST)
        checks.number(f"{name}.frequency", self.frequency, 0.0, 1e3)
        checks.number(f"{name}.phase", self.phase, -2.0 * math.pi, 2.0 * math.pi)

    def maximum(self) -> float:
        """Longest delay [s]."""
        return max(self.amplitude + self.offset, 0.0)

    def parameters(self) -> Array:
        """Return the law as `delay_at` takes it."""
        return np.array([SINE, self.offset, self.amplitude, self.frequency, self.phase])


@dataclass
class StepDelay(DelayLaw):
    """A delay that changes at given times and stays until the next; the first also before.

    Attributes:
        times: of the changes, rising [s].
        delays: from each of them on [s].
    """

    times: list[float] = field(default_factory=lambda: [0.0])
    delays: list[float] = field(default_factory=lambda: [0.0])

    def validate(self, name: str) -> None:
        """Check the table.

        Raises:
            ValueError: the lists differ in length, the times do not rise, or a delay is negative.
        """
        _check_table(name, self.times, self.delays)

    def maximum(self) -> float:
        """Longest delay [s]."""
        return max(self.delays)

    def parameters(self) -> Array:
        """Return the law as `delay_at` takes it."""
        return np.array([STEPS, *self.times, *self.delays], dtype=np.float64)


@dataclass
class TableDelay(StepDelay):
    """A delay on straight lines between given points, such as a measured one; constant outside.

    Attributes:
        times: of the points, rising [s].
        delays: at the points [s].
    """

    def parameters(self) -> Array:
        """Return the law as `delay_at` takes it."""
        return np.array([LINES, *self.times, *self.delays], dtype=np.float64)


def _check_table(name: str, times: list[float], delays: list[float]) -> None:
    if not times:
        raise ValueError(f"{name}.times: no entries, allowed 1 or more")
    checks.vector(f"{name}.times", times, len(times))
    checks.vector(f"{name}.delays", delays, len(times), 0.0, LONGEST)
    for index in range(1, len(times)):
        if times[index] <= times[index - 1]:
            raise ValueError(
                f"{name}.times[{index}]: {times[index]}, allowed above {times[index - 1]}"
            )
