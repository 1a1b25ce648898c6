"""Who gets in: nobody without the token, no page of another origin, and not too many."""

from __future__ import annotations

import ipaddress
import secrets
import socket
from typing import Final
from urllib.parse import urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from uvicorn.protocols.http.h11_impl import H11Protocol

MAX_CONNECTIONS: Final = 200
REQUEST_TIME: Final = 5.0  # in which a connection has to ask for something [s]

# Meshcat's panel writes its own style sheet, so styles may stand in the page.
SECURITY_HEADERS: Final = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; connect-src 'self'; "
    "style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; font-src 'self' data:; "
    "frame-ancestors 'none'; base-uri 'none'; form-action 'none'",
    "Cache-Control": "no-store",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",  # the address has the token
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
}


class Gate:
    """Lets only those to an application who know the token, which is the first part of the path.

    The name under which the server is asked for has to be an address or a name of this machine, so
    that no other name leads here (DNS rebinding); and what a browser asks for on behalf of a page
    has to be for a page from here.

    Args:
        app: what is behind it; it sees paths without the token.
        token: the word.
        host: under which it may be asked for as well.
    """

    def __init__(self, app: ASGIApp, token: str, host: str) -> None:
        self._app, self._token = app, token.encode()
        self._hosts = {"localhost", socket.gethostname().lower(), host.lower()}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or refuse it."""
        if scope["type"] == "lifespan":
            return await self._app(scope, receive, send)
        told, slash, rest = scope["path"].removeprefix("/").partition("/")
        if not secrets.compare_digest(told.encode(), self._token) or not self._is_ours(scope):
            return await _refuse(scope, receive, send)

        async def send_safely(message: Message) -> None:
            if message["type"] == "http.response.start":
                MutableHeaders(scope=message).update(SECURITY_HEADERS)
            await send(message)

        if not slash and scope["type"] == "http":  # relative addresses need it
            return await RedirectResponse(f"/{told}/")(scope, receive, send_safely)
        await self._app({**scope, "path": f"/{rest}", "raw_path": b""}, receive, send_safely)
        return None

    def _is_ours(self, scope: Scope) -> bool:
        headers = Headers(scope=scope)
        host, origin = headers.get("host", ""), headers.get("origin")
        if not self._is_this_machine(host):
            return False
        return origin is None or urlsplit(origin).netloc.lower() == host.lower()

    def _is_this_machine(self, host: str) -> bool:
        try:
            name = urlsplit(f"//{host}").hostname or ""
        except ValueError:
            return False
        return name in self._hosts or _is_address(name)


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


async def _refuse(scope: Scope, receive: Receive, send: Send) -> None:
    """Answer as if there was nothing: 404, or 403 to a websocket."""
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.close", "code": 1008})
    else:
        await Response(status_code=404, headers=SECURITY_HEADERS)(scope, receive, send)


class BoundedProtocol(H11Protocol):
    """Closes connections beyond MAX_CONNECTIONS, and those that ask for nothing."""

    def connection_made(self, transport) -> None:  # type: ignore[no-untyped-def]  # asyncio's
        """Begin a connection, or end it at once."""
        super().connection_made(transport)
        if len(self.connections) > MAX_CONNECTIONS:
            transport.abort()
        else:
            self.loop.call_later(REQUEST_TIME, self._end_if_silent)

    def _end_if_silent(self) -> None:
        if self.scope is None:
            self.transport.abort()
