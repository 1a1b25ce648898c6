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


SHORT = 2048  # numbers; so many are copied in about a microsecond


class Ring(NamedTuple):
    """The last samples of a signal of n entries, and what is foreseen of older ones.

    Attributes:
        newest: number of the newest sample; the first is 0, and -1 stands there before.
        tick: number of the tick that brought it, t / period.
        stored: number of the newest sample in the archive; -inf without one.
        rows: the samples (rows, n), sample k in row k mod rows; then (ahead, n) what is received
            at coming ticks of samples in the archive, that of tick k in row k mod ahead.
    """

    newest: Cell
    tick: Cell
    stored: Cell
    rows: Array


RING = Layout(Ring, newest=(), tick=(), stored=(), rows=REST)
ring_of = RING.reader()


@njit(cache=True)
def age_of(delay: float, period: float) -> float:
    """Age of what is received with a delay [s], in samples."""
    age = delay / period
    if abs(age - round(age)) < 1e-9:  # a delay of whole ticks reads samples as they were sent
        return float(round(age))
    return age


@njit(cache=True)
def read_back(samples: Array, newest: int, age: float, received: Array) -> None:
    """Read what was sent `age` samples before number `newest`, by linear interpolation.

    Args:
        samples: (rows, n), sample k in row k mod rows.
        newest: number of a sample.
        age: 0 or more.
        received: (n,), written.
    """
    rows, whole = samples.shape[0], math.floor(age)
    late, early = samples[(newest - whole) % rows], samples[(newest - whole - 1) % rows]
    share = age - whole
    for i in range(received.size):
        received[i] = late[i]
        if share > 0.0:
            received[i] += share * (early[i] - late[i])


@njit(cache=True)
def delay_step(
    t: float,
    signal_sent: Array,
    law: Array,
    period: float,
    ahead: int,
    ring: Array,
    signal_received: Array,
    delay: Array,
) -> None:
    """One tick of `SignalDelay`, in place: the delay (1,) [s], the ring and the received (n,)."""
    r = ring_of(ring)
    rows = r.rows.reshape((-1, signal_sent.size))
    samples, foreseen = rows[: rows.shape[0] - ahead], rows[rows.shape[0] - ahead :]
    newest, tick = int(r.newest[()]) + 1, round(t / period)
    r.newest[()], r.tick[()] = newest, tick
    samples[newest % samples.shape[0]] = signal_sent
    delay[:] = delay_at(law, t)
    age = age_of(delay.item(), period)
    if newest - math.floor(age) > r.stored[()]:
        read_back(samples, newest, age, signal_received)
    else:
        signal_received[:] = foreseen[tick % ahead]


@njit(cache=True)
def look_ahead(
    law: Array, period: float, ahead: int, size: int, ring: Array, archived: Array
) -> None:
    """Store of `SignalDelay`: take the ring over, and foresee what is received of the archive.

    Args:
        law: of the delay.
        period: of the ticks [s].
        ahead: ticks to foresee.
        size: of a sample.
        ring: see `Ring`.
        archived: (rows, size), sample k in row k mod rows.
    """
    r = ring_of(ring)
    rows, old = r.rows.reshape((-1, size)), archived.reshape((-1, size))
    samples, foreseen = rows[: rows.shape[0] - ahead], rows[rows.shape[0] - ahead :]
    newest, tick = int(r.newest[()]), int(r.tick[()])
    for number in range(newest - samples.shape[0] + 1, newest + 1):
        old[number % old.shape[0]] = samples[number % samples.shape[0]]
    for later in range(1, ahead + 1):
        age = age_of(delay_at(law, (tick + later) * period), period)
        if later <= math.floor(age):
            read_back(old, newest + later, age, foreseen[(tick + later) % ahead])
    r.stored[()] = newest


def store_ticks(rows: int, size: int) -> int:
    """Return once in how many ticks a memory of (rows, size) is best stored; 0: it is short.

    About the root of the rows: then what is copied at a tick, few rows at each and all of them once
    in a while, is least. A power of two, of which any multiple of a period is that of a tick to the
    bit, so that the Simulator makes no step of its own for it.
    """
    return 2 ** math.ceil(math.log2(rows) / 2.0) if rows * size > SHORT else 0


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
    r"""Delays a signal by a time that varies.

    Ports:
        input signal_sent (n).
        output signal_received (n).
        output delay (1) [s].

    Update, at t = k period, with u(t) = signal_sent, straight lines between its samples, and
    u(t) = initial before the first one; the delay is tau, signal_received is y:

    .. math::

        \tau &\leftarrow \max(0,\; \tau(t)) \\
        y    &\leftarrow u(t - \tau)

    Initial: signal_received = initial, delay = that of t = 0. The ports change right after t, so a
    reader in the same loop sees the signal one tick later than the delay alone: zero delay costs
    one period, as with Drake's DiscreteTimeDelay, which a constant delay equals bit for bit (save
    that this one starts from `initial`, not from zero). The delay is taken at the time of reading
    (as in Simulink's variable time delay): where it grows faster than time, the received signal
    runs backwards.

    The memory holds delay.maximum() and no more. Where that is long, most of it is an archive, so
    that it is not copied at each tick: once in about as many ticks as the root of its length, all
    that is going to be received from it until the next time is worked out, as the law is known.

    Args:
        delay: a checked delay.
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
        ticks = store_ticks(rows, first.size)
        # A tick more than the store waits: it comes before a tick or after it, by a rounding.
        ahead = ticks + 1 if ticks else 0
        here = np.tile(first, 2 * ahead + 1 if ticks else rows)
        ring = RING.pack(newest=-1.0, tick=-1.0, stored=-1.0 if ticks else -np.inf, rows=here)
        super().__init__(
            Declaration(
                inputs={"signal_sent": Input(first.size)},
                memory={
                    "signal_received": Memory(first, port=True),
                    "delay": Memory([delay_at(law, 0.0)], port=True),
                    "ring": Memory(ring),
                },
                parameters={"law": law, "period": period, "ahead": ahead, "size": first.size},
                period=period,
                update=delay_step,
                archive={"archived": Memory(np.tile(first, rows))} if ticks else {},
                store=look_ahead if ticks else None,
                store_ticks=ticks,
            )
        )
