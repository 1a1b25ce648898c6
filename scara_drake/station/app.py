"""The web application: the page, its viewer, and the websocket."""

from __future__ import annotations

import asyncio
import logging
from contextlib import suppress
from pathlib import Path
from typing import Final

from starlette.applications import Starlette
from starlette.responses import FileResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp
from starlette.websockets import WebSocket, WebSocketDisconnect

from scara_drake.station.client import Client
from scara_drake.station.gate import Gate
from scara_drake.station.hub import Hub
from scara_drake.station.protocol import BAD_MESSAGE, TOO_MANY, TOO_SLOW
from scara_drake.station.requests import ProtocolError, parse

LOG = logging.getLogger("scara_drake.station")
PAGE: Final = Path(__file__).parent / "page"
CLOSE_TIME: Final = 1.0  # to say goodbye [s]


def make_app(hub: Hub, viewer: Path, token: str, host: str) -> ASGIApp:
    """Return the application.

    Args:
        hub: of the run.
        viewer: the script of Meshcat's viewer.
        token: which every address begins with.
        host: under which it is asked for.
    """

    async def send_viewer(request: object) -> Response:
        return FileResponse(viewer, media_type="text/javascript")

    async def talk(websocket: WebSocket) -> None:
        await _talk(hub, websocket)

    routes = [
        WebSocketRoute("/ws", talk),
        Route("/viewer.js", send_viewer),
        Mount("/", StaticFiles(directory=PAGE, html=True)),
    ]
    return Gate(Starlette(routes=routes), token, host)


async def _talk(hub: Hub, websocket: WebSocket) -> None:
    """Serve one page until it goes, does not read, or says what is no message."""
    await websocket.accept()
    client = hub.join(websocket)
    if client is None:
        await websocket.close(TOO_MANY, "too many pages are open")
        return
    tasks = [
        asyncio.create_task(client.send(hub.clock)),
        asyncio.create_task(_listen(hub, client, websocket)),
    ]
    try:
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        hub.leave(client)  # first: what it held is lost, whatever follows
        for task in tasks:
            task.cancel()
        results = await asyncio.gather(*tasks, return_exceptions=True)
    await _close(client, websocket, results)


async def _listen(hub: Hub, client: Client, websocket: WebSocket) -> None:
    """Hear a page until it goes.

    Raises:
        ProtocolError: it says what is no message, or too many.
    """
    with suppress(WebSocketDisconnect):
        while True:
            message = await websocket.receive()
            if message["type"] == "websocket.disconnect":
                return
            if not client.may_speak(hub.clock()):
                raise ProtocolError("too many messages")
            text = message.get("text")
            if text is None:
                raise ProtocolError("message: bytes, allowed text")
            hub.hear(client, parse(text))


async def _close(client: Client, websocket: WebSocket, results: list[BaseException | None]) -> None:
    """Say in one line why a page is sent away, here and to it."""
    for error in results:
        if isinstance(error, ProtocolError | TimeoutError):
            code = BAD_MESSAGE if isinstance(error, ProtocolError) else TOO_SLOW
            words = str(error) or "it does not read"
            LOG.warning("Station: client %d is sent away: %s", client.number, words)
            with suppress(Exception):
                async with asyncio.timeout(CLOSE_TIME):
                    await websocket.close(code, words[:100])
        elif isinstance(error, Exception) and not isinstance(error, WebSocketDisconnect):
            LOG.error("Station: client %d: %r", client.number, error)
