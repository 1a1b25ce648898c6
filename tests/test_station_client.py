"""A page is sent the newest, as fast as it takes it: the clients and the middle of the server."""

from __future__ import annotations

import asyncio
import json
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import umsgpack
from station_rig import frame_at

from scara_drake.station import client as client_module
from scara_drake.station.client import MAX_WAITING, Client
from scara_drake.station.hub import Facts, Hub
from scara_drake.station.protocol import FRAMES_IN_FLIGHT
from scara_drake.station.records import Mailboxes, make_mailboxes
from scara_drake.station.requests import Drawn, View

Commands = dict[tuple[str, str], dict[str, Any]]  # by path and type


class Socket:
    """Keeps what it is sent; while it is `deaf` sending never ends."""

    def __init__(self) -> None:
        self.texts: list[dict[str, Any]] = []
        self.pictures: list[bytes] = []
        self.deaf = False

    async def send_text(self, data: str) -> None:
        await self._read()
        self.texts.append(json.loads(data))

    async def send_bytes(self, data: bytes) -> None:
        await self._read()
        self.pictures.append(data)

    async def _read(self) -> None:
        while self.deaf:
            await asyncio.sleep(0.01)

    def shown(self) -> list[int]:
        return [int.from_bytes(picture[:4], "little") for picture in self.pictures]


async def settle() -> None:
    for _ in range(20):
        await asyncio.sleep(0)


def picture(text: bytes) -> Any:
    return lambda: [text]


class GatedSocket(Socket):
    """Sends when its gate opens."""

    def __init__(self) -> None:
        super().__init__()
        self.gate = asyncio.Event()

    async def _read(self) -> None:
        await self.gate.wait()


@pytest.mark.parametrize("steps", range(6))
def test_a_page_that_is_left_while_a_message_goes_out_is_left(steps: int) -> None:
    async def scene() -> None:
        socket = GatedSocket()
        client = Client(1, socket, [], True)
        client.show({"type": "telemetry"}, 0.0, None)  # type: ignore[typeddict-item]
        task = asyncio.create_task(client.send(lambda: 0.0))
        await settle()
        socket.gate.set()
        for _ in range(steps):  # wherever the message is on its way out
            await asyncio.sleep(0)
        task.cancel()
        await asyncio.wait([task], timeout=1.0)
        assert task.cancelled()

    asyncio.run(scene())


def test_a_page_that_draws_slowly_gets_the_newest_picture_only() -> None:
    async def scene() -> None:
        socket = Socket()
        client = Client(1, socket, [b"scene"], True)
        task = asyncio.create_task(client.send(lambda: 10.0))
        for k in range(10):
            client.show({"type": "telemetry", "t": k}, float(k), picture(b"%d" % k))  # type: ignore[typeddict-item]
            await settle()
        assert socket.shown() == [1, 2]
        assert len(socket.pictures) == FRAMES_IN_FLIGHT
        assert socket.pictures[0].endswith(b"scene")
        assert [text["t"] for text in socket.texts] == list(range(10))  # these are not left out
        client.drawn(1, 10.0)
        client.drawn(2, 10.0)
        await settle()
        assert socket.pictures[-1].endswith(b"9")
        client.show({"type": "telemetry"}, 10.0, None)  # type: ignore[typeddict-item]
        await settle()
        assert socket.texts[-1]["dropped"] == 10 - 2
        task.cancel()

    asyncio.run(scene())


def test_the_lag_is_that_of_the_picture_on_the_screen() -> None:
    async def scene() -> None:
        client = Client(1, Socket(), [], True)
        task = asyncio.create_task(client.send(lambda: 0.0))
        client.show({"type": "telemetry"}, 0.0, None)  # type: ignore[typeddict-item]
        await settle()
        assert client.lag(0.0) is None
        client.drawn(1, 0.5)  # the scene itself: no picture of a moment
        client.show({"type": "telemetry"}, 5.0, picture(b""))  # type: ignore[typeddict-item]
        await settle()
        assert client.lag(5.5) == pytest.approx(0.5)  # it has not been drawn yet
        client.drawn(2, 5.75)
        assert client.lag(7.0) == pytest.approx(0.75)
        client.drawn(99, 8.0)  # a number that was never sent
        assert client.lag(8.0) == pytest.approx(0.75)
        task.cancel()

    asyncio.run(scene())


def test_who_does_not_read_is_given_up_and_little_is_kept_for_him(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(client_module, "SEND_TIMEOUT", 0.05)

    async def scene() -> None:
        socket = Socket()
        socket.deaf = True
        client = Client(1, socket, [b"scene"], True)
        for k in range(10 * MAX_WAITING):
            client.tell({"type": "event", "k": k})
        with pytest.raises(TimeoutError):
            await client.send(lambda: 0.0)
        assert len(client._waiting) < MAX_WAITING

    asyncio.run(scene())


def paths(message: bytes) -> Commands:
    found, place = {}, 4
    while place < len(message):
        length = int.from_bytes(message[place : place + 4], "little")
        command = umsgpack.unpackb(message[place + 4 : place + 4 + length])
        found[command["path"], command["type"]] = command
        place += 4 + length
    return found


def make_hub(delayed: bool) -> tuple[Hub, Mailboxes]:
    file, places = make_mailboxes()
    file.close()
    clock = SimpleNamespace(now=0.0)
    return Hub(places, Facts("test", 1.0, [], [], delayed), lambda: clock.now), places


async def last_picture(hub: Hub, places: Mailboxes, delayed: bool) -> Commands:
    socket = Socket()
    client = hub.join(socket)
    assert client is not None
    task = asyncio.create_task(client.send(lambda: 0.0))
    hub.hear(client, View(delayed))
    for k in range(1, 31):
        q = np.zeros(12)
        q[0] = k / 10  # the mast, 1 m/s at 10 frames a second
        places.frame.write(frame_at(k / 10, state=q, delay_down=0.5, wall=float(k)))
        hub.tick()
        await settle()
        for number in socket.shown():
            hub.hear(client, Drawn(number))
        await settle()
    task.cancel()
    return paths(socket.pictures[-1])


def height(command: dict[str, Any]) -> float:
    return float(command["matrix"][14])


def test_a_delayed_view_is_as_old_as_the_force_and_its_ghost_is_not() -> None:
    async def scene() -> tuple[Commands, Commands]:
        late = await last_picture(*make_hub(True), delayed=True)
        live = await last_picture(*make_hub(True), delayed=False)
        return late, live

    late, live = asyncio.run(scene())
    robot, ghost = (
        ("/meshcat/robot/link_1", "set_transform"),
        ("/meshcat/undelayed", "set_property"),
    )
    now = ("/meshcat/undelayed/link_1", "set_transform")
    assert height(live[robot]) - height(late[robot]) == pytest.approx(0.5)
    assert height(late[now]) == pytest.approx(height(live[robot]))
    assert late[ghost]["value"] is True
    assert live[ghost]["value"] is False


def test_a_hub_without_pages_or_frames_waits() -> None:
    hub, _ = make_hub(False)
    hub.tick()


def test_the_real_time_factor_falls_while_no_frame_comes() -> None:
    from scara_drake.station.telemetry import Others, Telemeter

    telemeter, others = Telemeter(), Others([0.0, 0.0], {}, 1, None)
    for k in range(30):
        frame = frame_at(k / 30, wall=k / 30)
        telemeter.take(frame)
    told = [telemeter.tell(frame, others, now) for now in (1.0, 2.0, 3.0)]
    factors = [one["realtime_factor"] or 0.0 for one in told]
    assert factors[0] == pytest.approx(1.0, abs=0.05)
    assert factors[0] > factors[1] > factors[2] > 0.0
