"""A playout buffer at the end of a link: a packet is played a time after it was sent, in order.

A buffer of fixed depth only says when a packet is due, which `flight` knows when it is sent. An
adaptive one learns its depth from the packets that have arrived, see `adaptive`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from scara_drake.channel.delays import LONGEST
from scara_drake.common import checks
from scara_drake.common.fields import ABOVE_ZERO, choice, number
from scara_drake.common.layout import Layout

Array = NDArray[np.float64]

KINDS: Final = ("fixed", "adaptive")
LATE: Final = ("coupling", "use", "drop")


class Adapt(NamedTuple):
    """An adaptive `Playout` in a kernel.

    Attributes:
        share: of the packets that the depth is for.
        keep: share of a weight that is left when the next packet arrives.
        shrink: packets skipped, per tick.
        travel: ticks within which every packet arrives, and one more.
        deep: ticks of the deepest buffer, and one more.
    """

    share: float
    keep: float
    shrink: float
    travel: float
    deep: float


ADAPT = Layout(Adapt)
adapt_of = ADAPT.reader()


@dataclass
class Playout:
    """A buffer that plays each packet `depth` after it was sent, at the first tick from then on.

    So all packets that arrive within the depth are used, each once and in the order of their
    sending, as over a constant delay. An adaptive depth is that percentile of the delays seen so
    far, in whole ticks. It grows at once, and nothing is played until then. It shrinks by a tick
    where the packet that is due is missing, and where it is deeper than it need be by more than a
    tick also by skipping packets, at the rate `shrink`.

    Attributes:
        kind: fixed or adaptive.
        depth: of a fixed buffer; of an adaptive one the first.
        percentile: of the delays, within an adaptive depth.
        window: packets over which an adaptive one forgets, the older ones exponentially.
        maximum: of an adaptive depth.
        shrink: share of the packets that are skipped while an adaptive depth is too large.
        late: what becomes of a packet that comes after its time: use it, if none that was sent
            later has been played, drop it, or as the coupling says; without one it is used.
    """

    kind: str = choice("fixed", KINDS)
    depth: float = number(0.0, "s", 0.0, LONGEST)
    percentile: float = number(99.0, "%", ABOVE_ZERO, 100.0)
    window: float = number(1000.0, "1", 1.0, 1e6)
    maximum: float = number(0.5, "s", 0.0, LONGEST)
    shrink: float = number(0.01, "1", 0.0, 0.5)
    late: str = choice("coupling", LATE)

    @property
    def adaptive(self) -> bool:
        """Whether the depth follows the delays."""
        return self.kind == "adaptive"

    @property
    def uses_late(self) -> bool:
        """Whether a late packet is used."""
        return self.late != "drop"

    def check_together(self, name: str) -> None:
        """Check that an adaptive depth starts within its bound.

        Raises:
            ValueError: it does not.
        """
        if self.adaptive:
            checks.number(f"{name}.depth", self.depth, 0.0, self.maximum)

    def deepest(self, longest: float) -> float:
        """Longest time [s] that a packet waits that takes up to `longest` [s]."""
        return max(min(self.maximum, longest), self.depth) if self.adaptive else self.depth

    def parameters(self, longest: float, period: float) -> Array:
        """Return what kernels need of an adaptive one.

        Args:
            longest: travel of a packet [s].
            period: of the ticks [s].
        """
        return ADAPT.pack(
            share=self.percentile / 100.0,
            keep=1.0 - 1.0 / self.window,
            shrink=self.shrink,
            travel=math.ceil(longest / period) + 2,
            deep=math.ceil(self.deepest(longest) / period) + 2,
        )
