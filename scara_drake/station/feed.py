"""What the station shows of a run, left for its server."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import Context, LeafSystem

from scara_drake.common.pace import Pace
from scara_drake.environment import Surface
from scara_drake.station.mailbox import Mailbox
from scara_drake.station.records import MAX_SURFACES, MAX_TASK, SIGNALS, empty_frame

PERIOD = 0.033  # [s]
OFFSET = (
    1e-3  # a publish event sees the state before an update of its own time: come just after [s]
)


class StationFeed(LeafSystem):
    """Leaves a frame for the station's server; it never waits for it.

    Input ports (each may stay unconnected): `records.SIGNALS`.
    Publish (every PERIOD): the values of the ports, the time, where the surfaces that move are, how
    the run keeps up with the clock, and a line about the task.

    Args:
        mailbox: of frames.
        surfaces: those that are drawn, in their order.
        task: the line, where there is one.

    Attributes:
        pace: how the run keeps to the clock; who paces it writes there.
    """

    __slots__ = ()  # so that it can be freed, see `Collectable`

    def __init__(
        self,
        mailbox: Mailbox,
        surfaces: Sequence[Surface] = (),
        task: Callable[[Context], str] | None = None,
    ) -> None:
        super().__init__()
        self._mailbox, self._task, self.pace = mailbox, task, Pace()
        self._moving = [
            (index, surface)
            for index, surface in enumerate(surfaces[:MAX_SURFACES])
            if surface.motion is not None
        ]
        self._ports = [self.DeclareVectorInputPort(name, size) for name, size in SIGNALS.items()]
        self.DeclareInitializationPublishEvent(self._leave)
        self.DeclarePeriodicPublishEvent(PERIOD, OFFSET, self._leave)

    def _leave(self, context: Context) -> None:
        frame, t = empty_frame(), context.get_time()
        for port in self._ports:
            if port.HasValue(context):
                frame[port.get_name()] = port.Eval(context)
        for index, surface in self._moving:
            frame["surfaces"][index] = moved(surface, t)
        for name in ("lateness", "late_ticks", "p99"):
            frame[name] = getattr(self.pace, name)
        if self._task is not None:
            frame["task"] = self._task(context).encode()[:MAX_TASK]
        frame["t"], frame["wall"] = t, time.monotonic()
        self._mailbox.write(frame)


def moved(surface: Surface, t: float) -> NDArray[np.float64]:
    """Return how far (3,) [m] a surface is at `t` [s] from where it is at rest."""
    return np.asarray(surface.pose_at(t).translation() - surface.pose().translation())
