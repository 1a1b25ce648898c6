"""An adaptive playout buffer, inside kernels: it learns its depth from the delays it has seen.

When a packet will be played is not known when it is sent, so those that wait are kept by the tick
of their sending. The depth is in whole ticks, as packets are played at ticks; so the delays are
counted by the tick, and older ones fade.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.channel.flight import ASKED, HEAD, take_off, tick_of
from scara_drake.channel.layouts import Flight, flight_of, link_of, packet_of
from scara_drake.channel.playout import ADAPT, adapt_of

Array = NDArray[np.float64]

FAINT = 1e-12  # weight of a delay that counts as forgotten


class Buffer(NamedTuple):
    """The `rows` of a `Flight` with an adaptive depth.

    Attributes:
        arrivals: tick (travel,) in which the packet arrives that was sent at tick k, in entry k mod
            travel; infinite where there is none.
        weights: of the delays (deep,), that of k ticks in entry k; the last is for longer ones.
        rows: packets (deep, HEAD + n) that were sent at tick k, in row k mod deep.
    """

    arrivals: Array
    weights: Array
    rows: Array


def empty_buffer(adapt: Array, size: int) -> Array:
    """Return the `Buffer` (n,) before the first packet, of rows of `size`."""
    a = ADAPT.unpack(adapt)
    return np.concatenate([np.full(int(a.travel), np.inf), np.zeros(int(a.deep) * (1 + size))])


@njit(cache=True)
def buffer_of(adapt: Array, rows: Array, size: int) -> Buffer:
    """Return the parts of the buffer, views."""
    a = adapt_of(adapt)
    travel, deep = int(a.travel), int(a.deep)
    return Buffer(
        rows[:travel], rows[travel : travel + deep], rows[travel + deep :].reshape((-1, size))
    )


@njit(cache=True)
def wanted_depth(weights: Array, share: float) -> int:
    """Smallest delay [ticks] within which a share of the weights (n,) lies."""
    total = weights.sum() * (1.0 - FAINT)  # the sums differ by roundings
    seen, depth = 0.0, 0
    for depth in range(weights.size):
        seen += weights[depth]
        if seen >= share * total:
            break
    return depth


@njit(cache=True)
def first_due(tick: int, in_use: int, m: Flight) -> int:
    """Tick of sending of the first packet that is due now; those before it are late.

    Due is what has come to be as old as the depth since the last tick, or again as the depth grew.
    """
    return max(in_use, min(int(m.horizon[()]), tick - int(m.depth[()]) - 1)) + 1


@njit(cache=True)
def observe(tick: int, in_use: int, adapt: Array, buffer: Buffer, m: Flight) -> None:
    """Take in the delays of what arrives now; the depth grows at once; count who is late."""
    a, arrivals, weights = adapt_of(adapt), buffer.arrivals, buffer.weights
    ticks = arrivals.size
    came = False
    for sent in range(max(tick - ticks + 1, 0), tick + 1):
        if arrivals[sent % ticks] == tick:
            came = True
            for i in range(weights.size):
                weights[i] = weights[i] * a.keep if weights[i] > FAINT else 0.0
            weights[min(tick - sent, weights.size - 1)] += 1.0 - a.keep if a.keep > 0.0 else 1.0
    if not came:
        return
    m.wanted[()] = wanted_depth(weights, a.share)
    m.depth[()] = max(m.depth[()], m.wanted[()])
    for sent in range(max(tick - ticks + 1, 0), first_due(tick, in_use, m)):
        if arrivals[sent % ticks] == tick:
            m.late[()] += 1.0


@njit(cache=True)
def newest_there(first: int, last: int, tick: int, buffer: Buffer) -> int:
    """Tick of sending, first to last, of the packet sent last that is there; -1 for none."""
    kept = min(buffer.arrivals.size, buffer.rows.shape[0])
    for sent in range(last, max(first, tick - kept + 1, 0) - 1, -1):
        if buffer.arrivals[sent % buffer.arrivals.size] <= tick:
            return sent
    return -1


@njit(cache=True)
def choose(tick: int, use_late: bool, in_use: int, adapt: Array, buffer: Buffer, m: Flight) -> int:
    """Tick of sending of the packet to be played now, -1 for none; the depth may shrink.

    Args:
        tick: now.
        use_late: whether late packets are used.
        in_use: tick of sending of the packet in use.
        adapt: see `Adapt`.
        buffer: of the link.
        m: memory of the link.
    """
    a = adapt_of(adapt)
    horizon = tick - int(m.depth[()])
    due = first_due(tick, in_use, m)
    first = in_use + 1 if use_late else due
    found = newest_there(first, horizon, tick, buffer)
    too_deep = m.depth[()] - m.wanted[()]
    if too_deep > 1.0:
        m.skip[()] += a.shrink
    if too_deep > 0.0 and (found < due or m.skip[()] >= 1.0):
        m.skip[()] = 0.0
        m.depth[()] -= 1.0
        horizon += 1
        found = max(newest_there(max(horizon, first), horizon, tick, buffer), found)
    if found >= due:
        for sent in range(due, found):
            if newest_there(sent, sent, tick, buffer) == sent:
                m.skipped[()] += 1.0
    elif found >= 0:
        m.used[()] += 1.0
    m.horizon[()] = horizon
    return found


@njit(cache=True)
def step_adaptive(
    t: float,
    signal_sent: Array,
    transmit: Array,
    link: Array,
    flight: Array,
    signal_received: Array,
    delay: Array,
    age_of_information: Array,
) -> None:
    """One tick of `PacketChannel` with an adaptive depth, in place; see `flight.step_packets`."""
    p, m = link_of(link), flight_of(flight)
    buffer = buffer_of(p.adapt, m.rows, HEAD + signal_sent.size)
    tick = round(t / p.period)
    buffer.arrivals[tick % buffer.arrivals.size] = np.inf
    if tick % int(p.stride) == 0 and transmit[0] > ASKED:
        there = take_off(t, link, m)
        if np.isfinite(there):
            buffer.arrivals[tick % buffer.arrivals.size] = tick_of(there, p.period)
            row = buffer.rows[tick % buffer.rows.shape[0]]
            packet = packet_of(row)
            packet.ordinal[()], packet.sent[()], packet.ready[()] = m.count[()], t, there
            row[HEAD:] = signal_sent
    in_use = -1 if m.in_use[()] < 0.0 else round(m.stamp.item() / p.period)
    observe(tick, in_use, p.adapt, buffer, m)
    found = choose(tick, p.use_late > ASKED, in_use, p.adapt, buffer, m)
    if found >= 0:
        row = buffer.rows[found % buffer.rows.shape[0]]
        packet = packet_of(row)
        m.in_use[()], m.stamp[()] = packet.ordinal[()] - 1.0, packet.sent[()]
        ready = max(packet.ready[()], packet.sent[()] + m.depth[()] * p.period)
        delay[:] = ready - m.stamp[()]
        signal_received[:] = row[HEAD:]
    age_of_information[:] = t - m.stamp[()]
