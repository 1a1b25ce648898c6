"""A delay that the operator sets while the run goes on."""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from scara_drake.channel.signal_delay import check_signal, store_ticks
from scara_drake.common.block import Block, Declaration, Input, Memory, Output
from scara_drake.common.layout import REST, Cell, Layout
from scara_drake.vectors import LIVE_SETTINGS, NEUTRAL_SETTINGS, live_settings_of

Array = NDArray[np.float64]

LONGEST_LIVE: Final = 2.0  # [s]
# Of the delay, per time: what is received goes forward at half to one and a half times its speed.
SLEW: Final = 0.5
UP, DOWN = 0.0, 1.0


class Live(NamedTuple):
    """The last samples of a signal of n entries, and those that are about to be received.

    Attributes:
        newest: number of the newest sample; the first is 0, and -1 stands there before.
        delay: now [ticks].
        first: number of the first sample in the window.
        rows: the last samples (recent, n), sample k in row k mod recent; then the window.
    """

    newest: Cell
    delay: Cell
    first: Cell
    rows: Array


LIVE = Layout(Live, newest=(), delay=(), first=(), rows=REST)
live_of = LIVE.reader()


@njit(cache=True)
def age_in_use(delay: float) -> int:
    """Age of what is received with a delay [ticks]: whole samples, so that no code is blurred."""
    return math.floor(delay + 0.5)


@njit(cache=True)
def live_delay_step(
    signal_sent: Array,
    live_settings: Array,
    link: float,
    period: float,
    recent: int,
    live: Array,
    delay_live: Array,
) -> None:
    """One tick of `LiveDelay`, in place; settings that are not finite change nothing."""
    m = live_of(live)
    rows = m.rows.reshape((-1, signal_sent.size))
    newest = int(m.newest[()]) + 1
    m.newest[()] = newest
    rows[newest % recent] = signal_sent
    settings = live_settings_of(live_settings)
    wanted = settings.delay_up if link == UP else settings.delay_down
    if np.isfinite(wanted):
        ticks = min(max(wanted, 0.0), LONGEST_LIVE) / period
        m.delay[()] += min(max(ticks - m.delay[()], -SLEW), SLEW)
    delay_live[0] = age_in_use(m.delay[()]) * period


@njit(cache=True)
def live_delay_output(signal_sent: Array, recent: int, live: Array, signal_delayed: Array) -> None:
    """Write what is received now, (n,)."""
    m = live_of(live)
    rows, newest, age = m.rows.reshape((-1, signal_sent.size)), int(m.newest[()]), 0
    age = age_in_use(m.delay[()])
    number = newest + 1 - age  # the sample of now has not joined the others yet
    if age == 0:
        signal_delayed[:] = signal_sent
    elif number > newest - recent:
        signal_delayed[:] = rows[number % recent]
    else:
        signal_delayed[:] = rows[recent + number - int(m.first[()])]


@njit(cache=True)
def delay_in_all(delay_sent: Array, delay_live: Array, delay: Array) -> None:
    """Write the delay of the link and the live one together, (1,) [s]."""
    delay[0] = delay_sent[0] + delay_live[0]


@njit(cache=True)
def age_in_all(age_sent: Array, delay_live: Array, age_of_information: Array) -> None:
    """Write the age behind the link and the live delay together, (1,) [s]."""
    age_of_information[0] = age_sent[0] + delay_live[0]


@njit(cache=True)
def live_delay_store(recent: int, size: int, live: Array, archived: Array) -> None:
    """Store of `LiveDelay`: what has come goes into the archive, what is about to be read out.

    Args:
        recent: see `Live`.
        size: of a sample.
        live: see `Live`.
        archived: (rows, size), sample k in row k mod rows.
    """
    m = live_of(live)
    rows, old = m.rows.reshape((-1, size)), archived.reshape((-1, size))
    newest = int(m.newest[()])
    for number in range(newest - recent + 1, newest + 1):
        old[number % old.shape[0]] = rows[number % recent]
    first = newest - age_in_use(m.delay[()])
    m.first[()] = first
    for place in range(rows.shape[0] - recent):
        rows[recent + place] = old[(first + place) % old.shape[0]]


class LiveDelay(Block):
    """Delays a signal by a time that is set during the run, and not at all where that is zero.

    Ports:
        input signal_sent (n).
        input live_settings (5): its `delay_up`, or `delay_down`, is the delay that is wanted, 0 to
            2 s [s]; nothing is wanted where the port is not connected.
        input delay_sent (1): of the link before this one [s]; zero where it is not connected.
        output delay_live (1): the delay in use [s].
        output signal_delayed (n).
        output delay (1): of both together [s].
        input age_sent (1), output age_of_information (1): the same of the age, behind a link that
            tells one. So what is silent is told at once, whatever the delay: age - delay is the
            link's.

    Update, at t = k period: the delay in use goes to the wanted one at half a second a second, so
    what is received never runs backwards. Output, with u(t) = signal_sent, of whole samples, and
    u(t) = initial before the first one::

        signal_delayed = u(t - delay_live)

    With delay_live = 0 that is u(t) itself, to the bit and without the period that other blocks
    take. A signal may hold codes beside numbers: nothing is interpolated. Initial: no delay.

    The memory is long, and most of it an archive, see `Declaration`: the delay changes slowly, so
    what is read until the next store is known to lie in a window.

    Args:
        initial: (n,), received of the time before the first sample.
        period: [s].
        link: "up" or "down", whose delay it is.
        ages: whether the link before it tells ages.

    Raises:
        ValueError: the initial signal or the period is out of its bounds.
    """

    def __init__(
        self, initial: ArrayLike, period: float = 1e-3, link: str = "up", ages: bool = False
    ) -> None:
        first = check_signal(initial, period)
        longest = math.ceil(LONGEST_LIVE / period) + 1
        ticks = store_ticks(longest, first.size) or 1
        # A tick more than the store waits: it comes before a tick or after it, by a rounding.
        recent, window = ticks + 2, math.ceil((1.0 + SLEW) * (ticks + 1)) + 4
        rows = np.tile(first, recent + window)
        outputs = {
            "signal_delayed": Output(first.size, live_delay_output),
            "delay": Output(1, delay_in_all),
        }
        if ages:
            outputs["age_of_information"] = Output(1, age_in_all)
        super().__init__(
            Declaration(
                inputs={
                    "signal_sent": Input(first.size),
                    "delay_sent": Input(1, default=(0.0,)),
                    "age_sent": Input(1, default=(0.0,)),
                    "live_settings": Input(LIVE_SETTINGS.size, default=tuple(NEUTRAL_SETTINGS)),
                },
                memory={
                    "delay_live": Memory(1, port=True),
                    "live": Memory(LIVE.pack(newest=-1.0, delay=0.0, first=-1.0, rows=rows)),
                },
                outputs=outputs,
                parameters={
                    "link": DOWN if link == "down" else UP,
                    "period": period,
                    "recent": recent,
                    "size": first.size,
                },
                period=period,
                update=live_delay_step,
                archive={"archived": Memory(np.tile(first, longest + recent + window))},
                store=live_delay_store,
                store_ticks=ticks,
            )
        )
