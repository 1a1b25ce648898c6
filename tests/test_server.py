"""Who reaches the scene, and what a run bears from those who do."""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator
from urllib.parse import urlsplit

import pytest
from pydrake.geometry import Meshcat, Sphere

from scara_drake.display.server import own_address, start_meshcat, who_reaches

linux = pytest.mark.skipif(os.uname().sysname != "Linux", reason="Linux has all of 127.0.0.0/8")
CONNECTIONS = 10_000


@pytest.fixture
def place() -> Iterator[tuple[str, int]]:
    meshcat = start_meshcat()
    url = urlsplit(meshcat.web_url())
    assert url.hostname is not None
    assert url.port is not None
    yield url.hostname, url.port
    meshcat.SetObject("/alive", Sphere(1.0))  # raises once the server's thread has ended
    assert meshcat.HasPath("/alive")


def answer(host: str, port: int, request: bytes) -> bytes:
    with socket.create_connection((host, port), 5.0) as connection:
        connection.sendall(request)
        return connection.recv(100)


def outer_address() -> str | None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))  # sends nothing
        except OSError:
            return None
        return str(probe.getsockname()[0])


@linux
def test_it_is_reached_at_its_own_address_and_at_no_other(place: tuple[str, int]) -> None:
    host, port = place
    assert answer(host, port, b"GET / HTTP/1.1\r\nHost: x\r\n\r\n").startswith(b"HTTP/1.1 200")
    for other in {"127.0.0.1", outer_address() or "127.0.0.1"}:
        with pytest.raises(OSError, match="refused"):
            socket.create_connection((other, port), 5.0)


@linux
def test_addresses_are_those_of_this_machine_and_differ() -> None:
    drawn = [own_address() for _ in range(1000)]
    assert len(set(drawn)) > 990
    assert all(name.startswith("127.") for name in drawn)
    assert not {"127.0.0.0", "127.0.0.1", "127.255.255.255"} & set(drawn)


def test_ten_thousand_connections_and_no_http_leave_it_alive(place: tuple[str, int]) -> None:
    host, port = place
    for index in range(CONNECTIONS):
        with socket.create_connection((host, port), 5.0) as connection:
            if index % 10 == 0:
                connection.sendall(os.urandom(50) + b"\r\n\r\n")
    assert answer(host, port, b"GET / HTTP/1.1\r\nHost: x\r\n\r\n").startswith(b"HTTP/1.1 200")


@pytest.mark.parametrize(
    ("host", "local"),
    [("", True), ("localhost", True), ("127.8.9.1", True), ("*", False), ("192.0.2.7", False)],
)
def test_who_reaches_it_is_said(host: str, local: bool) -> None:
    assert (who_reaches(host) == "this machine only") is local


def test_what_cannot_be_served_is_one_line() -> None:
    with pytest.raises(ValueError, match=r"port: 80, allowed 1024 to 65535"):
        start_meshcat(port=80)
    taken = start_meshcat("localhost")
    port = urlsplit(taken.web_url()).port
    with pytest.raises(ValueError, match=r"host: 'localhost', port: \d+, allowed"):
        start_meshcat("localhost", port)
    with pytest.raises(ValueError, match=r"host: '203\.0\.113\.7'"):
        start_meshcat("203.0.113.7")
    assert isinstance(taken, Meshcat)
