"""A signal delayed by a time that varies, as in Simulink's variable time delay."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from scara_drake.common import checks
from scara_drake.common.block import Block, Declaration, Input, Memory
from scara_drake.common.fields import check

Array = NDArray[np.float64]

# First entry of the parameters of a law.
SINE, STEPS, LINES = 0.0, 1.0, 2.0


class Law(Protocol):
    """What a delay has to tell, see `delays`."""

    def validate(self, name: str) -> None:
        """Check the fields."""

    def maximum(self) -> float:
        """Longest delay [s]."""

    def parameters(self) -> Array:
        """Return the law as `delay_at` takes it."""


@njit(cache=True)
def delay_at(parameters: Array, t: float) -> float:
    """Delay [s] at time t [s], never negative.

    Args:
        parameters: the kind of law, and

            - SINE: offset [s], amplitude [s], frequency [rad/s], phase [rad];
            - STEPS and LINES: times (n,) [s], rising, and delays (n,) [s] from each on, or on
              straight lines between them.
        t: [s].
    """
    if parameters[0] == SINE:
        angle = parameters[3] * t + parameters[4]
        return max(parameters[1] + parameters[2] * math.sin(angle), 0.0)
    n = (parameters.size - 1) // 2
    times, delays = parameters[1 : 1 + n], parameters[1 + n :]
    if parameters[0] == STEPS:
        return delays[max(int(np.searchsorted(times, t, side="right")) - 1, 0)]
    return np.interp(t, times, delays)


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
def delay_step(
    t: float,
    signal_sent: Array,
    law: Array,
    period: float,
    ring: Array,
    signal_received: Array,
    delay: Array,
) -> None:
    """One tick of `SignalDelay`, in place: the delay (1,) [s], the ring and the received (n,)."""
    delay[:] = delay_at(law, t)
    age = delay.item() / period
    if abs(age - round(age)) < 1e-9:  # a delay of whole ticks reads samples as they were sent
        age = float(round(age))
    push_and_read(ring, signal_sent, age, signal_received)


def check_signal(initial: ArrayLike, period: float) -> Array:
    """Return the first value (n,) of a signal, as a new array.

    Raises:
        ValueError: it is not (n,) and finite, or the period [s] is out of its bounds.
    """
    checks.number("period", period, 1e-4, 0.1)
    first = np.array(initial, dtype=np.float64)
    if first.ndim != 1 or first.size == 0 or not np.isfinite(first).all():
        raise ValueError(f"initial: shape {first.shape}, allowed (n,), n > 0, all finite")
    return first


class SignalDelay(Block):
    """Delays a signal by a time that varies.

    Ports:
        input signal_sent (n).
        output signal_received (n).
        output delay (1) [s].

    Update, at t = k period, with u(t) = signal_sent, straight lines between its samples, and
    u(t) = initial before the first one::

        delay <- delay_at(t), never negative
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

    def __init__(self, delay: Law, initial: ArrayLike, period: float = 1e-3) -> None:
        check(delay, "delay")
        first = check_signal(initial, period)
        law = delay.parameters()
        rows = math.ceil(delay.maximum() / period) + 1
        super().__init__(
            Declaration(
                inputs={"signal_sent": Input(first.size)},
                memory={
                    "signal_received": Memory(first, port=True),
                    "delay": Memory([delay_at(law, 0.0)], port=True),
                    "ring": Memory(np.concatenate([[0.0], np.tile(first, rows)])),
                },
                parameters={"law": law, "period": period},
                period=period,
                update=delay_step,
            )
        )
