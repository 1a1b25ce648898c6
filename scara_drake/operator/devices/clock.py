"""What the wall clock says, where a device is sampled."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass


@dataclass
class WallClock:
    """The clock beside a live device; whoever paces the run writes `lateness` into it.

    It is no more simulation state than the device: both are read in the device's event only, and
    what was read is recorded.

    Attributes:
        lateness: of the simulation behind the clock [s].
        now: the receive clock [s], which never jumps.
    """

    lateness: float = 0.0
    now: Callable[[], float] = time.monotonic
