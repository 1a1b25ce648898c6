"""A station's server without a simulation: the test plays the run, and hears what the page says."""

from __future__ import annotations

import json
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import meshcat
import numpy as np

from scara_drake.joints import HOME
from scara_drake.safety import Reason, State
from scara_drake.station.device import StationDevice
from scara_drake.station.records import empty_frame, make_mailboxes
from scara_drake.vectors import BUTTON_NAMES, SETTING_NAMES, STICK_NAMES, pose_vector

TOKEN = "a-token"
VIEWER = Path(meshcat.__file__).parent / "viewer" / "dist" / "main.min.js"
SCENARIO = """
environment:
  surfaces:
  - !Wall
    {name: wall, point: [0.8, -1.0, 3.0], normal: [0.0, 1.0, 0.0], size: [1.6, 1.2], thickness: 0.05}
"""


class Station:
    """The server, in a process of its own; `show` says what the run looks like.

    Attributes:
        url: of the page.
        device: what the simulation would have of the page.
    """

    def __init__(self, port: int = 0) -> None:
        self._memory, self._boxes = make_mailboxes()
        self.device = StationDevice(self._boxes)
        self._frame = empty_frame()
        self.show(state=[*HOME, *np.zeros(6)], X_WE_desired=pose_vector(HOME))
        self.show(f_env_on_tool_W=0.0, f_haptic=0.0, actuation=0.0, delay_up=0.1, delay_down=0.1)
        self.supervisors((State.IDLE, Reason.RELEASED), (State.IDLE, Reason.NONE))
        self._process = self._start(port)
        assert self._process.stdout is not None
        self.port = json.loads(self._process.stdout.readline())["port"]
        self.url = f"http://127.0.0.1:{self.port}/{TOKEN}/"
        self._running = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _start(self, port: int) -> subprocess.Popen[str]:
        told = {
            "host": "127.0.0.1",
            "port": port,
            "token": TOKEN,
            "scenario": "rig",
            "duration": 60.0,
            "text": SCENARIO,
            "delayed": False,
            "viewer": str(VIEWER),
            "tls_cert": None,
            "tls_key": None,
        }
        number = self._memory.fileno()
        process = subprocess.Popen(
            [sys.executable, "-m", "scara_drake.station.server_process", str(number)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            pass_fds=[number],
        )
        assert process.stdin is not None
        process.stdin.write(json.dumps(told) + "\n")
        process.stdin.flush()
        return process

    def _run(self) -> None:
        start = time.monotonic()
        while not self._running.wait(0.033):
            self._frame["wall"] = time.monotonic()
            self._frame["t"] = self._frame["wall"] - start
            self._boxes.frame.write(self._frame)

    def show(self, **signals: Any) -> None:
        """Set entries of the frame that the run leaves."""
        for name, value in signals.items():
            self._frame[name] = value

    def supervisors(self, operator: tuple[State, Reason], robot: tuple[State, Reason]) -> None:
        self.show(operator_status=[*operator, 1, 0], robot_status=[*robot, 1, 0])

    def buttons(self) -> dict[str, bool]:
        return dict(zip(BUTTON_NAMES, self.device.sample().buttons == 1.0, strict=True))

    def axes(self) -> dict[str, float]:
        return dict(zip(STICK_NAMES, self.device.sample().axes.tolist(), strict=True))

    def settings(self) -> dict[str, float]:
        return dict(zip(SETTING_NAMES, self.device.sample().settings.tolist(), strict=True))

    def close(self) -> None:
        self._running.set()
        self._thread.join()
        if self._process.stdin is not None:
            self._process.stdin.close()  # the server ends with it
        self._process.wait(10.0)
        if self._process.stdout is not None:
            self._process.stdout.close()
        self._memory.close()


@contextmanager
def station(port: int = 0) -> Iterator[Station]:
    rig = Station(port)
    try:
        yield rig
    finally:
        rig.close()
