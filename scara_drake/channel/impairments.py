"""What happens to packets on their way: jitter, loss and outages.

Whether and when a packet arrives is a function of a seed and of its number, see `common.draws`; of
the past counts only whether the link is good or bad.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.channel.delays import LONGEST
from scara_drake.common import checks
from scara_drake.common.draws import gamma, normal, uniform
from scara_drake.common.fields import choice, number
from scara_drake.common.layout import Cell, Layout

Array = NDArray[np.float64]

DISTRIBUTIONS = ("none", "uniform", "normal", "gamma", "lognormal")
NONE, UNIFORM, NORMAL, GAMMA, LOGNORMAL = range(len(DISTRIBUTIONS))
TICK = 1e-9  # [s]; times closer than this are the same
# Streams of random numbers of a seed; `gamma` takes three.
BESIDE = 2**40  # packets after which the stream of losses goes on with those in a shadow
JITTER_STREAM, LOSS_STREAM, CHANGE_STREAM, STREAMS = 0, 3, 4, 5


class JitterRow(NamedTuple):
    """`Jitter` in a kernel; its distribution is the index in `DISTRIBUTIONS`."""

    distribution: float
    mean: float
    std: float


class LossRow(NamedTuple):
    """`Loss` in a kernel."""

    in_good: float
    in_bad: float
    to_bad: float
    to_good: float


JITTER, LOSS = Layout(JitterRow), Layout(LossRow)
jitter_of, loss_of = JITTER.reader(), LOSS.reader()


@dataclass
class Jitter:
    """A random time that each packet takes beside the delay.

    Attributes:
        distribution: none, uniform, normal (cut off at zero), gamma or lognormal. An exponential
            one is gamma with std = mean.
        mean: of the time.
        std: its standard deviation.
    """

    distribution: str = choice("none", DISTRIBUTIONS)
    mean: float = number(0.0, "s", 0.0, LONGEST)
    std: float = number(0.0, "s", 0.0, LONGEST)

    def check_together(self, name: str) -> None:
        """Check that the distribution has such a mean and standard deviation.

        Raises:
            ValueError: it has not.
        """
        if self.distribution == "uniform":
            checks.number(f"{name}.std", self.std, 0.0, self.mean / math.sqrt(3.0))
        if self.distribution in ("gamma", "lognormal"):
            checks.number(f"{name}.mean", self.mean, checks.ABOVE_ZERO, LONGEST)
            checks.number(f"{name}.std", self.std, checks.ABOVE_ZERO, LONGEST)

    def parameters(self) -> Array:
        """Return the fields as `jitter_time` takes them."""
        kind = DISTRIBUTIONS.index(self.distribution)
        return JITTER.pack(distribution=kind, mean=self.mean, std=self.std)


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

    in_good: float = number(0.0, "1", 0.0, 1.0)
    in_bad: float = number(1.0, "1", 0.0, 1.0)
    to_bad: float = number(0.0, "1", 0.0, 1.0)
    to_good: float = number(1.0, "1", 0.0, 1.0)

    def parameters(self) -> Array:
        """Return the fields as `is_lost` takes them."""
        return LOSS.pack(
            in_good=self.in_good, in_bad=self.in_bad, to_bad=self.to_bad, to_good=self.to_good
        )


@njit(cache=True)
def jitter_time(jitter: Array, seed: int, packet: int) -> float:
    """Time [s] that a packet takes beside the delay; it can be negative for a normal one.

    Args:
        jitter: of `Jitter.parameters`.
        seed: of the link.
        packet: its number, 0 or more.
    """
    p = jitter_of(jitter)
    kind, mean, std = int(p.distribution), p.mean, p.std
    stream = seed * STREAMS + JITTER_STREAM
    if kind == UNIFORM:
        return mean + math.sqrt(12.0) * std * (uniform(stream, packet) - 0.5)
    if kind == NORMAL:
        return mean + std * normal(stream, packet)
    if kind == GAMMA:
        return std * std / mean * gamma((mean / std) ** 2, stream, packet)
    if kind == LOGNORMAL:
        variance = math.log(1.0 + (std / mean) ** 2)
        return mean * math.exp(math.sqrt(variance) * normal(stream, packet) - 0.5 * variance)
    return 0.0


@njit(cache=True)
def is_lost(loss: Array, seed: int, packet: int, bad: Cell) -> bool:
    """Whether a packet is lost; moves the link between good and bad.

    Args:
        loss: of `Loss.parameters`.
        seed: of the link.
        packet: its number, 0 or more.
        bad: (), 1 while the link is bad and 0 while it is good, in place.
    """
    p = loss_of(loss)
    is_bad = bad[()] > 0.5
    chance = p.to_good if is_bad else p.to_bad
    if uniform(seed * STREAMS + CHANGE_STREAM, packet) < chance:
        is_bad = not is_bad
    bad[()] = 1.0 if is_bad else 0.0
    return uniform(seed * STREAMS + LOSS_STREAM, packet) < (p.in_bad if is_bad else p.in_good)


@njit(cache=True)
def is_lost_in_shadow(chance: float, seed: int, packet: int) -> bool:
    """Whether a packet is lost where the tool is; drawn beside `is_lost`, whose draws stay."""
    return uniform(seed * STREAMS + LOSS_STREAM, BESIDE + packet) < chance


@njit(cache=True)
def in_outage(outages: Array, t: float) -> bool:
    """Whether t [s] is in one of the outages (2 n,): [start, end)."""
    return np.searchsorted(outages, t + TICK, side="right") % 2 == 1
