"""How long a channel delays: laws of time, each a part of a scenario."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scara_drake.channel.laws import LINES, SINE, SINE_LAW, STEPS, TABLE_LAW, delay_at
from scara_drake.channel.signal_delay import SignalDelay
from scara_drake.common.fields import number, vector

Array = NDArray[np.float64]

LONGEST = 60.0  # [s]; a bound against slips


class Delay:
    """A delay that varies with time; the base of those below."""

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
class ConstantDelay(Delay):
    """The same delay at all times.

    Attributes:
        delay: of every signal.
    """

    delay: float = number(0.0, "s", 0.0, LONGEST)

    def maximum(self) -> float:
        """Longest delay [s]."""
        return self.delay

    def parameters(self) -> Array:
        """Return the law as `delay_at` takes it: a sine without amplitude."""
        return SINE_LAW.zeros(kind=SINE, offset=self.delay)


@dataclass
class SineDelay(Delay):
    r"""A sine of time, and zero where that is negative.

    .. math::

        \tau(t) = \max(0,\; \text{offset}
        + \text{amplitude} \cdot \sin(\text{frequency} \cdot t + \text{phase}))

    The default is the paper's :math:`0.2 \sin t`. A delay of 0 to 2 s is amplitude 1, offset 1; a
    cosine has the phase pi / 2.

    Attributes:
        amplitude: of the sine.
        offset: mean of the sine, before it is cut.
        frequency: of the sine.
        phase: at t = 0.
    """

    amplitude: float = number(0.2, "s", 0.0, LONGEST)
    offset: float = number(0.0, "s", -LONGEST, LONGEST)
    frequency: float = number(1.0, "rad/s", 0.0, 1e3)
    phase: float = number(0.0, "rad", -2.0 * math.pi, 2.0 * math.pi)

    def maximum(self) -> float:
        """Longest delay [s]."""
        return max(self.amplitude + self.offset, 0.0)

    def parameters(self) -> Array:
        """Return the law as `delay_at` takes it."""
        return SINE_LAW.pack(
            kind=SINE,
            offset=self.offset,
            amplitude=self.amplitude,
            frequency=self.frequency,
            phase=self.phase,
        )


@dataclass
class StepDelay(Delay):
    """A delay that changes at given times and stays until the next; the first also before.

    Attributes:
        times: of the changes, rising.
        delays: from each of them on.
    """

    times: list[float] = vector([0.0], "s", size=None)
    delays: list[float] = vector([0.0], "s", 0.0, LONGEST, size=None)

    def check_together(self, name: str) -> None:
        """Check that the table is one.

        Raises:
            ValueError: it is empty, the lists differ in length, or the times do not rise.
        """
        times, delays = self.times, self.delays
        if not times:
            raise ValueError(f"{name}.times: no entries, allowed 1 or more")
        if len(delays) != len(times):
            raise ValueError(f"{name}.delays: {len(delays)} entries, allowed {len(times)}")
        for index in range(1, len(times)):
            if times[index] <= times[index - 1]:
                raise ValueError(
                    f"{name}.times[{index}]: {times[index]}, allowed above {times[index - 1]}"
                )

    def maximum(self) -> float:
        """Longest delay [s]."""
        return max(self.delays)

    def parameters(self) -> Array:
        """Return the law as `delay_at` takes it."""
        return TABLE_LAW.pack(kind=STEPS, points=[*self.times, *self.delays])


@dataclass
class TableDelay(StepDelay):
    """A delay on straight lines between given points, such as a measured one; constant outside.

    Attributes:
        times: of the points, rising.
        delays: at the points.
    """

    def parameters(self) -> Array:
        """Return the law as `delay_at` takes it."""
        return TABLE_LAW.pack(kind=LINES, points=[*self.times, *self.delays])


DelayLaw = ConstantDelay | SineDelay | StepDelay | TableDelay
