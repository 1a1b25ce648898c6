"""The server of the station: a process of its own, so that no page can delay the simulation.

It is told what to serve in one line on its input, says in one line on its output where it listens
or why it cannot, is told in another line that the run is over, and ends when its input does: with
the run, however that ends.
"""

from __future__ import annotations

import asyncio
import asyncio.constants
import json
import logging
import os
import socket
import ssl
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

import numpy as np
import uvicorn

from scara_drake.display.look import Part
from scara_drake.recordings.surfaces import read_blocks
from scara_drake.station.app import make_app
from scara_drake.station.gate import BoundedProtocol
from scara_drake.station.hub import Facts, Hub
from scara_drake.station.protocol import MAX_MESSAGE
from scara_drake.station.records import map_mailboxes

LOG = logging.getLogger("scara_drake.station")
NICE: Final = 5  # the simulation goes first
LAST_WORDS: Final = 1.0  # to the pages, once the input has ended [s]
PING: Final = 5.0  # [s]
UNREAD: Final = 20  # after which what a page does not read is given up [s]
HANDSHAKE: Final = 5.0  # of TLS [s]
SEND_BUFFER: Final = 1 << 17  # of the system, of one connection [bytes]


def listen(host: str, port: int) -> socket.socket:
    """Return a socket that listens; its connections do not keep much, nor for long.

    Raises:
        OSError: nobody can listen there.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    listener = socket.create_server((host, port), family=family, backlog=128)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER)
    listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    if (option := getattr(socket, "TCP_USER_TIMEOUT", None)) is not None:  # Linux
        listener.setsockopt(socket.IPPROTO_TCP, option, 1000 * UNREAD)
    return listener


def make_server(told: dict[str, Any], hub: Hub) -> uvicorn.Server:
    """Return the server of a hub, as the run has told.

    Raises:
        OSError: the TLS files cannot be read, or are none.
    """
    app = make_app(hub, Path(told["viewer"]), told["token"], told["host"])
    config = uvicorn.Config(
        app,
        http=BoundedProtocol,
        ws="websockets-sansio",
        ws_max_size=MAX_MESSAGE,
        ws_ping_interval=PING,
        ws_ping_timeout=PING,
        ws_per_message_deflate=False,
        timeout_graceful_shutdown=1,
        log_config=None,
        access_log=False,
        server_header=False,
        lifespan="off",
        ssl_certfile=told["tls_cert"],
        ssl_keyfile=told["tls_key"],
    )
    config.load()
    return uvicorn.Server(config)


async def serve(told: dict[str, Any], descriptor: int) -> None:
    """Serve until the input ends.

    Raises:
        OSError: nobody can listen there.
    """
    listener = listen(told["host"], told["port"])
    facts = Facts(
        scenario=told["scenario"],
        duration=told["duration"],
        blocks=read_blocks(told["text"]),
        marks=[Part(*mark)._replace(X=np.array(mark[3])) for mark in told["marks"]],
        delayed=told["delayed"],
        max_force=told["max_force"],
    )
    hub = Hub(map_mailboxes(descriptor), facts)
    server = make_server(told, hub)
    tasks = [asyncio.create_task(server.serve([listener])), asyncio.create_task(hub.run())]
    while not server.started:
        await asyncio.sleep(0.01)
    _say({"port": listener.getsockname()[1]})
    reader = threading.Thread(target=_read, args=(asyncio.get_running_loop(), hub, server))
    reader.daemon = True
    reader.start()
    done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    for task in done:
        task.result()


def _read(loop: asyncio.AbstractEventLoop, hub: Hub, server: uvicorn.Server) -> None:
    """Hand on what the run tells; end with it."""
    with suppress(ValueError, OSError):  # half a line of a run that was killed
        for line in sys.stdin:
            loop.call_soon_threadsafe(hub.end, json.loads(line))
    server.should_exit = True
    time.sleep(LAST_WORDS)
    os._exit(0)


def _say(message: dict[str, Any]) -> None:
    sys.stdout.write(json.dumps(message) + "\n")
    sys.stdout.flush()


def main(descriptor: int) -> None:
    """Serve what the first line of the input tells."""
    os.nice(NICE)
    asyncio.constants.SSL_HANDSHAKE_TIMEOUT = HANDSHAKE  # uvicorn has no option for it
    logging.basicConfig(format="%(message)s", level=logging.WARNING)
    logging.getLogger("uvicorn.error").setLevel(logging.ERROR)
    told = json.loads(sys.stdin.readline())
    try:
        asyncio.run(serve(told, descriptor))
    except (OSError, ssl.SSLError, ValueError) as error:
        _say({"error": " ".join(str(error).split())})


if __name__ == "__main__":
    main(int(sys.argv[1]))
