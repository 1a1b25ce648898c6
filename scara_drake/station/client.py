"""One page that is connected: what it is told, as fast as it takes it and no faster."""

from __future__ import annotations

import asyncio
import json
from collections import deque
from collections.abc import Callable, Mapping
from typing import Any, Final, Protocol

from scara_drake.station.protocol import FRAMES_IN_FLIGHT, Telemetry
from scara_drake.station.scene import pack

MAX_WAITING: Final = 64  # messages that are not telemetry
SEND_TIMEOUT: Final = 5.0  # of one message [s]
RATE: Final = 200.0  # of what a page may say [Hz]
BURST: Final = 400.0  # messages at once


class Socket(Protocol):
    """What a client is sent through: a Starlette WebSocket."""

    async def send_text(self, data: str) -> None:
        """Send a text; it waits while the other end does not read."""

    async def send_bytes(self, data: bytes) -> None:
        """Send bytes, likewise."""


class Client:
    """A page, and what waits to be sent to it: of pictures and telemetry only the newest.

    Args:
        number: of the client, never given twice.
        socket: to it.
        scene: the commands of its first picture.
        delayed: whether it sees the robot as late as the operator feels it.

    Attributes:
        name: what it calls its device, "" before it has said so.
    """

    def __init__(self, number: int, socket: Socket, scene: list[bytes], delayed: bool) -> None:
        self.number, self.delayed, self.name = number, delayed, ""
        self._socket = socket
        self._news = asyncio.Event()
        self._waiting: deque[str] = deque(maxlen=MAX_WAITING)
        self._telemetry: Telemetry | None = None
        self._picture: tuple[float, Callable[[], list[bytes]]] | None = (0.0, lambda: scene)
        self._shown = 0
        self._in_flight: dict[int, float] = {}
        self._lag: float | None = None
        self._dropped = 0
        self._allowance, self._heard = BURST, 0.0

    def tell(self, message: Mapping[str, Any]) -> None:
        """Let a message wait; beyond MAX_WAITING the oldest is forgotten."""
        self._waiting.append(json.dumps(message, allow_nan=False))
        self._news.set()

    def show(
        self, telemetry: Telemetry, wall: float, picture: Callable[[], list[bytes]] | None
    ) -> None:
        """Let telemetry, and a picture of something at `wall` [s], take the place of older ones."""
        self._telemetry = telemetry
        if picture is not None:
            self._dropped += self._picture is not None
            if self._picture is None or self._shown:  # the scene itself is never left out
                self._picture = (wall, picture)
        self._news.set()

    def drawn(self, frame: int, now: float) -> None:
        """Note that a picture is on the screen at `now` [s]."""
        wall = self._in_flight.pop(frame, 0.0)
        if wall:
            self._lag = now - wall
        for older in [other for other in self._in_flight if other < frame]:
            del self._in_flight[older]
        self._news.set()

    def lag(self, now: float) -> float | None:
        """Return how old the picture on the screen is [s]; None before the first."""
        waiting = [now - wall for wall in self._in_flight.values() if wall]
        known = [] if self._lag is None else [self._lag]
        return max([*waiting, *known], default=None)

    def may_speak(self, now: float) -> bool:
        """Whether it says no more than RATE; counts one message."""
        self._allowance = min(self._allowance + RATE * (now - self._heard), BURST) - 1.0
        self._heard = now
        return self._allowance > 0.0

    async def send(self, clock: Callable[[], float]) -> None:
        """Send what there is, for ever.

        Raises:
            TimeoutError: the page does not read.
        """
        while True:
            await self._news.wait()
            self._news.clear()
            while self._waiting:
                await self._send_text(self._waiting.popleft())
            if (telemetry := self._telemetry) is not None:
                self._telemetry = None
                own: Mapping[str, Any] = {"lag": self.lag(clock()), "dropped": self._dropped}
                await self._send_text(json.dumps({**telemetry, **own}, allow_nan=False))
            if self._picture is not None and len(self._in_flight) < FRAMES_IN_FLIGHT:
                (wall, commands), self._picture = self._picture, None
                self._shown += 1
                self._in_flight[self._shown] = wall
                message = pack(self._shown, commands())
                async with asyncio.timeout(SEND_TIMEOUT):
                    await self._socket.send_bytes(message)

    async def _send_text(self, text: str) -> None:
        # Not by wait_for: where a message is out just then, that forgets to be cancelled.
        async with asyncio.timeout(SEND_TIMEOUT):
            await self._socket.send_text(text)
