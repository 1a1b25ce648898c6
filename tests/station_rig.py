"""A station's server without a run, and pages that talk to it."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any, Self

import numpy as np
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

from scara_drake.joints import HOME
from scara_drake.scenario import load_scenario
from scara_drake.station.place import Place
from scara_drake.station.records import Mailboxes, empty_frame
from scara_drake.station.station import Station

PATIENCE = 30.0  # for what comes in milliseconds on a machine that does nothing else [s]


def wait_until(true: Callable[[], bool]) -> None:
    end = time.monotonic() + PATIENCE
    while not true():
        assert time.monotonic() < end, "it never came"
        time.sleep(0.01)


class Page:
    """What a page does, without a browser: it answers each picture as one that is drawn."""

    def __init__(self, address: str, **options: Any) -> None:
        url = f"ws{address.removeprefix('http')}ws"
        opened = connect(
            url,
            max_size=None,
            open_timeout=PATIENCE,
            close_timeout=0.1,
            compression=None,
            **options,
        )
        self.socket: ClientConnection = opened.__enter__()
        self.pictures: list[bytes] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.socket.close()

    def say(self, **message: Any) -> None:
        self.socket.send(json.dumps(message))

    def hears(self, kind: str) -> dict[str, Any]:
        """The next message of a kind; the others before it are forgotten."""
        while True:
            message = self.socket.recv(PATIENCE)
            if isinstance(message, bytes):
                self.pictures.append(message)
                self.say(type="drawn", frame=int.from_bytes(message[:4], "little"))
            elif (found := json.loads(message))["type"] == kind:
                return dict(found)

    def is_sent_away(self) -> int:
        """The code with which the server closes the connection."""
        with suppress(ConnectionClosed):
            while True:
                self.socket.recv(PATIENCE)
        assert self.socket.close_code is not None
        return self.socket.close_code

    def takes(self) -> None:
        self.say(type="control", action="take")
        while not self.hears("control")["mine"]:
            pass

    def moves(self, *axes: float, **buttons: bool) -> None:
        self.say(type="input", axes=list(axes), buttons=buttons, device="a pad")


@contextmanager
def serving(place: Place | None = None, scenario: str = "teleoperation") -> Iterator[Station]:
    station = Station(load_scenario(scenario), place or Place())
    try:
        yield station
    finally:
        station.close()


def shared_by(station: Station) -> Mailboxes:
    """What the run has of a station; no run is there to use it."""
    return station._mailboxes


def frame_at(t: float, **values: Any) -> Any:
    frame = empty_frame()
    frame["t"], frame["wall"] = t, time.monotonic()
    frame["state"] = np.concatenate([HOME, np.zeros(6)])
    for name, value in values.items():
        frame[name] = value
    return frame
