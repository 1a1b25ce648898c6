"""A communication channel with constant or varying delay (section VII of the paper)."""

import math
from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from scara_drake import checks
from scara_drake.state import declare_state

Array = NDArray[np.float64]

LONGEST = 60.0  # [s]; a ring of it is copied at every tick, so this is a bound against slips


@dataclass
class ConstantDelay:
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
        """Offset [s], amplitude [s] and frequency [rad/s] (3,), for `delay_at`."""
        return np.array([self.delay, 0.0, 0.0])


@dataclass
class SineDelay:
    """amplitude sin(frequency t) + offset, and zero where that is negative.

    The default is the paper's 0.2 sin t. A delay of 0 to 2 s is amplitude 1, offset 1.
    """

    amplitude: float = 0.2  # [s]
    offset: float = 0.0  # [s]
    frequency: float = 1.0  # [rad/s]

    def validate(self, name: str) -> None:
        """Check the fields.

        Raises:
            ValueError: amplitude or frequency is negative, or a field is not finite.
        """
        checks.number(f"{name}.amplitude", self.amplitude, 0.0, LONGEST)
        checks.number(f"{name}.offset", self.offset, -LONGEST, LONGEST)
        checks.number(f"{name}.frequency", self.frequency, 0.0, 1e3)

    def maximum(self) -> float:
        """Longest delay [s]."""
        return max(self.amplitude + self.offset, 0.0)

    def parameters(self) -> Array:
        """Offset [s], amplitude [s] and frequency [rad/s] (3,), for `delay_at`."""
        return np.array([self.offset, self.amplitude, self.frequency], dtype=np.float64)


@dataclass
class Channel:
    """The two directions: `up` carries the command to the robot, `down` the force back."""

    up: ConstantDelay | SineDelay = field(default_factory=ConstantDelay)
    down: ConstantDelay | SineDelay = field(default_factory=ConstantDelay)
    max_delay: float = 2.5  # [s], the longest that either may reach

    def validate(self, name: str) -> None:
        """Check the fields.

        Raises:
            ValueError: a field of a delay is out of its bounds, or a delay exceeds max_delay.
        """
        checks.number(f"{name}.max_delay", self.max_delay, 0.0, LONGEST)
        for direction, delay in (("up", self.up), ("down", self.down)):
            delay.validate(f"{name}.{direction}")
            if delay.maximum() > self.max_delay:
                raise ValueError(
                    f"{name}.{direction}: a delay of up to {delay.maximum():g} s, allowed 0 to "
                    f"{self.max_delay:g} s ({name}.max_delay)"
                )


@njit(cache=True)
def delay_at(parameters: Array, t: float) -> float:
    """Delay [s] at time t [s]: offset + amplitude sin(frequency t), zero where negative."""
    return max(parameters[0] + parameters[1] * math.sin(parameters[2] * t), 0.0)


@njit(cache=True)
def push_and_read(ring: Array, sent: Array, age: float, received: Array) -> None:
    """Push a sample into a ring and read the one of `age` samples ago, by linear interpolation.

    Args:
        ring: (1 + rows n,): where the newest row is, then the rows; at least ceil(age) + 1.
        sent: (n,), the sample to push.
        age: 0 or more, in samples; 0 reads what was just pushed.
        received: (n,), written.
    """
    n = sent.size
    rows = (ring.size - 1) // n
    newest = (int(ring[0]) + 1) % rows
    ring[0] = newest
    ring[1 + newest * n : 1 + (newest + 1) * n] = sent
    whole = math.floor(age)
    share = age - whole
    late = 1 + ((newest - int(whole)) % rows) * n
    early = 1 + ((newest - int(whole) - 1) % rows) * n
    for i in range(n):
        received[i] = ring[late + i]
        if share > 0.0:
            received[i] += share * (ring[early + i] - ring[late + i])


@njit(cache=True)
def step_delay(
    parameters: Array,
    t: float,
    period: float,
    sent: Array,
    ring: Array,
    received: Array,
    delay: Array,
) -> None:
    """One tick of `SignalDelay`, in place: the delay (1,) [s], the ring and the received (n,)."""
    delay[0] = delay_at(parameters, t)
    age = delay[0] / period
    if abs(age - round(age)) < 1e-9:  # a delay of whole ticks reads samples as they were sent
        age = float(round(age))
    push_and_read(ring, sent, age, received)


class SignalDelay(LeafSystem):
    """Delays a signal by a time that varies.

    Ports:
        input signal_sent (n).
        output signal_received (n).
        output delay (1) [s].

    Update, at t = k period, with u(t) = signal_sent, straight lines between its samples, and
    u(t) = initial before the first one::

        delay <- max(0, offset + amplitude sin(frequency t))
        signal_received <- u(t - delay)

    Initial: signal_received = initial, delay = that of t = 0. The ports change right after t, so a
    reader in the same loop sees the signal one tick later than the delay alone: zero delay costs
    one period, as with Drake's DiscreteTimeDelay, which a constant delay equals bit for bit (save
    that this one starts from `initial`, not from zero). The delay is taken at the time of reading
    (as in Simulink's variable time delay): where it grows faster than time, the received signal
    runs backwards.

    Args:
        delay: a checked delay; the memory holds delay.maximum() and no more.
        initial: (n,), received until the first sample arrives.
        period: [s].

    Raises:
        ValueError: a field of the delay, the initial signal or the period is out of its bounds.
    """

    def __init__(
        self, delay: ConstantDelay | SineDelay, initial: ArrayLike, period: float = 1e-3
    ) -> None:
        super().__init__()
        delay.validate("delay")
        checks.number("period", period, 1e-4, 0.1)
        first = np.array(initial, dtype=np.float64)
        if first.ndim != 1 or first.size == 0 or not np.isfinite(first).all():
            raise ValueError(f"initial: shape {first.shape}, allowed (n,), n > 0, all finite")
        self._parameters = delay.parameters()
        self._period = period
        rows = math.ceil(delay.maximum() / period) + 1
        self._sent = self.DeclareVectorInputPort("signal_sent", first.size)
        self._received = declare_state(self, first, "signal_received")
        self._delay = declare_state(self, [delay_at(self._parameters, 0.0)], "delay")
        self._ring = declare_state(self, np.concatenate([[0.0], np.tile(first, rows)]))
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._step)

    def _step(self, context: Context, discrete: DiscreteValues) -> None:
        step_delay(
            self._parameters,
            context.get_time(),
            self._period,
            self._sent.Eval(context),
            discrete.get_mutable_value(self._ring),
            discrete.get_mutable_value(self._received),
            discrete.get_mutable_value(self._delay),
        )
