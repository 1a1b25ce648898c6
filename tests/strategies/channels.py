"""Channels, as tables of what is on the receiver's port: delay, jitter, loss, bursts, outages.

A table (steps,) holds the number of the packet that came last at each tick, 0 before the first, as
`coupling_rig.Rig.run` takes it. Packets overtake each other, and the one that came last may be an
old one: an end has to drop it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from hypothesis import strategies as st

PERIOD = 1e-3  # [s]


@dataclass(frozen=True)
class Conditions:
    """What a channel does to packets that are sent each `PERIOD`.

    Attributes:
        delay: mean [s].
        swing: of the delay about the mean, a sine [s]; it is cut at zero.
        rate: of that sine [rad/s].
        jitter: "uniform" from 0 to `spread`, "gaussian" with it, or "exponential" with its mean.
        spread: of the jitter [s].
        loss: share of the packets.
        burst: mean number of packets that are lost together.
        outages: how many there are.
        longest: an outage at most [s].
        seed: of all draws.
    """

    delay: float = 0.0
    swing: float = 0.0
    rate: float = 1.0
    jitter: str = "uniform"
    spread: float = 0.0
    loss: float = 0.0
    burst: float = 1.0
    outages: int = 0
    longest: float = 1.0
    seed: int = 0

    def shown(self, steps: int) -> np.ndarray:
        """The number of the packet on the port at each tick (steps,)."""
        random = np.random.default_rng(self.seed)
        t = PERIOD * np.arange(steps)
        drawn = {
            "uniform": random.uniform(0.0, 1.0, steps),
            "gaussian": random.normal(0.0, 1.0, steps),
            "exponential": random.exponential(1.0, steps),
        }[self.jitter]
        travel = self.delay + self.swing * np.sin(self.rate * t) + self.spread * drawn
        arrive = np.arange(steps) + np.round(np.maximum(travel, 0.0) / PERIOD).astype(int)
        never = 2 * steps
        arrive[_lost(random, steps, self.loss, self.burst)] = never
        for _ in range(self.outages):
            start = random.integers(0, steps)
            arrive[start : start + round(random.uniform(0.0, self.longest) / PERIOD)] = never
        shown = np.zeros(steps + 1, dtype=np.int64)
        (sent,) = np.nonzero(arrive < steps)
        shown[arrive[sent] + 1] = sent + 1  # row k + 1 is written at tick k; the last one stays
        came = np.where(shown > 0, np.arange(steps + 1), 0)
        return shown[np.maximum.accumulate(came)][:steps]


def _lost(random: np.random.Generator, steps: int, loss: float, burst: float) -> np.ndarray:
    """Whether each packet (steps,) is lost: a share `loss` of them, on average `burst` together."""
    if loss <= 0.0:
        return np.zeros(steps, dtype=bool)
    good = random.geometric(max(min(loss / (burst * (1.0 - loss)), 1.0), 1e-9), steps)
    bad = random.geometric(1.0 / burst, steps)
    spans = np.stack([good, bad], axis=1).ravel()
    spans = np.minimum(spans, steps)[: 1 + np.searchsorted(np.cumsum(spans), steps)]
    return np.repeat(np.arange(spans.size) % 2 == 1, spans)[:steps]


def conditions(longest: float = 1.0) -> st.SearchStrategy[Conditions]:
    """Channels whose mean delay is up to `longest` [s], the swing and the jitter as much again."""
    return st.builds(
        Conditions,
        delay=st.floats(0.0, longest),
        swing=st.sampled_from([0.0, 0.0, 0.5 * longest, longest]),
        rate=st.floats(0.2, 5.0),
        jitter=st.sampled_from(["uniform", "gaussian", "exponential"]),
        spread=st.sampled_from([0.0, 0.005, 0.05, 0.3 * longest]),
        loss=st.floats(0.0, 0.5),
        burst=st.sampled_from([1.0, 3.0, 20.0]),
        outages=st.integers(0, 2),
        longest=st.just(1.5),
        seed=st.integers(0, 2**31),
    )
