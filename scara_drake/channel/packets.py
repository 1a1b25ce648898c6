"""A channel of packets: delay, jitter, loss, reordering and outages."""

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scara_drake.channel.delays import LONGEST, ConstantDelay, DelayLaw
from scara_drake.channel.flight import (
    FLIGHT,
    LINK,
    PACKET,
    show_counts,
    step_packets,
    store_packets,
)
from scara_drake.channel.impairments import TICK, Jitter, Loss
from scara_drake.channel.signal_delay import check_signal, store_ticks
from scara_drake.common import fields
from scara_drake.common.block import Block, Declaration, Input, Memory, Output
from scara_drake.common.fields import number, vector

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

    def make_system(
        self, initial: ArrayLike, period: float, seed: int, selective: bool = False
    ) -> "PacketChannel":
        """Return the link for a signal that starts from `initial` (n,), see `PacketChannel`."""
        return PacketChannel(self, initial, period, seed, selective)

    def ticks(self, period: float) -> int:
        """Return within how many ticks of `period` [s] every packet arrives, and one more."""
        return math.ceil(self.longest / period) + 2

    def parameters(self, period: float, ahead: int) -> Array:
        """Return the link as kernels take it.

        Args:
            period: of the ticks [s].
            ahead: ticks whose arrivals the channel has at hand.
        """
        law = self.delay.parameters()
        return LINK.pack(
            jitter=self.jitter.parameters(),
            loss=self.loss.parameters(),
            longest=self.longest,
            period=period,
            stride=round(self.send_period / period),
            ahead=ahead,
            law_size=law.size,
            law_and_outages=[*law, *self.outages],
        )


class PacketChannel(Block):
    """Carries a signal in packets, of which the receiver keeps the one that was sent last.

    Ports:
        input signal_sent (n).
        input transmit (1): whether the packet of this tick is sent, above one half; only of a
            selective channel, others send each.
        output signal_received (n).
        output delay (1) [s]: travel time of the packet in use, 0 before the first.
        output age_of_information (1) [s]: since the packet in use was sent, or since the start
            before the first.
        output packet_counts (2): of the memory: how many were sent, and how many of them never
            arrive.

    Update, at t = k period: every `send_period` a packet with the signal is sent, if `transmit`
    says so; it arrives after delay(t) + jitter, unless it is lost, sent in an outage, or slower
    than `longest`. Then signal_received becomes that of the packet sent last among those that have
    arrived: one that was overtaken is dropped, so the received signal never runs backwards, and
    while nothing arrives it holds.
    Initial: signal_received = initial, all others 0.

    The ports change right after t, as those of `SignalDelay`, which a constant delay of whole
    periods equals bit for bit. Jitter and loss depend on the seed and the count of packets only.
    The memory has a row for each tick until `longest`. Where these are many, those of the next few
    ticks are at hand and the others are an archive, so that they are not copied at each tick.

    Args:
        packets: a checked link.
        initial: (n,), received until the first packet arrives.
        period: [s].
        seed: of jitter and loss.
        selective: it has the port `transmit`, and sends only what that asks for.

    Raises:
        ValueError: a field, the initial signal or the period is out of its bounds, or send_period
            is not a multiple of the period.
    """

    def __init__(
        self,
        packets: Packets,
        initial: ArrayLike,
        period: float = 1e-3,
        seed: int = 0,
        selective: bool = False,
    ) -> None:
        fields.check(packets, "packets")
        first = check_signal(initial, period)
        fields.check_sampling(packets, "packets", period)
        ticks, size = packets.ticks(period), PACKET.size + first.size
        every = store_ticks(ticks, size)
        # A tick more than the store waits: it comes before a tick or after it, by a rounding.
        ahead = every + 1 if every else ticks
        here = np.zeros((2 if every else 1) * ahead * size)
        until = -1.0 if every else np.inf
        flight = FLIGHT.zeros(in_use=-1.0, tick=-1.0, until=until, rows=here)
        transmit = {"transmit": Input(1)} if selective else {}
        super().__init__(
            Declaration(
                inputs={"signal_sent": Input(first.size)} | transmit,
                memory={
                    "signal_received": Memory(first, port=True),
                    "delay": Memory(1, port=True),
                    "age_of_information": Memory(1, port=True),
                    "flight": Memory(flight),
                },
                outputs={"packet_counts": Output(2, show_counts)},
                parameters={
                    "link": packets.parameters(period, ahead),
                    "seed": seed,
                    "size": size,
                }
                | ({} if selective else {"transmit": np.ones(1)}),
                period=period,
                update=step_packets,
                archive={"archived": Memory(ticks * size)} if every else {},
                store=store_packets if every else None,
                store_ticks=every,
            )
        )
