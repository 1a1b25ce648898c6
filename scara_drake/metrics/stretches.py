"""The stretches of time in which something holds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Stretch:
    """A stretch of time.

    Attributes:
        start: first sample [s].
        end: last sample [s].
        open: whether it lasts to the end of the recording.
    """

    start: float
    end: float
    open: bool

    @property
    def length(self) -> float:
        """From start to end [s]."""
        return self.end - self.start

    def __str__(self) -> str:
        return f"{self.start:.2f} s to {'the end' if self.open else f'{self.end:.2f} s'}"


def stretches(
    times: NDArray[np.float64], holds: NDArray[np.bool_], hold: float = 0.0
) -> list[Stretch]:
    """Return the stretches in which a condition holds, in order.

    Args:
        times: (n,), rising [s].
        holds: (n,), the condition.
        hold: interruptions that are shorter than this are none, and stretches that are shorter are
            left out, unless they last to the end [s].
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[False], holds, [False]])))
    found: list[Stretch] = []
    for first, past in edges.reshape(-1, 2):
        last = times.size - 1 if past == times.size else past - 1
        stretch = Stretch(float(times[first]), float(times[last]), past == times.size)
        if found and stretch.start - found[-1].end < hold:
            stretch = Stretch(found.pop().start, stretch.end, stretch.open)
        found.append(stretch)
    return [each for each in found if each.open or each.length >= hold]
