"""A channel of packets: delay, jitter, loss, reordering and outages."""

import math
from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from scara_drake.channel.delays import LONGEST, ConstantDelay, SineDelay, StepDelay, TableDelay
from scara_drake.channel.signal_delay import check_signal, delay_at
from scara_drake.common import checks
from scara_drake.common.draws import gamma, normal, uniform
from scara_drake.common.state import declare_state

Array = NDArray[np.float64]

DISTRIBUTIONS = ("none", "uniform", "normal", "gamma", "lognormal")
TICK = 1e-9  # [s]; times closer than this are the same


@dataclass
class Jitter:
    """A random time that each packet takes beside the delay.

    Attributes:
        distribution: none, uniform, normal (cut off at zero), gamma or lognormal. An exponential
            one is gamma with std = mean.
        mean: [s].
        std: standard deviation [s].
    """

    distribution: str = "none"
    mean: float = 0.0  # [s]
    std: float = 0.0  # [s]

    def validate(self, name: str) -> None:
        """Check the fields.

        Raises:
            ValueError: an unknown distribution, or a number out of its range.
        """
        checks.choice(f"{name}.distribution", self.distribution, DISTRIBUTIONS)
        checks.number(f"{name}.mean", self.mean, 0.0, LONGEST)
        checks.number(f"{name}.std", self.std, 0.0, LONGEST)
        if self.distribution == "uniform":
            checks.number(f"{name}.std", self.std, 0.0, self.mean / math.sqrt(3.0))
        if self.distribution in ("gamma", "lognormal"):
            checks.number(f"{name}.mean", self.mean, checks.ABOVE_ZERO, LONGEST)
            checks.number(f"{name}.std", self.std, checks.ABOVE_ZERO, LONGEST)


@dataclass
class Loss:
    """Packets that never arrive, by the model of Gilbert and Elliott.

    The link is good or bad; before each packet it changes by chance. The defaults stay good, so
    that `in_good` alone is independent loss.

    Attributes:
        in_good: probability that a packet is lost while the link is good.
        in_bad: the same while it is bad.
        to_bad: probability of turning bad, from packet to packet.
        to_good: probability of turning good.
    """

    in_good: float = 0.0
    in_bad: float = 1.0
    to_bad: float = 0.0
    to_good: float = 1.0

    def validate(self, name: str) -> None:
        """Check the fields.

        Raises:
            ValueError: a probability outside 0 to 1.
        """
        for probability in ("in_good", "in_bad", "to_bad", "to_good"):
            checks.number(f"{name}.{probability}", getattr(self, probability), 0.0, 1.0)


@dataclass
class Packets:
    """A link that carries packets; a `PacketChannel` in the scenario.

    A packet that is sent at t takes delay(t) plus jitter. One that would take longer than
    `longest` counts as lost; so does one sent during an outage.

    Attributes:
        delay: of a packet by the time it is sent.
        jitter: beside the delay.
        loss: of packets.
        outages: pairs [start, end] in a row [s] in which nothing is sent: start, end, start, ...
        send_period: from packet to packet [s], a multiple of the time step.
        longest: [s], bounds the memory.
    """

    delay: ConstantDelay | SineDelay | StepDelay | TableDelay = field(default_factory=ConstantDelay)
    jitter: Jitter = field(default_factory=Jitter)
    loss: Loss = field(default_factory=Loss)
    outages: list[float] = field(default_factory=list)
    send_period: float = 1e-3  # [s]
    longest: float = 2.5  # [s]

    def validate(self, name: str) -> None:
        """Check the fields.

        Raises:
            ValueError: a field is out of its bounds, the delay exceeds `longest`, or the outages
                are not pairs in rising order.
        """
        for part in ("delay", "jitter", "loss"):
            getattr(self, part).validate(f"{name}.{part}")
        checks.number(f"{name}.longest", self.longest, 0.0, LONGEST)
        checks.number(f"{name}.send_period", self.send_period, 1e-4, 1.0)
        if self.delay.maximum() > self.longest:
            raise ValueError(
                f"{name}.delay: up to {self.delay.maximum():g} s, allowed 0 to "
                f"{self.longest:g} s ({name}.longest)"
            )
        checks.vector(f"{name}.outages", self.outages, len(self.outages), 0.0)
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

    def parameters(self) -> Array:
        """Return the constants (9,): jitter, loss, longest travel and send period."""
        jitter, loss = self.jitter, self.loss
        kind = DISTRIBUTIONS.index(jitter.distribution)
        chances = [loss.in_good, loss.in_bad, loss.to_bad, loss.to_good]
        times = [self.longest, self.send_period]
        return np.array([kind, jitter.mean, jitter.std, *chances, *times], dtype=np.float64)


# Entries of the constants, and of the head of the memory.
KIND, MEAN, STD, IN_GOOD, IN_BAD, TO_BAD, TO_GOOD, MAXIMUM, SPACING = range(9)
COUNT, NEWEST, BAD, FIRST, STAMP, HEAD = range(6)
# Streams of random numbers, beside those that `gamma` takes after its seed.
JITTER, LOST, CHANGE, STREAMS = 0, 3, 4, 5


@njit(cache=True)
def jitter_time(constants: Array, seed: int, packet: int) -> float:
    """Time [s] that a packet takes beside the delay; it can be negative for a normal one."""
    kind, mean, std = int(constants[KIND]), constants[MEAN], constants[STD]
    stream = seed * STREAMS + JITTER
    if kind == 1:
        return mean + math.sqrt(12.0) * std * (uniform(stream, packet) - 0.5)
    if kind == 2:
        return mean + std * normal(stream, packet)
    if kind == 3:
        return std * std / mean * gamma((mean / std) ** 2, stream, packet)
    if kind == 4:
        variance = math.log(1.0 + (std / mean) ** 2)
        return mean * math.exp(math.sqrt(variance) * normal(stream, packet) - 0.5 * variance)
    return 0.0


@njit(cache=True)
def is_lost(constants: Array, seed: int, packet: int, memory: Array) -> bool:
    """Whether a packet is lost; moves the link between good and bad, `memory[BAD]`."""
    bad = memory[BAD] > 0.5
    chance = constants[TO_GOOD] if bad else constants[TO_BAD]
    if uniform(seed * STREAMS + CHANGE, packet) < chance:
        bad = not bad
    memory[BAD] = 1.0 if bad else 0.0
    return uniform(seed * STREAMS + LOST, packet) < (
        constants[IN_BAD] if bad else constants[IN_GOOD]
    )


@njit(cache=True)
def in_outage(outages: Array, t: float) -> bool:
    """Whether t [s] is in one of the outages (2 n,): [start, end)."""
    return np.searchsorted(outages, t + TICK, side="right") % 2 == 1


@njit(cache=True)
def step_packets(
    t: float,
    send: bool,
    law: Array,
    constants: Array,
    outages: Array,
    seed: int,
    sent: Array,
    memory: Array,
    received: Array,
    delay: Array,
    age: Array,
) -> None:
    """One tick of `PacketChannel`, in place.

    Args:
        t: time now [s].
        send: whether a packet is sent now.
        law: parameters of the delay, see `delay_at`.
        constants: see `Packets.parameters`.
        outages: (2 n,) [s].
        seed: of jitter and loss.
        sent: (n,) the signal now.
        memory: HEAD entries, then rows of n + 1: when it arrives (infinite if lost), payload. When
            it was sent follows from the first packet and the send period: the memory is copied at
            every tick, so a row holds no more than it must.
        received: (n,), written.
        delay: (1,), of the packet in use [s].
        age: (1,), since the packet in use was sent [s].
    """
    n = sent.size
    width = n + 1
    rows = (memory.size - HEAD) // width
    count, newest = int(memory[COUNT]), int(memory[NEWEST])
    if send:
        if count == 0:
            memory[FIRST] = t
        lost = is_lost(constants, seed, count, memory) or in_outage(outages, t)
        travel = max(delay_at(law, t) + jitter_time(constants, seed, count), 0.0)
        row = HEAD + (count % rows) * width
        memory[row] = np.inf if lost or travel > constants[MAXIMUM] + TICK else t + travel
        memory[row + 1 : row + width] = sent
        count += 1
        memory[COUNT] = count
    for packet in range(count - 1, max(newest, count - rows - 1), -1):
        row = HEAD + (packet % rows) * width
        if memory[row] <= t + TICK:
            stamp = memory[FIRST] + packet * constants[SPACING]
            memory[NEWEST], memory[STAMP] = packet, stamp
            received[:] = memory[row + 1 : row + width]
            delay[0] = memory[row] - stamp
            break
    age[0] = t - memory[STAMP]


class PacketChannel(LeafSystem):
    """Carries a signal in packets, of which the receiver keeps the one that was sent last.

    Ports:
        input signal_sent (n).
        output signal_received (n).
        output delay (1) [s]: travel time of the packet in use, 0 before the first.
        output age_of_information (1) [s]: since the packet in use was sent, or since the start
            before the first.

    Update, at t = k period: every `send_period` a packet with the signal is sent; it arrives after
    delay(t) + jitter, unless it is lost, sent in an outage, or slower than `longest`. Then
    signal_received becomes that of the packet sent last among those that have arrived: one that
    was overtaken is dropped, so the received signal never runs backwards, and while nothing
    arrives it holds.
    Initial: signal_received = initial, delay = age_of_information = 0.

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
        super().__init__()
        packets.validate("packets")
        first = check_signal(initial, period)
        packets.check_sampling("packets", period)
        self._stride = round(packets.send_period / period)
        self._period = period
        self._law = packets.delay.parameters()
        self._constants = packets.parameters()
        self._outages = np.array(packets.outages, dtype=np.float64)
        self._seed = seed
        rows = math.ceil(packets.longest / packets.send_period) + 1
        memory = np.zeros(HEAD + rows * (first.size + 1))
        memory[NEWEST] = -1.0
        self._sent = self.DeclareVectorInputPort("signal_sent", first.size)
        self._received = declare_state(self, first, "signal_received")
        self._delay = declare_state(self, 1, "delay")
        self._age = declare_state(self, 1, "age_of_information")
        self._memory = declare_state(self, memory)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._step)

    def _step(self, context: Context, discrete: DiscreteValues) -> None:
        t = context.get_time()
        step_packets(
            t,
            round(t / self._period) % self._stride == 0,
            self._law,
            self._constants,
            self._outages,
            self._seed,
            self._sent.Eval(context),
            discrete.get_mutable_value(self._memory),
            discrete.get_mutable_value(self._received),
            discrete.get_mutable_value(self._delay),
            discrete.get_mutable_value(self._age),
        )
