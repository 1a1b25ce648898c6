"""The server of a replay: a process of its own, which listens on one address only.

Run as a file, so that nothing of the package is imported: ``python server.py HOST [PORT]``. It
prints two addresses, that of its commands and that of its page, and ends when its input does: with
the player, however that ends.
"""

from __future__ import annotations

import asyncio
import os
import subprocess
import sys
import threading
from functools import partial
from typing import Any

from meshcat.servers.zmqserver import ZMQWebSocketBridge


def start(host: str, port: int | None) -> tuple[subprocess.Popen[str], str]:
    """Start the server; return its process and the address of its commands.

    Raises:
        OSError: it cannot listen there.
    """
    command = [sys.executable, "-u", __file__, host, *([] if port is None else [str(port)])]
    pipes: dict[str, Any] = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.PIPE)
    # In a session of its own: Ctrl-C ends the player, and the player ends the server.
    process = subprocess.Popen(command, text=True, start_new_session=True, **pipes)
    assert process.stdout is not None  # it is a pipe
    if not (url := process.stdout.readline().strip()):
        _, errors = process.communicate()
        reason = errors.strip().splitlines()[-1:] or ["no reason given"]
        raise OSError(f"replay: cannot listen on {host} port {port or 'any'}: {reason[0]}")
    return process, url


class Bridge(ZMQWebSocketBridge):
    """Meshcat's server, whose page is on one address; its commands are on the loopback."""

    def __init__(self, host: str, port: int | None):
        self._host = host
        super().__init__(host="127.0.0.1", port=port)
        self.web_url = f"http://{host}:{self.fileserver_port}/static/"

    def make_app(self) -> Any:
        """Make the web application; it would listen on every address."""
        app = super().make_app()
        app.listen = partial(app.listen, address=self._host)
        return app


def _end_with_input() -> None:
    sys.stdin.buffer.read()
    os._exit(0)


def main(host: str, port: int | None = None) -> None:
    """Serve until the input ends."""
    if sys.platform == "win32":  # whose default loop tornado cannot use
        asyncio.set_event_loop_policy(asyncio.WindowsSelectorEventLoopPolicy())
    bridge = Bridge(host, port)
    threading.Thread(target=_end_with_input, daemon=True).start()
    sys.stdout.write(f"{bridge.zmq_url}\n")
    bridge.run()


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else None)
