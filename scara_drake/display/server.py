"""The Meshcat that serves the scene: who can reach it, and in which words that is said.

Drake's server checks neither who connects nor what is sent: whoever reaches it can press Stop, and
one malformed message ends the run. So only this machine reaches it unless somebody asks for more,
and at an address that a page of another origin, open in a browser here, cannot guess.
"""

from __future__ import annotations

import ipaddress
import logging
import secrets
import sys

from pydrake.geometry import Meshcat, MeshcatParams

from scara_drake.common import checks

EVERYWHERE = "*"
LOWEST_PORT, HIGHEST_PORT = 1024, 65535


def start_meshcat(host: str = "", port: int | None = None) -> Meshcat:
    """Start the server of a scene.

    Args:
        host: where it listens: a name or an address of this machine, "*" for all its addresses;
            empty for one that only this machine has, see `own_address`.
        port: empty for the first free one from 7000 on.

    Raises:
        ValueError: a port out of bounds, or nobody can listen at this host and port.
    """
    params = MeshcatParams()
    params.host = host or own_address()
    if port is not None:
        checks.number("port", port, LOWEST_PORT, HIGHEST_PORT)
        params.port = port
    log = logging.getLogger("drake")
    level = log.level
    log.setLevel(logging.WARNING)  # who starts it tells the address, in words of his own
    try:
        return Meshcat(params)
    except RuntimeError:
        where = f"host: '{params.host}', port: {port or 'any from 7000 on'}"
        raise ValueError(f"{where}, allowed an address of this machine and a free port") from None
    finally:
        log.setLevel(level)


def own_address() -> str:
    """Return a random address of the loopback network; Linux has all of 127.0.0.0/8, others one."""
    if not sys.platform.startswith("linux"):
        return "localhost"
    return str(ipaddress.IPv4Address("127.0.0.0") + 2 + secrets.randbelow(2**24 - 3))


def who_reaches(host: str) -> str:
    """Return who can open the scene of a server that was started with this host."""
    try:
        local = host in ("", "localhost") or ipaddress.ip_address(host).is_loopback
    except ValueError:  # a name
        local = False
    if local:
        return "this machine only"
    return "anybody who reaches this machine can stop the run, or end it with a malformed message"
