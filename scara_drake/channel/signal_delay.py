"""A signal delayed by a time that varies, as in Simulink's variable time delay."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from scara_drake.channel.laws import Law, delay_at
from scara_drake.common import checks
from scara_drake.common.block import Block, Declaration, Input, Memory
from scara_drake.common.fields import check
from scara_drake.common.layout import REST, Cell, Layout

Array = NDArray[np.float64]


class Ring(NamedTuple):
    """The last samples of a signal of n entries.

    Attributes:
        newest: which sample that is.
        samples: n entries each, one after the other.
    """

    newest: Cell
    samples: Array


RING = Layout(Ring, newest=(), samples=REST)
ring_of = RING.reader()


@njit(cache=True)
def push_and_read(ring: Array, sent: Array, age: float, received: Array) -> None:
    """Push a sample into a ring and read the one of `age` samples ago, by linear interpolation.

    Args:
        ring: see `Ring`; of at least ceil(age) + 1 samples.
        sent: (n,), the sample to push.
        age: 0 or more, in samples; 0 reads what was just pushed.
        received: (n,), written.
    """
    r = ring_of(ring)
    samples = r.samples.reshape((-1, sent.size))
    length = samples.shape[0]
    newest = (int(r.newest[()]) + 1) % length
    r.newest[()] = newest
    samples[newest] = sent
    whole = math.floor(age)
    share = age - whole
    late = samples[(newest - int(whole)) % length]
    early = samples[(newest - int(whole) - 1) % length]
    for i in range(sent.size):
        received[i] = late[i]
        if share > 0.0:
            received[i] += share * (early[i] - late[i])


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
                    "ring": Memory(RING.pack(newest=0.0, samples=np.tile(first, rows))),
                },
                parameters={"law": law, "period": period},
                period=period,
                update=delay_step,
            )
        )
