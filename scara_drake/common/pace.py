"""How a run keeps to the clock, as its own systems see it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass
class Pace:
    """How a run in real time keeps to the clock; whoever paces it keeps this up to date.

    It is no simulation state: nothing that is computed depends on it, only what is shown.

    Attributes:
        lateness: of the simulation behind the clock [s]; below zero it waits for the clock.
        late_ticks: how many ticks were more than 1 ms late so far.
        p99: lateness that 99 % of the ticks so far stay below [s].
        factor: simulated seconds per second, over the last second.
        pictures_dropped: how many pictures the system has not drawn, as the run was behind.
    """

    lateness: float = 0.0
    late_ticks: int = 0
    p99: float = 0.0
    factor: float = 1.0
    pictures_dropped: int = 0
