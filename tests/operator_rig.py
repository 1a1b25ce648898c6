"""The operator's side without a Diagram: the kernels of its blocks, tick by tick, by a script."""

from __future__ import annotations

from typing import Any

import numpy as np

from scara_drake.operator.mapping import JoystickMapping, initial_command
from scara_drake.operator.smooth_stick import MOTION, pack_mapping
from scara_drake.operator.stick_filter import (
    FILTERING,
    OPERATOR_INPUT,
    SAMPLES,
    filter_step,
)
from scara_drake.operator.supervised_mapping import map_supervised
from scara_drake.operator.supervision import OperatorSupervision, first_watch
from scara_drake.operator.supervisor import supervise
from scara_drake.safety import Reason, State
from scara_drake.vectors import (
    BUTTON_NAMES,
    LIVE_SETTINGS,
    NEUTRAL_SETTINGS,
    OPERATOR_BUTTONS,
    ORIENTATION_NAMES,
    ROBOT_REPORT,
    STICK_NAMES,
    SUPERVISOR_STATUS,
    DeviceStatus,
)

PERIOD, SAMPLE = 1e-3, 10e-3  # [s]
SENT = ("robot_state", "robot_reason", "robot_engagements", "robot_faults")


class OperatorRig:
    """What is set stays until it is set again: axes, buttons, device and robot, by their names."""

    def __init__(
        self,
        config: OperatorSupervision | None = None,
        live: bool = True,
        mapping: JoystickMapping | None = None,
    ) -> None:
        self.config, self.form = config or OperatorSupervision(), mapping or JoystickMapping()
        self.now: dict[str, float] = dict.fromkeys(
            (
                *STICK_NAMES,
                *ORIENTATION_NAMES,
                *BUTTON_NAMES,
                *SENT,
                *DeviceStatus._fields,
                "silence",
            ),
            0.0,
        ) | {
            "connected": 1.0,
            "motion_scale": 1.0,
        }
        self.samples, self.operator_input = SAMPLES.zeros(), OPERATOR_INPUT.zeros()
        self.watch = first_watch(self.config, live)
        self.operator_status = SUPERVISOR_STATUS.zeros()
        self.tool_command = initial_command(self.form)
        self.report = ROBOT_REPORT.zeros(tool_command=self.tool_command)
        self.mapped, self.motion = SUPERVISOR_STATUS.zeros(), MOTION.zeros(scale=1.0)
        self.mapping = pack_mapping(self.form, PERIOD)
        self.path: list[np.ndarray] = []
        self.motions: list[np.ndarray] = []
        self.filtering = FILTERING.pack(ticks=SAMPLE / PERIOD, spike=self.config.spike)
        self.supervision = self.config.parameters(PERIOD)
        self.time = 0.0

    def _values(self, names: tuple[str, ...]) -> np.ndarray:
        return np.array([self.now[name] for name in names], dtype=float)

    def _ticks(self, count: int) -> None:
        axes, orientation, buttons = map(
            self._values, (STICK_NAMES, ORIENTATION_NAMES, BUTTON_NAMES)
        )
        status, silence = self._values(DeviceStatus._fields), np.array([self.now["silence"]])
        ROBOT_REPORT.unpack(self.report).status[:] = self._values(SENT)
        scale = NEUTRAL_SETTINGS._replace(motion_scale=self.now["motion_scale"])
        settings, zero = LIVE_SETTINGS.pack(**scale._asdict()), np.zeros(1)
        seen, told, report = self.operator_input, self.operator_status, self.report
        for _ in range(count):
            filter_step(axes, orientation, buttons, self.filtering, self.samples, seen)
            supervise(seen, status, report, silence, zero, self.supervision, self.watch, told)
            map_supervised(
                seen,
                told,
                report,
                settings,
                self.mapping,
                self.motion,
                self.tool_command,
                self.mapped,
            )
            self.path.append(self.tool_command.copy())
            self.motions.append(self.motion.copy())
        self.time += count * PERIOD

    def run(self, seconds: float, **values: float) -> OperatorRig:
        """Set what is named, for a time and from then on."""
        wrong = values.keys() - self.now.keys()
        assert not wrong, wrong
        self.now |= values
        self._ticks(round(seconds / PERIOD))
        return self

    def engage(self, **values: float) -> OperatorRig:
        """Press the engage button anew."""
        self.run(0.02, engage=0.0)
        return self.run(0.02, engage=1.0, **values)

    def press(self, button: str) -> OperatorRig:
        """Press a button and let it go."""
        self.run(0.02, **{button: 1.0})
        return self.run(0.02, **{button: 0.0})

    @property
    def point(self) -> np.ndarray:
        """The commanded tool point relative to the arm's base."""
        return self.points()[-1]

    @property
    def mast(self) -> float:
        return float(self.tool_command[7])

    def points(self) -> np.ndarray:
        """The commanded tool points so far (n, 3), relative to the arm's base."""
        path = np.array(self.path)
        return path[:, :3] - path[:, 7:8] * [0.0, 0.0, 1.0]

    @property
    def state(self) -> State:
        return State(int(self._status.state))

    @property
    def reason(self) -> Reason:
        return Reason(int(self._status.reason))

    @property
    def faults(self) -> int:
        return int(self._status.faults)

    @property
    def engagements(self) -> int:
        return int(self._status.engagements)

    @property
    def _status(self) -> Any:
        return SUPERVISOR_STATUS.unpack(self.operator_status)


__all__ = ["OPERATOR_BUTTONS", "PERIOD", "SAMPLE", "OperatorRig"]
