"""What a recording tells of its links: the packets that came, and the time in which none did."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from scara_drake.metrics.stretches import Stretch, stretches

Array = NDArray[np.float64]

LINKS: Final = ("up", "down")
OUTAGE: Final = 0.1  # [s] without a packet, from which on it is called an outage
NUMBER: Final = 8.0  # [B]: of a number in a packet, a float64; a float32 has 4
HEADER: Final = 28.0  # [B]: of a packet, 20 of IPv4 (RFC 791) and 8 of UDP (RFC 768)
BYTE: Final = 8.0  # [bit]
TICKS: Final = 5e-3  # [s], above any time step: the age is that of the tick before the sample


@dataclass(frozen=True)
class Traffic:
    """The packets of a link.

    Attributes:
        sent: how many.
        lost: how many of them never arrive.
        late: how many come after the time at which a buffer plays them; 0 without one.
        late_used: how many of those were used; the others were dropped.
        skipped: how many were passed over by a buffer that became less deep.
        longest_gap: without a packet that could be used [s].
        outages: gaps longer than `OUTAGE`.
        silent: since the last packet, at the end of the recording [s].
        duration: of the recording [s].
        numbers: in a packet; NaN where the recording does not say.
    """

    sent: int
    lost: int
    late: int
    late_used: int
    skipped: int
    longest_gap: float
    outages: tuple[Stretch, ...]
    silent: float
    duration: float = math.nan
    numbers: float = math.nan

    @property
    def packets_per_second(self) -> float:
        """How many are sent, on average [1/s]."""
        return self.sent / self.duration if self.duration > 0.0 else math.nan

    def kilobits_per_second(self, number: float = NUMBER, header: float = HEADER) -> float:
        """Return what the packets sent take of a network, on average [kbit/s].

        Args:
            number: size of a number in a packet [B].
            header: size of what the network adds to each packet [B].
        """
        size = BYTE * (header + number * self.numbers)
        return 1e-3 * size * self.packets_per_second

    @property
    def received(self) -> int:
        """How many arrived, or are still on their way."""
        return self.sent - self.lost


def silence(recording: xr.Dataset, link: str) -> Array:
    """Time (time,) [s] since the packet in use arrived.

    Before the first one it counts from when that would have arrived, had it been sent at the start;
    zero throughout for a link without packets.
    """
    t = recording.time.values
    if f"age_{link}" not in recording:
        return np.zeros(t.size)
    age, delay = recording[f"age_{link}"].values, recording[f"delay_{link}"].values
    silent = np.maximum(age - delay, 0.0)
    arrived = (age < t - TICKS) | (delay > 0.0)
    first = int(np.argmax(arrived)) if arrived.any() else t.size
    travel = delay[first] if first < t.size else 0.0
    silent[:first] = np.maximum(t[:first] - travel, 0.0)
    return silent


def traffic(recording: xr.Dataset, link: str) -> Traffic | None:
    """Return what became of the packets of the link "up" or "down"; None if it has none."""
    if f"packets_sent_{link}" not in recording:
        return None
    t, silent = recording.time.values, silence(recording, link)
    gaps = stretches(t, silent > OUTAGE)

    def count(name: str) -> int:
        name = f"packets_{name}_{link}"
        return int(recording[name].values[-1]) if name in recording else 0

    return Traffic(
        sent=count("sent"),
        lost=count("lost"),
        late=count("late"),
        late_used=count("late_used"),
        skipped=count("skipped"),
        longest_gap=float(silent.max()),
        outages=tuple(Stretch(max(gap.start - OUTAGE, 0.0), gap.end, gap.open) for gap in gaps),
        silent=float(silent[-1]),
        duration=float(t[-1] - t[0]),
        numbers=float(recording.attrs.get(f"packet_numbers_{link}", math.nan)),
    )
