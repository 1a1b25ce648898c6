"""What crosses the channel of a supervised operator: packed before it, unpacked after it."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.block import Block, Declaration, Input, Output
from scara_drake.ik.system import InverseKinematics
from scara_drake.supervision.placing import place_at_stop
from scara_drake.vectors import (
    COMMAND_FRAME,
    ROBOT_REPORT,
    SERVO_STATE,
    SUPERVISOR_STATUS,
    TOOL_COMMAND,
    command_frame_of,
    robot_report_of,
    supervisor_status_of,
)

Array = NDArray[np.float64]


@njit(cache=True)
def pack_frame(tool_command: Array, operator_status: Array, command_frame: Array) -> None:
    """Write a frame (10,)."""
    frame, status = command_frame_of(command_frame), supervisor_status_of(operator_status)
    frame.tool_command[:] = tool_command
    frame.state[()] = status.state[()]
    frame.engagements[()] = status.engagements[()]


@njit(cache=True)
def show_command(command_frame_received: Array, tool_command_received: Array) -> None:
    """Write the command (8,) of a frame."""
    tool_command_received[:] = command_frame_of(command_frame_received).tool_command


@njit(cache=True)
def pack_report(
    f_env_on_tool_W: Array,
    robot_status: Array,
    servo_state: Array,
    motion: Array,
    robot_report: Array,
) -> None:
    """Write a report (15,)."""
    report = robot_report_of(robot_report)
    report.f_env_on_tool_W[:] = f_env_on_tool_W
    report.status[:] = robot_status
    place_at_stop(servo_state, motion, report.tool_command)


@njit(cache=True)
def show_force(robot_report_received: Array, f_haptic: Array) -> None:
    """Write the force (3,) of a report."""
    f_haptic[:] = robot_report_of(robot_report_received).f_env_on_tool_W


class CommandFramePacker(Block):
    """Packs what a supervised operator sends.

    Ports:
        input tool_command (8).
        input operator_status (4): see `vectors.SupervisorStatus`.
        output command_frame (10): see `vectors.CommandFrame`, of this instant.
    """

    def __init__(self) -> None:
        super().__init__(
            Declaration(
                inputs={
                    "tool_command": Input(TOOL_COMMAND.size),
                    "operator_status": Input(SUPERVISOR_STATUS.size),
                },
                outputs={"command_frame": Output(COMMAND_FRAME.size, pack_frame)},
            )
        )


class CommandFrameSplitter(Block):
    """Shows the command of a frame that has arrived.

    Ports:
        input command_frame_received (10).
        output tool_command_received (8), of this instant.
    """

    def __init__(self) -> None:
        super().__init__(
            Declaration(
                inputs={"command_frame_received": Input(COMMAND_FRAME.size)},
                outputs={"tool_command_received": Output(TOOL_COMMAND.size, show_command)},
            )
        )


class RobotReportPacker(Block):
    """Packs what a supervised robot sends back.

    Ports:
        input f_env_on_tool_W (3) [N]: zero where unconnected.
        input robot_status (4): see `vectors.SupervisorStatus`.
        input servo_state (17): of the inverse kinematics.
        output robot_report (15): see `vectors.RobotReport`, of this instant; its command is where
            the arm can come to rest, so where it is while it rests.

    Args:
        kinematics: whose limiter it is.
        period: [s].
    """

    def __init__(self, kinematics: InverseKinematics, period: float = 1e-3) -> None:
        super().__init__(
            Declaration(
                inputs={
                    "f_env_on_tool_W": Input(3, default=(0.0,) * 3),
                    "robot_status": Input(SUPERVISOR_STATUS.size),
                    "servo_state": Input(SERVO_STATE.size),
                },
                outputs={"robot_report": Output(ROBOT_REPORT.size, pack_report)},
                parameters={"motion": kinematics.settings(period)},
            )
        )


class RobotReportSplitter(Block):
    """Shows the force of a report that has arrived.

    Ports:
        input robot_report_received (15).
        output f_haptic (3) [N], of this instant.
    """

    def __init__(self) -> None:
        super().__init__(
            Declaration(
                inputs={"robot_report_received": Input(ROBOT_REPORT.size)},
                outputs={"f_haptic": Output(3, show_force)},
            )
        )
