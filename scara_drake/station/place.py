"""Where the station listens, and who can reach it there."""

from __future__ import annotations

import ipaddress
import socket
import ssl
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from scara_drake.common import checks

LOOPBACK: Final = "127.0.0.1"
EVERYWHERE: Final = {"*": "0.0.0.0"}  # only where it is asked for


@dataclass(frozen=True)
class Place:
    """Where the station listens.

    Attributes:
        host: a name or an address of this machine, "*" for all its addresses.
        port: 0 for one that is free.
        tls_cert: file with the certificate, and those that vouch for it; None for no TLS.
        tls_key: file with its key.

    Raises:
        ValueError: a port out of bounds, or TLS files that are none, or one without the other.
    """

    host: str = LOOPBACK
    port: int = 0
    tls_cert: Path | None = None
    tls_key: Path | None = None

    def __post_init__(self) -> None:
        if self.port:
            checks.number("port", self.port, 1, 65535)
        if (self.tls_cert is None) != (self.tls_key is None):
            raise ValueError("tls: one file, allowed both a certificate and its key, or none")
        if self.tls_cert is not None:
            context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
            try:
                context.load_cert_chain(self.tls_cert, self.tls_key, password=_no_password)
            except (OSError, ValueError) as error:
                files = f"'{self.tls_cert}', '{self.tls_key}'"
                raise ValueError(
                    f"tls: {files}, allowed a certificate and its key: {error}"
                ) from None

    def address(self, port: int, token: str) -> str:
        """Return the address of the page."""
        found, host = _address(self.bound), self.bound
        if found is not None and found.is_unspecified:
            host = socket.gethostname()
        host = f"[{host}]" if ":" in host else host
        return f"{'https' if self.tls_cert else 'http'}://{host}:{port}/{token}/"

    @property
    def bound(self) -> str:
        """The address that is listened on."""
        return EVERYWHERE.get(self.host, self.host)

    @property
    def is_local(self) -> bool:
        """Whether only this machine reaches it."""
        found = _address(self.host)
        return self.host == "localhost" or (found is not None and found.is_loopback)


def _address(host: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    try:
        return ipaddress.ip_address(host)
    except ValueError:
        return None


def _no_password() -> str:
    raise ValueError("the key has a password")
