"""The station's server, a real process: who gets in, who commands, and how it ends."""

from __future__ import annotations

import http.client
import os
import signal
import socket
import struct
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager, suppress
from pathlib import Path
from urllib.parse import urlsplit

import pytest
import umsgpack
from station_rig import PATIENCE, Page, frame_at, serving, shared_by, wait_until
from websockets.exceptions import ConnectionClosed, InvalidStatus

from scara_drake.safety import Reason, State
from scara_drake.station.gate import MAX_CONNECTIONS
from scara_drake.station.hub import MAX_CLIENTS
from scara_drake.station.place import Place
from scara_drake.station.protocol import BAD_MESSAGE, TOO_MANY
from scara_drake.station.station import Station

# Starts a station, says which process serves it, and waits.
HOLDER = """
import time
from scara_drake.scenario import load_scenario
from scara_drake.station.place import Place
from scara_drake.station.station import Station
station = Station(load_scenario("joint_sine"), Place())
print(station._process.pid, flush=True)
time.sleep(600)
"""


@pytest.fixture(scope="module")
def station() -> Iterator[Station]:
    with serving() as station:
        yield station


def ask(address: str, path: str, method: str = "GET", **headers: str) -> tuple[int, dict[str, str]]:
    place = urlsplit(address)
    assert place.hostname is not None
    with closing(http.client.HTTPConnection(place.hostname, place.port, timeout=30)) as connection:
        connection.request(method, path, headers=headers)
        answer = connection.getresponse()
        answer.read()
        return answer.status, dict(answer.getheaders())


def token_of(station: Station) -> str:
    return urlsplit(station.address).path


def test_with_the_token_there_is_a_page_that_loads_nothing_from_elsewhere(station: Station) -> None:
    for path in ("", "viewer.js"):
        status, headers = ask(station.address, token_of(station) + path)
        assert status == 200
        assert "default-src 'none'" in headers["content-security-policy"]
        assert "http" not in headers["content-security-policy"]
        assert headers["referrer-policy"] == "no-referrer"
        assert headers["cache-control"] == "no-store"


def test_an_address_without_its_slash_leads_to_it(station: Station) -> None:
    status, headers = ask(station.address, token_of(station).rstrip("/"))
    assert (status, headers["location"]) == (307, token_of(station))


@pytest.mark.parametrize(
    "path", ["/", "/viewer.js", "/ws", "/wrong/", "/wrong/viewer.js", "//", "/%2e%2e/", "/ü/"]
)
def test_without_the_token_there_is_nothing(station: Station, path: str) -> None:
    assert ask(station.address, path.replace("ü", "%C3%BC"))[0] == 404


def test_a_longer_or_shorter_token_is_none(station: Station) -> None:
    token = token_of(station).strip("/")
    for wrong in (token[:-1], token + "x", token.swapcase(), ""):
        assert ask(station.address, f"/{wrong}/")[0] == 404
        address = station.address.replace(token, wrong)
        with pytest.raises(InvalidStatus, match="403"):
            Page(address)


@pytest.mark.parametrize("path", ["../app.py", "%2e%2e/app.py", "..%2fapp.py", "page/../../app.py"])
def test_nothing_beside_the_page_is_served(station: Station, path: str) -> None:
    assert ask(station.address, token_of(station) + path)[0] == 404


def test_a_foreign_page_does_not_get_in(station: Station) -> None:
    place = urlsplit(station.address)
    path = token_of(station)
    assert ask(station.address, path, Origin="https://evil.example")[0] == 404
    assert ask(station.address, path, Host="evil.example")[0] == 404  # DNS rebinding
    assert ask(station.address, path, Host=f"localhost:{place.port}")[0] == 200
    with pytest.raises(InvalidStatus, match="403"):
        Page(station.address, origin="https://evil.example")
    with Page(station.address, origin=f"http://{place.netloc}") as page:
        assert page.hears("hello")


def test_a_page_is_greeted_and_shown_the_scene(station: Station) -> None:
    with Page(station.address) as page:
        hello = page.hears("hello")
        assert hello["scenario"] == "teleoperation"
        assert hello["delayed"]  # its channel has a delay
        assert hello["joints"][0]["name"] == "d1"
        shared_by(station).frame.write(frame_at(1.0))
        assert page.hears("telemetry")["t"] == 1.0
        while len(page.pictures) < 2:
            page.hears("telemetry")
        for message in page.pictures[:2]:
            assert any(path.startswith("/meshcat/robot/link_1") for path in paths_of(message))


def paths_of(picture: bytes) -> list[str]:
    """The paths of the commands of a picture, read as `protocol` says."""
    paths, place = [], 4
    while place < len(picture):
        (length,) = struct.unpack_from("<I", picture, place)
        paths.append(umsgpack.unpackb(picture[place + 4 : place + 4 + length])["path"])
        place += 4 + length
    assert place == len(picture)
    return paths


def test_one_commands_and_the_other_watches_until_it_is_given_control(station: Station) -> None:
    with Page(station.address) as first, Page(station.address) as second:
        other = second.hears("hello")["control"]["you"]
        first.takes()
        second.say(type="control", action="take")
        assert "holds control" in second.hears("refused")["words"]
        second.moves(1, 1, 1, 1, 1, engage=True)
        assert second.hears("refused")
        second.say(type="setting", name="force_scale", value=0.0)
        assert second.hears("refused")
        assert not station.device.sample().connected
        first.moves(0.5, 0, 0, 0, 0, engage=True)
        wait_until(lambda: station.device.sample().connected)
        assert station.device.sample().axes[0] == 0.5
        first.say(type="control", action="give", to=other)
        while not second.hears("control")["mine"]:
            pass
        assert not station.device.sample().connected
        second.moves(-0.5, 0, 0, 0, 0)
        wait_until(lambda: station.device.sample().connected)
        sample = station.device.sample()
        assert (sample.axes[0], sample.buttons[0]) == (-0.5, 0.0)


def test_a_page_that_closes_is_a_device_that_is_lost(station: Station) -> None:
    with Page(station.address) as page:
        page.takes()
        page.moves(1, 0, 0, 0, 0, engage=True)
        wait_until(lambda: station.device.sample().connected)
    wait_until(lambda: not station.device.sample().connected)
    with Page(station.address) as page:
        assert page.hears("hello")["control"]["holder"] is None


def test_a_page_whose_network_breaks_is_lost_too(station: Station) -> None:
    page = Page(station.address)
    page.takes()
    page.moves(1, 0, 0, 0, 0, engage=True)
    wait_until(lambda: station.device.sample().connected)
    linger = struct.pack("ii", 1, 0)  # a reset in place of a goodbye
    page.socket.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, linger)
    page.socket.socket.close()
    wait_until(lambda: not station.device.sample().connected)


@pytest.mark.parametrize(
    "text", ["{", '{"type": "input", "axes": [2, 0, 0, 0, 0]}', "x" * 9000, b"bytes"]
)
def test_who_says_what_is_no_message_is_sent_away_alone(
    station: Station, text: str | bytes
) -> None:
    with Page(station.address) as good, Page(station.address) as bad:
        good.takes()
        good.moves(0, 0, 0, 0, 0, engage=True)
        wait_until(lambda: station.device.sample().connected)
        bad.socket.send(text)
        assert bad.is_sent_away() in (BAD_MESSAGE, 1009)
        good.moves(0.25, 0, 0, 0, 0, engage=True)
        wait_until(lambda: station.device.sample().axes[0] == 0.25)
        assert station.device.sample().connected


def test_who_says_too_much_is_sent_away(station: Station) -> None:
    def code() -> int:
        with Page(station.address) as page:
            with suppress(ConnectionClosed):  # it may be sent away before it has said all
                for _ in range(2000):
                    page.socket.send('{"type":"view","delayed":true}')
            return page.is_sent_away()

    # Where the server ends a connection with messages unread, TCP resets it, and the code is lost.
    assert any(code() == BAD_MESSAGE for _ in range(3))


def test_beyond_so_many_pages_no_more_are_let_in(station: Station) -> None:
    with ExitStack() as stack:
        pages = [stack.enter_context(Page(station.address)) for _ in range(MAX_CLIENTS)]
        with Page(station.address) as page:
            assert page.is_sent_away() == TOO_MANY
        assert pages[0].hears("hello")


def test_connections_that_ask_for_nothing_stop_nobody_who_is_there(station: Station) -> None:
    with Page(station.address) as page, idle_connections(station, 2 * MAX_CONNECTIONS):
        shared_by(station).frame.write(frame_at(2.0))
        while page.hears("telemetry")["t"] != 2.0:
            pass
        page.takes()
        page.moves(0, 0, 0, 0, 0)
        wait_until(lambda: station.device.sample().connected)


@pytest.mark.slow  # it waits until the server has given them up
def test_connections_that_ask_for_nothing_shut_nobody_out_for_long(station: Station) -> None:
    def gets_in() -> bool:
        try:
            return ask(station.address, token_of(station))[0] == 200
        except OSError:
            return False

    with idle_connections(station, 2 * MAX_CONNECTIONS):
        wait_until(gets_in)


@contextmanager
def idle_connections(station: Station, count: int) -> Iterator[None]:
    place = urlsplit(station.address)
    with ExitStack() as stack:
        for _ in range(count):
            idle = socket.create_connection((place.hostname, place.port), PATIENCE)
            stack.enter_context(idle)
        yield


def test_a_page_that_does_not_read_stops_nobody(station: Station) -> None:
    with Page(station.address) as page, Page(station.address):
        for k in range(60):
            shared_by(station).frame.write(frame_at(3.0 + k))
            while page.hears("telemetry")["t"] != 3.0 + k:
                pass


@pytest.mark.slow
def test_ten_thousand_connections_stop_nobody(station: Station) -> None:
    place = urlsplit(station.address)
    with Page(station.address) as page:
        page.takes()
        for index in range(10_000):
            with socket.create_connection((place.hostname, place.port), PATIENCE) as connection:
                if index % 10 == 0:
                    connection.sendall(os.urandom(50) + b"\r\n\r\n")
            if index % 500 == 0:
                t = 1000.0 + index
                shared_by(station).frame.write(frame_at(t))
                while page.hears("telemetry")["t"] != t:
                    pass
                page.moves(index / 1e4, 0, 0, 0, 0)
        wait_until(lambda: station.device.sample().axes[0] == 0.95)


def test_what_happens_to_the_supervisors_is_told_once(station: Station) -> None:
    with Page(station.address) as page:
        page.hears("hello")
        idle, hold = [State.IDLE, Reason.NONE, 0, 0], [State.HOLD, Reason.COMMAND_LOST, 1, 1]
        shared_by(station).frame.write(frame_at(100.0, robot_status=idle))
        while page.hears("telemetry")["t"] != 100.0:
            pass
        shared_by(station).frame.write(frame_at(101.0, robot_status=hold))
        event = page.hears("event")
        assert (event["side"], event["t"], event["state"]) == ("robot", 101.0, State.HOLD)
        assert event["sentence"] == "HOLD: no command arrives at the robot"
        assert page.hears("telemetry")["robot"]["sentence"] == event["sentence"]
    with Page(station.address) as late:
        assert late.hears("event") == event


def test_the_motors_of_the_page_shake_as_long_as_they_are_to(station: Station) -> None:
    shared_by(station).frame.write(frame_at(110.0))
    with Page(station.address) as page:
        page.takes()
        station.device.rumble(0.25, 0.5, 2000)
        while page.hears("telemetry")["rumble"] != [0.25, 0.5]:
            pass
        while page.hears("telemetry")["rumble"] != [0.0, 0.0]:
            pass


def test_numbers_that_are_none_are_null(station: Station) -> None:
    with Page(station.address) as page:
        shared_by(station).frame.write(frame_at(120.0, f_haptic=float("inf"), delay_up=0.25))
        while (told := page.hears("telemetry"))["t"] != 120.0:
            pass
        assert told["force"] == [None, None, None]
        assert told["force_size"] is None
        assert (told["delay_up"], told["delay_down"]) == (0.25, None)


def test_the_end_is_told_and_the_server_ends() -> None:
    with serving(scenario="joint_sine") as station, Page(station.address) as page:
        assert not page.hears("hello")["delayed"]
        station.end(True, ["all is well"], ["run.nc"])
        ended = page.hears("ended")
        assert (ended["good"], ended["lines"]) == (True, ["all is well"])
        station.close()
        station.close()
        assert not station.is_there()
        assert not station.device.sample().connected
        station.end(True, [], [])  # nobody is there to hear it


def test_a_server_that_is_killed_is_a_device_that_is_lost() -> None:
    with serving(scenario="joint_sine") as station, Page(station.address) as page:
        page.takes()
        page.moves(0, 0, 0, 0, 0)
        wait_until(lambda: station.device.sample().connected)
        station._process.kill()
        wait_until(lambda: not station.device.sample().connected)
        assert station.has_page()  # nobody waits for one for ever


def test_the_server_and_its_memory_end_with_a_run_that_is_killed() -> None:
    folder = Path("/dev/shm")
    before = set(os.listdir(folder)) if folder.is_dir() else set()
    run = subprocess.Popen([sys.executable, "-c", HOLDER], stdout=subprocess.PIPE, text=True)
    assert run.stdout is not None
    server = int(run.stdout.readline())
    os.kill(server, 0)
    run.send_signal(signal.SIGKILL)
    run.communicate()

    def is_gone() -> bool:
        try:
            os.kill(server, 0)
        except ProcessLookupError:
            return True
        # Where nobody reaps orphans it stays as a zombie.
        return Path(f"/proc/{server}/stat").read_text().rpartition(")")[2].split()[0] == "Z"

    wait_until(is_gone)
    left = set(os.listdir(folder)) - before if folder.is_dir() else set()
    assert not {name for name in left if name.startswith("tmp")}


def test_a_place_where_nobody_can_listen_is_one_line(station: Station) -> None:
    port = urlsplit(station.address).port
    assert port is not None
    with pytest.raises(
        OSError, match=rf"^station: cannot listen on 127.0.0.1 port {port}: .*in use"
    ):
        serving(Place(port=port)).__enter__()
    with pytest.raises(OSError, match=r"^station: cannot listen on 203\.0\.113\.7 port any: "):
        serving(Place(host="203.0.113.7")).__enter__()
