"""A channel of packets: delay, jitter, loss, reordering and outages."""

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from scara_drake.channel.delays import LONGEST, ConstantDelay, DelayLaw
from scara_drake.channel.impairments import (
    JITTER,
    LOSS,
    TICK,
    Jitter,
    Loss,
    in_outage,
    is_lost,
    jitter_time,
)
from scara_drake.channel.laws import delay_at
from scara_drake.channel.signal_delay import check_signal
from scara_drake.common import fields
from scara_drake.common.block import Block, Declaration, Input, Memory, Output
from scara_drake.common.fields import number, vector
from scara_drake.common.layout import REST, Cell, Layout

Array = NDArray[np.float64]


@dataclass
class Packets:
    """A link that carries packets; a `PacketChannel` in the scenario.

    A packet that is sent at t takes delay(t) plus jitter. One that would take longer than
    `longest` counts as lost; so does one sent during an outage.

    Attributes:
        delay: of a packet by the time it is sent.
        jitter: beside the delay.
        loss: of packets.
        outages: pairs in a row in which nothing is sent: start, end, start, ...
        send_period: from packet to packet, a multiple of the time step.
        longest: travel of a packet; it bounds the memory.
    """

    delay: DelayLaw = field(default_factory=ConstantDelay)
    jitter: Jitter = field(default_factory=Jitter)
    loss: Loss = field(default_factory=Loss)
    outages: list[float] = vector([], "s", 0.0, size=None)
    send_period: float = number(1e-3, "s", 1e-4, 1.0)
    longest: float = number(2.5, "s", 0.0, LONGEST)

    def check_together(self, name: str) -> None:
        """Check that the delay fits into `longest`, and that the outages are some.

        Raises:
            ValueError: the delay exceeds it, or they are not pairs in rising order.
        """
        if self.delay.maximum() > self.longest:
            raise ValueError(
                f"{name}.delay: up to {self.delay.maximum():g} s, allowed 0 to "
                f"{self.longest:g} s ({name}.longest)"
            )
        if len(self.outages) % 2 or sorted(self.outages) != list(self.outages):
            raise ValueError(
                f"{name}.outages: {self.outages}, allowed pairs start, end in rising order"
            )

    def check_sampling(self, name: str, period: float) -> None:
        """Check that packets are sent at ticks of `period` [s].

        Raises:
            ValueError: send_period is not a multiple of it.
        """
        ticks = round(self.send_period / period)
        if ticks < 1 or abs(ticks * period - self.send_period) > TICK:
            raise ValueError(
                f"{name}.send_period: {self.send_period:g} s, allowed a multiple of {period:g} s"
            )

    def maximum(self) -> float:
        """Longest time that a packet takes [s]."""
        return self.longest

    def make_system(self, initial: ArrayLike, period: float, seed: int) -> "PacketChannel":
        """Return the link for a signal that starts from `initial` (n,)."""
        return PacketChannel(self, initial, period, seed)

    def parameters(self, period: float) -> Array:
        """Return the link as `step_packets` takes it, for ticks of `period` [s]."""
        law = self.delay.parameters()
        return LINK.pack(
            jitter=self.jitter.parameters(),
            loss=self.loss.parameters(),
            longest=self.longest,
            period=period,
            send_period=self.send_period,
            stride=round(self.send_period / period),
            law_size=law.size,
            law_and_outages=[*law, *self.outages],
        )


class Link(NamedTuple):
    """`Packets` in a kernel.

    Attributes:
        jitter: of `Jitter.parameters`.
        loss: of `Loss.parameters`.
        longest: travel of a packet that still arrives [s].
        period: of the ticks [s].
        send_period: from packet to packet [s].
        stride: ticks in a send period.
        law_size: entries of the law.
        law_and_outages: law of the delay, then the outages (2 n,) [s].
    """

    jitter: Array
    loss: Array
    longest: float
    period: float
    send_period: float
    stride: float
    law_size: float
    law_and_outages: Array


class Flight(NamedTuple):
    """Memory of the link: the packets on their way, of which each has a slot, used again and again.

    When one was sent follows from the first packet and the send period: the memory is copied at
    every tick, so a slot holds no more than it must.

    Attributes:
        count: of the packets sent.
        lost: how many of them never arrive.
        newest: number of the packet in use; -1 before the first.
        bad: 1 while the link is bad.
        first: when the first packet was sent [s].
        stamp: when the packet in use was sent [s].
        slots: when each arrives (slots,) [s], infinite if lost, then the payloads (slots, n).
    """

    count: Cell
    lost: Cell
    newest: Cell
    bad: Cell
    first: Cell
    stamp: Cell
    slots: Array


LINK = Layout(Link, jitter=JITTER.size, loss=LOSS.size, law_and_outages=REST)
FLIGHT = Layout(Flight, count=(), lost=(), newest=(), bad=(), first=(), stamp=(), slots=REST)
link_of, flight_of = LINK.reader(), FLIGHT.reader()


@njit(cache=True)
def travel_time(t: float, link: Array, seed: int, packet: int, bad: Cell) -> float:
    """Time [s] that a packet takes which is sent at t [s], infinite if it never arrives."""
    p = link_of(link)
    law, outages = p.law_and_outages[: int(p.law_size)], p.law_and_outages[int(p.law_size) :]
    lost = is_lost(p.loss, seed, packet, bad) or in_outage(outages, t)
    travel = max(delay_at(law, t) + jitter_time(p.jitter, seed, packet), 0.0)
    return np.inf if lost or travel > p.longest + TICK else travel


@njit(cache=True)
def step_packets(
    t: float,
    signal_sent: Array,
    link: Array,
    seed: int,
    flight: Array,
    signal_received: Array,
    delay: Array,
    age_of_information: Array,
) -> None:
    """One tick of `PacketChannel`, in place.

    Args:
        t: time now [s].
        signal_sent: (n,).
        link: see `Link`.
        seed: of jitter and loss.
        flight: memory, see `Flight`.
        signal_received: (n,).
        delay: (1,), of the packet in use [s].
        age_of_information: (1,), since the packet in use was sent [s].
    """
    p, m = link_of(link), flight_of(flight)
    n = signal_sent.size
    slots = m.slots.size // (n + 1)
    arrivals, payloads = m.slots[:slots], m.slots[slots:].reshape((slots, n))
    count = int(m.count[()])
    if round(t / p.period) % int(p.stride) == 0:
        if count == 0:
            m.first[()] = t
        arrivals[count % slots] = t + travel_time(t, link, seed, count, m.bad)
        payloads[count % slots] = signal_sent
        if np.isinf(arrivals[count % slots]):
            m.lost[()] += 1.0
        count += 1
        m.count[()] = count
    for packet in range(count - 1, max(int(m.newest[()]), count - slots - 1), -1):
        arrival = arrivals[packet % slots]
        if arrival <= t + TICK:
            stamp = m.first[()] + packet * p.send_period
            m.newest[()], m.stamp[()] = packet, stamp
            signal_received[:] = payloads[packet % slots]
            delay[:] = arrival - stamp
            break
    age_of_information[:] = t - m.stamp[()]


@njit(cache=True)
def show_counts(flight: Array, packet_counts: Array) -> None:
    """Write how many packets were sent, and how many of them never arrive (2,)."""
    m = flight_of(flight)
    packet_counts[0], packet_counts[1] = m.count[()], m.lost[()]


class PacketChannel(Block):
    """Carries a signal in packets, of which the receiver keeps the one that was sent last.

    Ports:
        input signal_sent (n).
        output signal_received (n).
        output delay (1) [s]: travel time of the packet in use, 0 before the first.
        output age_of_information (1) [s]: since the packet in use was sent, or since the start
            before the first.
        output packet_counts (2): of the memory: how many were sent, and how many of them never
            arrive.

    Update, at t = k period: every `send_period` a packet with the signal is sent; it arrives after
    delay(t) + jitter, unless it is lost, sent in an outage, or slower than `longest`. Then
    signal_received becomes that of the packet sent last among those that have arrived: one that
    was overtaken is dropped, so the received signal never runs backwards, and while nothing
    arrives it holds.
    Initial: signal_received = initial, all others 0.

    The ports change right after t, as those of `SignalDelay`, which a constant delay of whole
    periods equals bit for bit. Jitter and loss depend on the seed and the count of packets only.

    Args:
        packets: a checked link.
        initial: (n,), received until the first packet arrives.
        period: [s].
        seed: of jitter and loss.

    Raises:
        ValueError: a field, the initial signal or the period is out of its bounds, or send_period
            is not a multiple of the period.
    """

    def __init__(
        self, packets: Packets, initial: ArrayLike, period: float = 1e-3, seed: int = 0
    ) -> None:
        fields.check(packets, "packets")
        first = check_signal(initial, period)
        fields.check_sampling(packets, "packets", period)
        slots = math.ceil(packets.longest / packets.send_period) + 1
        flight = FLIGHT.zeros(newest=-1.0, slots=np.zeros(slots * (first.size + 1)))
        super().__init__(
            Declaration(
                inputs={"signal_sent": Input(first.size)},
                memory={
                    "signal_received": Memory(first, port=True),
                    "delay": Memory(1, port=True),
                    "age_of_information": Memory(1, port=True),
                    "flight": Memory(flight),
                },
                outputs={"packet_counts": Output(2, show_counts)},
                parameters={"link": packets.parameters(period), "seed": seed},
                period=period,
                update=step_packets,
            )
        )
