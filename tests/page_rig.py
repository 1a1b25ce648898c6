"""A station without a simulation: the test plays the run, and hears what the page says."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from scara_drake.joints import HOME
from scara_drake.operator.devices.sample import Sample, at_rest
from scara_drake.safety import Reason, State
from scara_drake.scenario import load_scenario
from scara_drake.station.place import Place
from scara_drake.station.records import empty_frame
from scara_drake.station.station import Station
from scara_drake.vectors import BUTTON_NAMES, SETTING_NAMES, STICK_NAMES, pose_vector


class Rig:
    """The station's server, in a process of its own; `show` says what the run looks like.

    Attributes:
        device: what the simulation has of the page.
        url: of the page.
    """

    def __init__(self, port: int = 0) -> None:
        self._station = Station(load_scenario("teleoperation"), Place(port=port))
        self.device, self.url = self._station.device, self._station.address
        self._frame = empty_frame()
        self.show(state=[*HOME, *np.zeros(6)], X_WE_desired=pose_vector(HOME))
        self.show(f_env_on_tool_W=0.0, f_haptic=0.0, actuation=0.0, delay_up=0.1, delay_down=0.1)
        self.supervisors((State.IDLE, Reason.RELEASED), (State.IDLE, Reason.NONE))
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        start = time.monotonic()
        while not self._ended.wait(0.033):
            self._frame["wall"] = time.monotonic()
            self._frame["t"] = self._frame["wall"] - start
            self._station._mailboxes.frame.write(self._frame)

    def show(self, **signals: Any) -> None:
        """Set entries of the frame that the run leaves."""
        for name, value in signals.items():
            self._frame[name] = value

    def supervisors(self, operator: tuple[State, Reason], robot: tuple[State, Reason]) -> None:
        self.show(operator_status=[*operator, 1, 0], robot_status=[*robot, 1, 0])

    def connected(self) -> bool:
        return self.device.sample().connected

    def _sample(self) -> Sample:
        """What the page that is there says; at rest where there is none."""
        sample = self.device.sample()
        return sample if sample.connected else at_rest(0.0, False)

    def buttons(self) -> dict[str, bool]:
        return dict(zip(BUTTON_NAMES, (self._sample().buttons == 1.0).tolist(), strict=True))

    def axes(self) -> dict[str, float]:
        return dict(zip(STICK_NAMES, self._sample().axes.tolist(), strict=True))

    def settings(self) -> dict[str, float]:
        return dict(zip(SETTING_NAMES, self._sample().settings.tolist(), strict=True))

    def end(self) -> None:
        self._station.end(False, ["arm lost at t = 3.2 s"], ["runs/rig.nc"])

    def close(self) -> None:
        self._ended.set()
        self._thread.join()
        self._station.close()


@contextmanager
def rig(port: int = 0) -> Iterator[Rig]:
    one = Rig(port)
    try:
        yield one
    finally:
        one.close()
