"""The station of a run: its server, started and ended, and what the run has to do with it."""

from __future__ import annotations

import json
import secrets
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import pydrake
from pydrake.systems.framework import DiagramBuilder

from scara_drake.environment.surfaces import is_own
from scara_drake.scenario import Scenario, dump_scenario
from scara_drake.station.device import StationDevice
from scara_drake.station.feed import StationFeed
from scara_drake.station.marks import marks_of
from scara_drake.station.place import Place
from scara_drake.station.records import make_mailboxes
from scara_drake.supervision.config import Supervision
from scara_drake.wiring import Signals, connect_by_name

LOOPBACK: Final = "127.0.0.1"
EVERYWHERE: Final = {"*": "0.0.0.0"}  # only where it is asked for
VIEWER: Final = Path(pydrake.__path__[0]) / "share/drake/geometry/meshcat.js"
LAST_WORDS: Final = 3.0  # of the server [s]
TOKEN_BYTES: Final = 24


class Station:
    """The server of a run, and what the run shares with it.

    Args:
        scenario: of the run.
        place: where to listen.

    Attributes:
        device: the page that holds control, for `Joystick.lend`.
        address: of the page, with its token.

    Raises:
        OSError: nobody can listen there.
    """

    def __init__(self, scenario: Scenario, place: Place) -> None:
        token = secrets.token_urlsafe(TOKEN_BYTES)
        file, self._mailboxes = make_mailboxes()
        with file:  # the child has it as well, and its memory stays mapped here
            command = [sys.executable, "-m", "scara_drake.station.server_process"]
            # In a session of its own: Ctrl-C ends the run, and the run ends the server.
            self._process = subprocess.Popen(
                [*command, str(file.fileno())],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                text=True,
                pass_fds=[file.fileno()],
                start_new_session=True,
            )
        try:
            told = self._exchange(_what_is_served(scenario, place, token))
        except BaseException:
            self.close()
            raise
        self.address = place.address(told["port"], token)
        self.device = StationDevice(self._mailboxes, self.is_there)

    def _exchange(self, what: Mapping[str, Any]) -> dict[str, Any]:
        self._tell(what)
        assert self._process.stdout is not None  # it is a pipe
        told: dict[str, Any] = json.loads(self._process.stdout.readline() or "{}")
        if "port" not in told:
            where = f"{what['host']} port {what['port'] or 'any'}"
            reason = told.get("error", "its process has ended")
            raise OSError(f"station: cannot listen on {where}: {reason}")
        return told

    def _tell(self, what: Mapping[str, Any]) -> None:
        assert self._process.stdin is not None  # it is a pipe
        self._process.stdin.write(json.dumps(what) + "\n")
        self._process.stdin.flush()

    def is_there(self) -> bool:
        """Whether the server is."""
        return self._process.poll() is None

    def has_page(self) -> bool:
        """Whether a page is open, or never will be."""
        found = self._mailboxes.input.read()
        return not self.is_there() or (found is not None and bool(found["clients"] > 0))

    def add(self, builder: DiagramBuilder, scenario: Scenario, signals: Signals) -> None:
        """Add to a Diagram what leaves the server the frames that it shows."""
        surfaces = [one for one in scenario.environment.surfaces if not is_own(one)]
        feed = builder.AddNamedSystem("station", StationFeed(self._mailboxes.frame, surfaces))
        connect_by_name(builder, feed, signals)

    def end(self, good: bool, lines: list[str], files: list[str]) -> None:
        """Tell the pages that the run is over: whether it was good, its summary, what it wrote."""
        if self.is_there():
            self._tell({"good": good, "lines": lines, "files": files})

    def close(self) -> None:
        """End the server; a second call does nothing."""
        try:
            self._process.communicate(timeout=LAST_WORDS)
        except (subprocess.TimeoutExpired, ValueError):  # ValueError: a second call
            self._process.kill()
            self._process.wait()


def _what_is_served(scenario: Scenario, place: Place, token: str) -> dict[str, Any]:
    return {
        "token": token,
        "host": place.bound,
        "port": place.port,
        "tls_cert": place.tls_cert and str(place.tls_cert),
        "tls_key": place.tls_key and str(place.tls_key),
        "viewer": str(VIEWER),
        "scenario": scenario.name,
        "duration": scenario.duration,
        "text": dump_scenario(scenario),
        "marks": [[*mark._replace(X=mark.X.tolist())] for mark in marks_of(scenario)],
        "delayed": scenario.channel.link("down").maximum() > 0.0,
        "max_force": (scenario.supervision or Supervision()).robot.max_force,
    }
