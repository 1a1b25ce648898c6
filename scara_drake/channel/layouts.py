"""Layouts of a link of packets: what a kernel has of it, its packets and its memory, by name."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from scara_drake.channel.impairments import JITTER, LOSS
from scara_drake.channel.playout import ADAPT
from scara_drake.common.layout import REST, Cell, Layout

Array = NDArray[np.float64]

SEED_PART = 2**31  # of which a float holds every multiple that a seed has


class Link(NamedTuple):
    """`Packets` in a kernel.

    Attributes:
        jitter: of `Jitter.parameters`.
        loss: of `Loss.parameters`.
        longest: travel of a packet that still arrives [s].
        period: of the ticks [s].
        stride: ticks in a send period.
        ahead: ticks in the calendar at hand.
        depth: of the playout buffer [s]; 0 for none.
        use_late: 1 where a packet is used that arrives after its time, else 0.
        seed: of jitter and loss, above `SEED_PART` and below, as no float holds all of it.
        adapt: of `Playout.parameters`.
        law_size: entries of the law.
        law_and_outages: law of the delay, then the outages (2 n,) [s].
    """

    jitter: Array
    loss: Array
    longest: float
    period: float
    stride: float
    ahead: float
    depth: float
    use_late: float
    seed: Array
    adapt: Array
    law_size: float
    law_and_outages: Array


class Packet(NamedTuple):
    """What a row has before the payload (n,).

    Attributes:
        ordinal: number of the packet + 1; 0 in an empty row.
        sent: when it was sent [s].
        ready: when it may be used [s].
    """

    ordinal: Cell
    sent: Cell
    ready: Cell


class Flight(NamedTuple):
    """Memory of the link.

    Attributes:
        count: of the packets sent.
        lost: how many of them never arrive.
        in_use: number of the packet in use; -1 before the first.
        bad: 1 while the link is bad.
        stamp: when the packet in use was sent [s].
        tick: the last one, t / period.
        until: last tick of the calendar at hand; infinite without an archive.
        waiting: packets that are ready later, and wait to be stored.
        late: packets that arrive after their time.
        used: how many of them were used.
        skipped: packets that an adaptive depth passed over.
        depth: of the playout buffer [ticks].
        wanted: depth that an adaptive one goes to [ticks].
        horizon: tick of sending of what is due, of an adaptive depth.
        skip: share of a packet that an adaptive depth may skip.
        rows: calendar (ahead, size), that of tick k in row k mod ahead; then the waiting packets
            (ahead, size), which are none without an archive. Of an adaptive depth see `playout`.
    """

    count: Cell
    lost: Cell
    in_use: Cell
    bad: Cell
    stamp: Cell
    tick: Cell
    until: Cell
    waiting: Cell
    late: Cell
    used: Cell
    skipped: Cell
    depth: Cell
    wanted: Cell
    horizon: Cell
    skip: Cell
    rows: Array


class PlayoutState(NamedTuple):
    """`playout` (4) of a link with a buffer.

    Attributes:
        late: packets so far that arrive after their time.
        used: how many of them were used; the others were dropped, or overtaken.
        skipped: packets that were passed over, as the depth shrank.
        depth: now [s].
    """

    late: Cell
    used: Cell
    skipped: Cell
    depth: Cell


LINK = Layout(
    Link,
    jitter=JITTER.size,
    loss=LOSS.size,
    seed=2,
    adapt=ADAPT.size,
    law_and_outages=REST,
)
PACKET = Layout(Packet, ordinal=(), sent=(), ready=())
FLIGHT = Layout(
    Flight,
    count=(),
    lost=(),
    in_use=(),
    bad=(),
    stamp=(),
    tick=(),
    until=(),
    waiting=(),
    late=(),
    used=(),
    skipped=(),
    depth=(),
    wanted=(),
    horizon=(),
    skip=(),
    rows=REST,
)
PLAYOUT_STATE = Layout(PlayoutState, late=(), used=(), skipped=(), depth=())
link_of, packet_of, flight_of = LINK.reader(), PACKET.reader(), FLIGHT.reader()
playout_state_of = PLAYOUT_STATE.reader()
