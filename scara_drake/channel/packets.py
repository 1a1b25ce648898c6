"""A channel of packets: delay, jitter, loss, reordering and outages."""

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scara_drake.channel.adaptive import empty_buffer, step_adaptive
from scara_drake.channel.delays import LONGEST, ConstantDelay, DelayLaw
from scara_drake.channel.flight import show_counts, show_playout, step_packets, store_packets
from scara_drake.channel.impairments import TICK, Jitter, Loss
from scara_drake.channel.layouts import FLIGHT, LINK, PACKET, PLAYOUT_STATE, SEED_PART
from scara_drake.channel.playout import Playout
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
        playout: buffer at its end; without one a packet is used when it arrives.
    """

    delay: DelayLaw = field(default_factory=ConstantDelay)
    jitter: Jitter = field(default_factory=Jitter)
    loss: Loss = field(default_factory=Loss)
    outages: list[float] = vector([], "s", 0.0, size=None)
    send_period: float = number(1e-3, "s", 1e-4, 1.0)
    longest: float = number(2.5, "s", 0.0, LONGEST)
    playout: Playout | None = None

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
        """Longest time from the sending of a packet to its use [s]."""
        return self.longest if self.playout is None else max(self.longest, self.buffer().depth)

    def make_system(
        self, initial: ArrayLike, period: float, seed: int, selective: bool = False
    ) -> "PacketChannel":
        """Return the link for a signal that starts from `initial` (n,), see `PacketChannel`."""
        return PacketChannel(self, initial, period, seed, selective)

    def buffer(self) -> Playout:
        """Return the playout; where there is none, one that plays each packet as it arrives."""
        return self.playout or Playout()

    def ticks(self, period: float) -> int:
        """Return within how many ticks of `period` [s] every packet is used, and one more."""
        return math.ceil(self.maximum() / period) + 2

    def parameters(self, period: float, seed: int, ahead: int) -> Array:
        """Return the link as kernels take it.

        Args:
            period: of the ticks [s].
            seed: of jitter and loss.
            ahead: ticks of the calendar that the channel has at hand.
        """
        law, playout = self.delay.parameters(), self.buffer()
        return LINK.pack(
            jitter=self.jitter.parameters(),
            loss=self.loss.parameters(),
            longest=self.longest,
            period=period,
            stride=round(self.send_period / period),
            ahead=ahead,
            depth=playout.depth,
            use_late=playout.uses_late,
            seed=divmod(seed, SEED_PART),
            adapt=playout.parameters(self.longest, period),
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
        output delay (1) [s]: from the sending of the packet in use until it was ready: its travel,
            and its wait in the buffer; 0 before the first.
        output age_of_information (1) [s]: since the packet in use was sent, or since the start
            before the first.
        output packet_counts (2): of the memory: how many were sent, and how many of them never
            arrive.
        output playout (4): of a link with a buffer, see `layouts.PlayoutState`.

    Update, at t = k period: every `send_period` a packet with the signal is sent, if `transmit`
    says so; it arrives after delay(t) + jitter, unless it is lost, sent in an outage, or slower
    than `longest`. Then signal_received becomes that of the packet sent last among those that have
    arrived: one that was overtaken is dropped, so the received signal never runs backwards, and
    while nothing arrives it holds. With a buffer a packet is ready when that lets it go, see
    `Playout`, and what is said of arrivals is true of that.
    Initial: signal_received = initial, all others 0.

    The ports change right after t, as those of `SignalDelay`, which a constant delay of whole
    periods equals bit for bit. Jitter and loss depend on the seed and the count of packets only.
    The memory has a row for each tick until `longest`. Where these are many, those of the next few
    ticks are at hand and the others are an archive, so that they are not copied at each tick. A
    buffer of adaptive depth has no archive, but keeps no more than its deepest holds.

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
        playout, size = packets.buffer(), PACKET.size + first.size
        ticks = packets.ticks(period)
        every = 0 if playout.adaptive else store_ticks(ticks, size)
        # A tick more than the store waits: it comes before a tick or after it, by a rounding.
        ahead = every + 1 if every else ticks
        link = packets.parameters(period, seed, ahead)
        calendar = np.zeros((2 if every else 1) * ahead * size)
        depth = playout.depth / period
        if playout.adaptive:
            depth, calendar = math.ceil(depth - TICK), empty_buffer(LINK.unpack(link).adapt, size)
        flight = FLIGHT.zeros(
            in_use=-1.0,
            tick=-1.0,
            until=-1.0 if every else np.inf,
            depth=depth,
            wanted=depth,
            horizon=-1.0 - depth,
            rows=calendar,
        )
        outputs = {"packet_counts": Output(2, show_counts)}
        if packets.playout is not None:
            outputs["playout"] = Output(PLAYOUT_STATE.size, show_playout)
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
                outputs=outputs,
                parameters={"link": link, "period": period, "size": size}
                | ({} if selective else {"transmit": np.ones(1)}),
                period=period,
                update=step_adaptive if playout.adaptive else step_packets,
                archive={"archived": Memory(ticks * size)} if every else {},
                store=store_packets if every else None,
                store_ticks=every,
            )
        )
