"""Packets on their way, inside kernels.

When a packet arrives is known when it is sent. So the memory is a calendar: a row a tick, and in it
the packet that is ready there, the one sent last if there are several. It is ready when it arrives,
or when a playout buffer lets it go.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.channel.impairments import TICK, in_outage, is_lost, jitter_time
from scara_drake.channel.laws import delay_at
from scara_drake.channel.layouts import (
    PACKET,
    SEED_PART,
    Flight,
    flight_of,
    link_of,
    packet_of,
    playout_state_of,
)
from scara_drake.common.layout import Cell

Array = NDArray[np.float64]

ASKED = 0.5  # from here on the packet of a tick is sent
HEAD = PACKET.size  # of a row, before the payload


@njit(cache=True)
def travel_time(t: float, link: Array, packet: int, bad: Cell) -> float:
    """Time [s] that a packet takes which is sent at t [s], infinite if it never arrives."""
    p = link_of(link)
    seed = int(p.seed[0]) * SEED_PART + int(p.seed[1])
    law, outages = p.law_and_outages[: int(p.law_size)], p.law_and_outages[int(p.law_size) :]
    lost = is_lost(p.loss, seed, packet, bad) or in_outage(outages, t)
    travel = max(delay_at(law, t) + jitter_time(p.jitter, seed, packet), 0.0)
    return np.inf if lost or travel > p.longest + TICK else travel


@njit(cache=True)
def tick_of(arrival: float, period: float) -> int:
    """First tick k at which what arrives then [s] is there: arrival <= k period."""
    k = math.ceil((arrival - TICK) / period)
    while arrival <= (k - 1) * period + TICK:  # the quotient is rounded
        k -= 1
    while arrival > k * period + TICK:
        k += 1
    return k


@njit(cache=True)
def take_off(t: float, link: Array, m: Flight) -> float:
    """Count a packet that is sent at t [s]; return when it arrives [s], infinite for never."""
    packet = int(m.count[()])
    m.count[()] += 1.0
    arrival = t + travel_time(t, link, packet, m.bad)
    if np.isinf(arrival):
        m.lost[()] += 1.0
    return arrival


@njit(cache=True)
def is_late(sent: float, ready: float, link: Array) -> bool:
    """Whether a packet is ready [s] after the tick in which the buffer plays it."""
    p = link_of(link)
    return tick_of(ready, p.period) > tick_of(sent + p.depth, p.period)


@njit(cache=True)
def send(t: float, signal_sent: Array, link: Array, flight: Array) -> None:
    """Send a packet at t [s]: into the calendar, or to those that wait."""
    p, m = link_of(link), flight_of(flight)
    ahead = int(p.ahead)
    ready = max(take_off(t, link, m), t + p.depth)
    if np.isinf(ready):
        return
    if is_late(t, ready, link):
        m.late[()] += 1.0
        if p.use_late < ASKED:
            return
    rows = m.rows.reshape((-1, HEAD + signal_sent.size))
    due = tick_of(ready, p.period)
    at = due % ahead
    if due > m.until[()]:
        at = ahead + int(m.waiting[()]) % ahead
        m.waiting[()] += 1.0
    row = packet_of(rows[at])
    row.ordinal[()], row.sent[()], row.ready[()] = m.count[()], t, ready
    rows[at, HEAD:] = signal_sent


@njit(cache=True)
def step_packets(
    t: float,
    signal_sent: Array,
    transmit: Array,
    link: Array,
    flight: Array,
    signal_received: Array,
    delay: Array,
    age_of_information: Array,
) -> None:
    """One tick of `PacketChannel`, in place.

    Args:
        t: time now [s].
        signal_sent: (n,).
        transmit: (1,), whether this tick's packet is sent, above one half.
        link: see `Link`.
        flight: memory, see `Flight`.
        signal_received: (n,).
        delay: (1,), of the packet in use [s].
        age_of_information: (1,), since the packet in use was sent [s].
    """
    p, m = link_of(link), flight_of(flight)
    tick, ahead = round(t / p.period), int(p.ahead)
    m.tick[()] = tick
    if tick > m.until[()]:  # nothing was stored before
        m.until[()] = tick + ahead - 1
    if tick % int(p.stride) == 0 and transmit[0] > ASKED:
        send(t, signal_sent, link, flight)
    row = m.rows.reshape((-1, HEAD + signal_sent.size))[tick % ahead]
    arrived = packet_of(row)
    packet = int(arrived.ordinal[()]) - 1
    arrived.ordinal[()] = 0.0
    if packet > int(m.in_use[()]):
        m.in_use[()], m.stamp[()] = packet, arrived.sent[()]
        delay[:] = arrived.ready[()] - m.stamp[()]
        if is_late(arrived.sent.item(), arrived.ready.item(), link):
            m.used[()] += 1.0
        signal_received[:] = row[HEAD:]
    age_of_information[:] = t - m.stamp[()]


@njit(cache=True)
def store_packets(link: Array, size: int, flight: Array, archived: Array) -> None:
    """Store of `PacketChannel`: put the waiting packets into the calendar, and turn its page.

    Args:
        link: see `Link`.
        size: of a row.
        flight: memory, see `Flight`.
        archived: the calendar (ticks, size) of all ticks, that of tick k in row k mod ticks.
    """
    p, m = link_of(link), flight_of(flight)
    ahead, rows, calendar = int(p.ahead), m.rows.reshape((-1, size)), archived.reshape((-1, size))
    ticks, last = calendar.shape[0], int(m.tick[()])
    for index in range(min(int(m.waiting[()]), ahead)):
        row = rows[ahead + index]
        calendar[tick_of(packet_of(row).ready[()], p.period) % ticks] = row
    m.waiting[()] = 0.0
    for tick in range(last + 1, last + ahead + 1):
        stored, at_hand = packet_of(calendar[tick % ticks]), packet_of(rows[tick % ahead])
        # What was sent since, into the page before, came later.
        if stored.ordinal[()] > at_hand.ordinal[()]:
            rows[tick % ahead] = calendar[tick % ticks]
        stored.ordinal[()] = 0.0
    m.until[()] = last + ahead


@njit(cache=True)
def show_counts(flight: Array, packet_counts: Array) -> None:
    """Write how many packets were sent, and how many of them never arrive (2,)."""
    m = flight_of(flight)
    packet_counts[0], packet_counts[1] = m.count[()], m.lost[()]


@njit(cache=True)
def show_playout(period: float, flight: Array, playout: Array) -> None:
    """Write `PlayoutState` of the buffer (4,)."""
    m, shown = flight_of(flight), playout_state_of(playout)
    shown.late[()], shown.used[()] = m.late[()], m.used[()]
    shown.skipped[()] = m.skipped[()]
    shown.depth[()] = m.depth[()] * period
