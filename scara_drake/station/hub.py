"""The middle of the server: frames of the simulation to the pages, and what they say back."""

from __future__ import annotations

import asyncio
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from functools import cache, partial
from typing import Any, Final, NamedTuple

import numpy as np

from scara_drake.display.look import Part
from scara_drake.recordings.surfaces import Block
from scara_drake.station import telemetry
from scara_drake.station.client import Client, Socket
from scara_drake.station.helm import Helm
from scara_drake.station.protocol import SLOW_SCENE, TELEMETRY_RATE, VERSION, Control, Event, Hello
from scara_drake.station.records import Mailboxes
from scara_drake.station.requests import ControlRequest, Drawn, Input, Request, Setting, View
from scara_drake.station.scene import Scene
from scara_drake.vectors import BUTTON_NAMES, ORIENTATION_NAMES, STICK_NAMES

MAX_CLIENTS: Final = 32
REMEMBERED: Final = 20.0  # of frames, for a delayed view [s]
MAX_EVENTS: Final = 30  # that a new page is told


class Facts(NamedTuple):
    """What the server is told of a run at its start.

    Attributes:
        scenario: its name.
        duration: [s].
        blocks: the surfaces that are drawn.
        marks: what is drawn besides, see `marks`.
        delayed: whether a page sees the robot as late as the operator feels it, to begin with.
        max_force: from which on the robot's supervisor backs off [N]; None where there is none.
    """

    scenario: str
    duration: float
    blocks: list[Block]
    marks: list[Part]
    delayed: bool
    max_force: float | None = None


class Hub:
    """Who is there, and what they are sent."""

    def __init__(
        self, mailboxes: Mailboxes, facts: Facts, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self.helm, self.clock = Helm(mailboxes.input), clock
        self._mailboxes, self._facts = mailboxes, facts
        self._scene = Scene(facts.blocks, facts.marks)
        self._views = self._scene.views()
        self._telemeter = telemetry.Telemeter()
        self._frames: deque[Any] = deque(maxlen=int(REMEMBERED * TELEMETRY_RATE))
        self._events: deque[Event] = deque(maxlen=MAX_EVENTS)
        self._clients: dict[int, Client] = {}
        self._given = 0
        self._ended: Mapping[str, Any] | None = None

    def join(self, socket: Socket) -> Client | None:
        """Take a page in and greet it; None where there are too many."""
        if len(self._clients) >= MAX_CLIENTS:
            return None
        self._given += 1
        client = Client(self._given, socket, self._scene.commands, self._facts.delayed)
        self._clients[client.number] = client
        client.tell(self._hello(client))
        for event in self._events:
            client.tell(event)
        if self._ended is not None:
            client.tell(self._ended)
        self._tell_control()
        return client

    def leave(self, client: Client) -> None:
        """Let a page go; what it held is lost."""
        if self._clients.pop(client.number, None) is not None:
            self.helm.leave(client.number)
            self._tell_control()

    def hear(self, client: Client, said: Request) -> None:
        """Do what a page says; tell it why not."""
        refused, now = "", self.clock()
        if isinstance(said, Drawn):
            client.drawn(said.frame, now)
        elif isinstance(said, View):
            client.delayed = said.delayed
        elif isinstance(said, Input):
            refused = self.helm.input(client.number, said, now)
            if not refused and said.device != client.name:
                client.name = said.device
                self._tell_control()
        elif isinstance(said, Setting):
            refused = self.helm.set(client.number, said)
        elif isinstance(said, ControlRequest):
            refused = self.helm.ask(client.number, said, self._clients)
            if not refused:
                self._tell_control()
        if refused:
            client.tell({"type": "refused", "words": refused})

    async def run(self) -> None:
        """Look for frames and hand them on, for ever; a late tick is left out."""
        period = 1.0 / TELEMETRY_RATE
        due = self.clock()
        while True:
            self.tick()
            due = max(due + period, self.clock())
            await asyncio.sleep(due - self.clock())

    def tick(self) -> None:
        """Hand the newest frame on."""
        found = self._mailboxes.frame.read()
        fresh = found is not None and (not self._frames or found["wall"] > self._frames[-1]["wall"])
        if fresh:
            for event in self._telemeter.take(found):
                self._events.append(event)
                self._tell_all(event)
            self._frames.append(found)
        if not self._frames or not self._clients:
            return
        frame = self._frames[-1]
        told = self._telemeter.tell(frame, self._others(), self.clock())
        pictures = cache(partial(self._picture, frame))
        for client in self._clients.values():
            picture = partial(pictures, client.delayed) if fresh else None
            client.show(told, float(frame["wall"]), picture)

    def end(self, ended: Mapping[str, Any]) -> None:
        """Tell all that the run is over."""
        self._ended = {**ended, "type": "ended"}
        self._tell_all(self._ended)

    def _picture(self, frame: Any, delayed: bool) -> list[bytes]:
        delay = float(frame["delay_down"][0])
        if not delayed or not np.isfinite(delay) or delay <= 0.0:
            return self._scene.picture(frame)
        return self._scene.picture(self._as_of(float(frame["t"]) - delay), frame)

    def _as_of(self, t: float) -> Any:
        """Return the newest frame that is not after `t` [s], or the oldest there is."""
        older = (frame for frame in reversed(self._frames) if frame["t"] <= t)
        return next(older, self._frames[0])

    def _others(self) -> telemetry.Others:
        return telemetry.Others(
            self._rumble(), self.helm.settings, len(self._clients), self.helm.holder
        )

    def _rumble(self) -> list[float]:
        record = self._mailboxes.rumble.read()
        if record is None or self.clock() >= record["until"]:
            return [0.0, 0.0]
        return [min(max(float(record[motor]), 0.0), 1.0) for motor in ("low", "high")]

    def _hello(self, client: Client) -> Hello:
        return {
            "type": "hello",
            "version": VERSION,
            "scenario": self._facts.scenario,
            "duration": self._facts.duration,
            "axes": list(STICK_NAMES),
            "orientation": list(ORIENTATION_NAMES),
            "buttons": list(BUTTON_NAMES),
            "joints": telemetry.joint_facts(),
            "settings": telemetry.setting_facts(self.helm.settings),
            "views": self._views,
            "delayed": client.delayed,
            "slow_scene": SLOW_SCENE,
            "max_force": self._facts.max_force,
            "control": self._control(client),
        }

    def _control(self, client: Client) -> Control:
        return {
            "type": "control",
            "you": client.number,
            "holder": self.helm.holder,
            "mine": self.helm.holder == client.number,
            "clients": [{"id": one.number, "name": one.name} for one in self._present()],
        }

    def _present(self) -> Iterator[Client]:
        yield from self._clients.values()

    def _tell_control(self) -> None:
        self.helm.there_are(len(self._clients))
        for client in self._present():
            client.tell(self._control(client))

    def _tell_all(self, message: Mapping[str, Any]) -> None:
        for client in self._present():
            client.tell(message)
