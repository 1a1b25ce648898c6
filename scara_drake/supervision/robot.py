"""The robot's supervisor, which stands between the channel and the inverse kinematics."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from scara_drake.common.block import Block, Declaration, Input, Memory, Output
from scara_drake.common.fields import check
from scara_drake.ik.kernels.limiter import LIMITS
from scara_drake.ik.result import ROTATION_LENGTH
from scara_drake.ik.system import InverseKinematics
from scara_drake.joints import LOWER, MAX_SPEED, UPPER
from scara_drake.kinematics import A4, D6
from scara_drake.safety import Reason, State
from scara_drake.supervision.config import AFTER_OUTAGE, RobotSupervision
from scara_drake.supervision.gate import keep_within_limits
from scara_drake.supervision.layouts import (
    ARM_CONDITION,
    BOUNDS,
    LINK_CONDITION,
    SUPERVISOR,
    arm_condition_of,
    bounds_of,
    supervisor_of,
)
from scara_drake.supervision.machine import CLUTCHED, change_state, is_engaged
from scara_drake.supervision.placing import offset_between, place_at_stop, put_beside
from scara_drake.vectors import (
    COMMAND_FRAME,
    SERVO_STATE,
    STATE,
    SUPERVISOR_STATUS,
    TOOL_COMMAND,
    command_frame_of,
    servo_state_of,
    state_of,
    supervisor_status_of,
    tool_command_of,
)

Array = NDArray[np.float64]

CLUTCH, FAULT, ESTOP = float(State.CLUTCH), float(State.FAULT), float(State.ESTOP)
NONE, UNREACHABLE = float(Reason.NONE), float(Reason.UNREACHABLE)
TRACKING, OVER_FORCE = float(Reason.TRACKING), float(Reason.OVER_FORCE)
BAD_MEASUREMENT = float(Reason.BAD_MEASUREMENT)
LINGER = 0.1  # [s], for which a warning stays, so that it can be read
HOLDING = 1.0  # a status of the servo
FARTHEST_BACK = 0.1  # [m], that the tool backs off altogether
ARRIVED = 0.1  # of a retract, from the stop: there


@njit(cache=True)
def place_stop(
    reason: float, arm_condition: Array, servo_state: Array, bounds: Array, supervisor: Array
) -> None:
    """Write the command at which the arm stops; after too large a force, behind the contact."""
    m, b, arm = supervisor_of(supervisor), bounds_of(bounds), arm_condition_of(arm_condition)
    place_at_stop(servo_state, b.motion, m.command)
    stop, measured = tool_command_of(m.command), tool_command_of(arm.tool)
    if reason == TRACKING:
        m.command[:] = arm.tool
    if reason == OVER_FORCE and arm.force[()] > 0.0:
        m.backed_off[()] = b.retract
        for i in range(3):
            stop.p[i] = measured.p[i] + b.retract * arm.f[i] / arm.force[()]


@njit(cache=True)
def back_off(arm_condition: Array, servo_state: Array, bounds: Array, supervisor: Array) -> None:
    """Move the stop on along the force, once the tool is there and pressed all the same.

    A stiff surface that was pressed in deep needs more than one `retract`, and a soft one gets no
    more than it needs.
    """
    m, b, arm = supervisor_of(supervisor), bounds_of(bounds), arm_condition_of(arm_condition)
    stop, now = tool_command_of(m.command).p, servo_state_of(servo_state).p
    way = np.sqrt((stop[0] - now[0]) ** 2 + (stop[1] - now[1]) ** 2 + (stop[2] - now[2]) ** 2)
    small, far = arm.force[()] <= b.release, m.backed_off[()] + b.retract > FARTHEST_BACK + 1e-9
    if small or far or way > ARRIVED * b.retract:
        return
    m.backed_off[()] += b.retract
    for i in range(3):
        stop[i] += b.retract * arm.f[i] / arm.force[()]


@njit(cache=True)
def switch_drives(fault: float, supervisor: Array, drives_engaged: Array) -> None:
    """Leave the arm to its brakes from a bad measurement on until a reset, then start afresh."""
    m = supervisor_of(supervisor)
    state = supervisor_status_of(m.status).state[()]
    if fault == BAD_MEASUREMENT:
        m.blind[()] = 1.0
    elif m.blind[()] > 0.0 and state not in (FAULT, ESTOP):
        m.blind[()], m.restart[()] = 0.0, 1.0
        drives_engaged[0] = 0.0
    if m.blind[()] > 0.0:
        drives_engaged[0] = 0.0


@njit(cache=True)
def warn(reason: float, arm_condition: Array, linger: float, supervisor: Array) -> None:
    """Show why the arm follows only in part, or the warning of the arm; each stays a while."""
    m, status = supervisor_of(supervisor), supervisor_status_of(supervisor_of(supervisor).status)
    reason = reason if reason != NONE else arm_condition_of(arm_condition).warning[()]
    if reason != NONE:
        status.reason[()], m.warned[()] = reason, linger
    elif m.warned[()] > 0.0:
        m.warned[()] -= 1.0
    else:
        status.reason[()] = CLUTCHED if status.state[()] == CLUTCH else NONE


@njit(cache=True)
def supervise(
    command_frame_received: Array,
    link_condition: Array,
    arm_condition: Array,
    servo_state: Array,
    state_desired: Array,
    bounds: Array,
    supervisor: Array,
    drives_engaged: Array,
) -> None:
    """One tick of `RobotSupervisor`, in place."""
    m, b, arm = supervisor_of(supervisor), bounds_of(bounds), arm_condition_of(arm_condition)
    status, frame = supervisor_status_of(m.status), command_frame_of(command_frame_received)
    before, faults = status.state[()], status.faults[()]
    drives_engaged[0] = 1.0 - m.restart[()]
    m.restart[()] = 1.0 if arm.fault[()] == TRACKING else 0.0
    begins = change_state(command_frame_received, link_condition, arm_condition, bounds, supervisor)
    switch_drives(arm.fault[()], supervisor, drives_engaged)
    if begins:
        place_at_stop(servo_state, b.motion, m.command)
        offset_between(frame.tool_command, m.command, m.offset)
    if is_engaged(status.state[()]):
        put_beside(frame.tool_command, m.offset, m.command)
        reason = keep_within_limits(m.command, servo_state, state_of(state_desired).q, bounds)
        if servo_state_of(servo_state).status[()] == HOLDING:
            reason = UNREACHABLE
        warn(reason, arm_condition, b.linger, supervisor)
    elif is_engaged(before) or status.faults[()] != faults or m.restart[()] > 0.0:
        why = TRACKING if m.restart[()] > 0.0 else status.reason[()]
        place_stop(why, arm_condition, servo_state, bounds, supervisor)
    elif status.state[()] == FAULT and status.reason[()] == OVER_FORCE:
        back_off(arm_condition, servo_state, bounds, supervisor)


@njit(cache=True)
def show_command(supervisor: Array, tool_command_supervised: Array) -> None:
    """Write the command (8,)."""
    tool_command_supervised[:] = supervisor_of(supervisor).command


@njit(cache=True)
def show_robot_status(supervisor: Array, robot_status: Array) -> None:
    """Write the status (4,)."""
    robot_status[:] = supervisor_of(supervisor).status


@njit(cache=True)
def show_restart(supervisor: Array, references_restart: Array) -> None:
    """Write whether the references are put where the arm is (1,)."""
    references_restart[0] = supervisor_of(supervisor).restart[()]


def pack_bounds(config: RobotSupervision, kinematics: InverseKinematics, period: float) -> Array:
    """Return the bounds as `layouts.bounds_of` reads them, for a period [s]."""
    length = 1.0 if kinematics.task == "position" else ROTATION_LENGTH
    return BOUNDS.pack(
        motion=kinematics.settings(period),
        limits=LIMITS.pack(lower=LOWER, upper=UPPER, rate=MAX_SPEED),
        after_outage=AFTER_OUTAGE.index(config.after_outage),
        reach=config.reach_share * (A4 + D6),
        box_lower=config.box_lower,
        box_upper=config.box_upper,
        joint_margin=config.joint_margin,
        horizon=config.horizon,
        singularity_slow=config.singularity_slow * length,
        singularity_stop=config.singularity_stop * length,
        retract=config.retract,
        release=config.release_share * config.max_force,
        linger=math.ceil(LINGER / period),
    )


class RobotSupervisor(Block):
    """Lets a command pass while its operator is engaged and nothing is wrong, and stops else.

    Ports:
        input command_frame_received (10): see `vectors.CommandFrame`; NaN is a fault.
        input link_condition (4), arm_condition (16): of the two watches, see `layouts`.
        input servo_state (17), state_desired (12): of the inverse kinematics.
        output tool_command_supervised (8).
        output robot_status (4): see `vectors.SupervisorStatus`.
        output references_restart (1): 1 for the tick in which the references are put where the arm
            is, as it was away from them.
        output drives_engaged (1): 0 for the tick after it, so that the controller starts afresh;
            and from a bad measurement on until a reset: the brakes hold the arm then.

    Update, at t = k period: the state by `machine.change_state`. At an engagement the offset
    between where the arm can stop and the first command is kept, so that nothing jumps, whatever is
    commanded; while engaged the command beside that offset passes through `gate`. At a stop the
    command becomes the point at which the limiter comes to rest as fast as it may, and stays; after
    too large a force it moves on along the force, a `retract` at a time, until that is small.
    Initial: IDLE at `initial`.

    Args:
        config: checked.
        kinematics: the inverse kinematics that follows; checked.
        initial: (8,).
        period: [s].

    Raises:
        ValueError: a field is out of its bounds.
    """

    def __init__(
        self,
        config: RobotSupervision,
        kinematics: InverseKinematics,
        initial: ArrayLike,
        period: float = 1e-3,
    ) -> None:
        check(config, "supervision.robot")
        turn = np.array([1.0, 0.0, 0.0, 0.0])
        memory = SUPERVISOR.zeros(command=initial, offset=TOOL_COMMAND.zeros(quaternion=turn))
        super().__init__(
            Declaration(
                inputs={
                    "command_frame_received": Input(COMMAND_FRAME.size),
                    "link_condition": Input(LINK_CONDITION.size),
                    "arm_condition": Input(ARM_CONDITION.size),
                    "servo_state": Input(SERVO_STATE.size),
                    "state_desired": Input(STATE.size),
                },
                memory={
                    "supervisor": Memory(memory),
                    "drives_engaged": Memory([1.0], port=True),
                },
                outputs={
                    "tool_command_supervised": Output(TOOL_COMMAND.size, show_command),
                    "robot_status": Output(SUPERVISOR_STATUS.size, show_robot_status),
                    "references_restart": Output(1, show_restart),
                },
                parameters={"bounds": pack_bounds(config, kinematics, period)},
                period=period,
                update=supervise,
            )
        )
