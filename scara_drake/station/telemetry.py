"""What the pages are told of a frame, see `protocol`."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from typing import Any, Final, NamedTuple

import numpy as np
from meshcat.transformations import quaternion_from_matrix
from numpy.typing import ArrayLike

from scara_drake.joints import EFFORT, JOINT_NAMES, JOINT_UNITS, LOWER, UPPER
from scara_drake.kinematics import tool_pose_kernel
from scara_drake.safety import MEANINGS, Reason, State, words
from scara_drake.station.protocol import (
    SETTINGS,
    Event,
    JointFacts,
    SettingFacts,
    Status,
    Telemetry,
)
from scara_drake.vectors import DEVICE_STATUS, POSE, SETTING_NAMES, STATE, SUPERVISOR_STATUS

WINDOW: Final = 30  # frames over which the real-time factor is told
LATENESSES: Final = 300  # frames over which the percentile is, where the run does not tell it
EFFORT_UNITS: Final = {"m": "N", "rad": "N m"}
SIDES: Final = ("operator", "robot")


class Others(NamedTuple):
    """What is told beside the frame."""

    rumble: list[float]
    settings: Mapping[str, float]
    clients: int
    holder: int | None


def number(value: float) -> float | None:
    """Return a number for JSON: None where it is not finite."""
    return float(value) if np.isfinite(value) else None


def numbers(values: ArrayLike) -> list[float | None]:
    """Return numbers for JSON: None where one is not finite."""
    return [number(value) for value in np.asarray(values, dtype=np.float64)]


class Telemeter:
    """Turns frames into telemetry and events; it remembers the last few."""

    def __init__(self) -> None:
        self._clock: deque[tuple[float, float]] = deque(maxlen=WINDOW)
        self._lateness: deque[float] = deque(maxlen=LATENESSES)
        self._codes: dict[str, tuple[int, int]] = {}

    def take(self, frame: Any) -> list[Event]:
        """Note a new frame; return what has happened since the last one."""
        self._clock.append((float(frame["t"]), float(frame["wall"])))
        lateness = _lateness(frame)
        if np.isfinite(lateness):
            self._lateness.append(lateness)
        found = [self._event(side, frame) for side in SIDES]
        return [event for event in found if event is not None]

    def _event(self, side: str, frame: Any) -> Event | None:
        status = status_of(frame[f"{side}_status"])
        codes, before = (status["state"], status["reason"]), self._codes.get(side)
        self._codes[side] = codes
        if before is None or codes == before:
            return None
        return {
            "type": "event",
            "t": float(frame["t"]),
            "side": side,
            "state": status["state"],
            "reason": status["reason"],
            "sentence": status["sentence"],
            "remedy": status["remedy"],
            "severity": int(MEANINGS[Reason(status["reason"])].severity),
        }

    def tell(self, frame: Any, others: Others, now: float) -> Telemetry:
        """Return the telemetry of a frame at `now` [s] of the monotonic clock."""
        state = STATE.unpack(np.array(frame["state"]))
        p_WE, R_WE = np.empty(3), np.empty((3, 3))
        tool_pose_kernel(state.q, p_WE, R_WE)
        force = frame["f_haptic"]
        if not np.isfinite(force).all():
            force = frame["f_env_on_tool_W"]
        return {
            "type": "telemetry",
            "t": float(frame["t"]),
            "realtime_factor": self._factor(now),
            "lateness": number(_lateness(frame)),
            "late_ticks": int(frame["late_ticks"]),
            "p99": self._percentile(frame),
            "operator": status_of(frame["operator_status"]),
            "robot": status_of(frame["robot_status"]),
            "delay_up": number(frame["delay_up"][0]),
            "delay_down": number(frame["delay_down"][0]),
            "force": numbers(force),
            "force_size": number(float(np.linalg.norm(force))),
            "tool_error": _error(frame["X_WE_desired"], p_WE),
            "q": numbers(state.q),
            "effort_share": numbers(frame["actuation"] / EFFORT),
            "tool": numbers([*p_WE, *_quaternion(R_WE)]),
            "rumble": others.rumble,
            "settings": _settings(frame, others.settings),
            "lag": None,
            "dropped": 0,
            "clients": others.clients,
            "holder": others.holder,
            "task": bytes(frame["task"]).decode(errors="replace"),
        }

    def _factor(self, now: float) -> float | None:
        """Simulated seconds per second; it falls while no frame comes."""
        if len(self._clock) < 2:
            return None
        (t0, wall0), (t1, wall1) = self._clock[0], self._clock[-1]
        usual = (wall1 - wall0) / (len(self._clock) - 1)
        elapsed = max(wall1, now - 2.0 * usual) - wall0
        return number((t1 - t0) / elapsed) if elapsed > 0.0 else None

    def _percentile(self, frame: Any) -> float | None:
        if np.isfinite(frame["p99"]):
            return float(frame["p99"])
        return float(np.percentile(self._lateness, 99)) if self._lateness else None


def status_of(vector: ArrayLike) -> Status:
    """Return a supervisor's status (4) with its words; without a supervisor, IDLE."""
    codes = np.asarray(vector, dtype=np.float64)
    if not np.isfinite(codes).all():
        codes = np.zeros(SUPERVISOR_STATUS.size)
    status = SUPERVISOR_STATUS.unpack(codes)
    try:
        state, reason = State(int(status.state)), Reason(int(status.reason))
    except ValueError:  # of another version of the table
        state, reason = State.FAULT, Reason.NONE
    meaning = MEANINGS[reason]
    return {
        "state": int(state),
        "name": words(state, Reason.NONE),
        "reason": int(reason),
        "words": meaning.says,
        "remedy": meaning.remedy,
        "sentence": words(state, reason),
        "engagements": int(status.engagements),
        "faults": int(status.faults),
    }


def joint_facts() -> list[JointFacts]:
    """Return what is told of the joints once."""
    rows = zip(JOINT_NAMES, JOINT_UNITS, LOWER, UPPER, EFFORT, strict=True)
    return [
        {
            "name": name,
            "unit": unit,
            "lower": float(lower),
            "upper": float(upper),
            "effort": float(effort),
            "effort_unit": EFFORT_UNITS[unit],
        }
        for name, unit, lower, upper, effort in rows
    ]


def setting_facts(values: Mapping[str, float]) -> list[SettingFacts]:
    """Return what is told of the settings once."""
    return [
        {
            "name": name,
            "words": bounds.words,
            "unit": bounds.unit,
            "lower": bounds.lower,
            "upper": bounds.upper,
            "value": values[name],
        }
        for name, bounds in SETTINGS.items()
    ]


def _lateness(frame: Any) -> float:
    lateness = float(frame["lateness"])
    return (
        lateness
        if np.isfinite(lateness)
        else float(DEVICE_STATUS.unpack(frame["device_status"]).lateness)
    )


def _settings(frame: Any, asked: Mapping[str, float]) -> dict[str, float]:
    """Return the settings that act; until the run tells them, those that are asked for."""
    acting = frame["live_settings"]
    if not np.isfinite(acting).all():
        return dict(asked)
    return {name: float(v) for name, v in zip(SETTING_NAMES, acting, strict=True)}


def _error(desired: Any, p_WE: Any) -> float | None:
    return number(float(np.linalg.norm(POSE.unpack(desired).p - p_WE)))


def _quaternion(R: Any) -> list[float]:
    """Quaternion w x y z of a rotation (3, 3)."""
    X = np.eye(4)
    X[:3, :3] = R if np.isfinite(R).all() else np.eye(3)
    return [float(part) for part in quaternion_from_matrix(X)]
