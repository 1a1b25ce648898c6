"""The states of the robot's supervisor, and what brings it from one to the other."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.safety import Reason, State
from scara_drake.supervision.config import RESUME
from scara_drake.supervision.layouts import (
    arm_condition_of,
    bounds_of,
    link_condition_of,
    supervisor_of,
)
from scara_drake.vectors import command_frame_of, supervisor_status_of, tool_command_of

Array = NDArray[np.float64]

IDLE, ACTIVE, CLUTCH = float(State.IDLE), float(State.ACTIVE), float(State.CLUTCH)
HOLD, FAULT, ESTOP = float(State.HOLD), float(State.FAULT), float(State.ESTOP)
NONE, CLUTCHED, HELD = float(Reason.NONE), float(Reason.CLUTCHED), float(Reason.HELD)
ESTOP_PRESSED, COMMAND_LOST = float(Reason.ESTOP_PRESSED), float(Reason.COMMAND_LOST)
BAD_COMMAND = float(Reason.BAD_COMMAND)
FARTHEST = 100.0  # [m], a command beyond it is none


@njit(cache=True)
def is_command(command_frame: Array) -> bool:
    """Return whether a frame (10,) is a command: finite, a rotation, states that there are."""
    if not np.isfinite(command_frame).all():
        return False
    frame = command_frame_of(command_frame)
    asked = tool_command_of(frame.tool_command)
    length = np.sqrt(np.sum(asked.quaternion * asked.quaternion))
    known = IDLE <= frame.state[()] <= ESTOP
    near = np.abs(asked.p).max() <= FARTHEST and abs(asked.mast[()]) <= FARTHEST
    return known and near and 0.5 <= length <= 2.0


@njit(cache=True)
def is_engaged(state: float) -> bool:
    """Return whether a `safety.State` lets the operator move the arm."""
    return state in (ACTIVE, CLUTCH)


@njit(cache=True)
def stop_for(state: float, reason: float, supervisor: Array) -> None:
    """Go into a state that stops, for a reason; it counts as a fault unless the operator did so."""
    m = supervisor_of(supervisor)
    status = supervisor_status_of(m.status)
    status.state[()], status.reason[()] = state, reason
    if reason != HELD:
        status.faults[()] += 1.0
    m.acknowledged[()] = 0.0
    m.warned[()] = 0.0


@njit(cache=True)
def engage(engagement: float, supervisor: Array) -> None:
    """Go from a stop to ACTIVE, in an engagement of the operator's."""
    m = supervisor_of(supervisor)
    status = supervisor_status_of(m.status)
    status.state[()], status.reason[()] = ACTIVE, NONE
    status.engagements[()] += 1.0
    m.seen[()] = engagement


@njit(cache=True)
def release_latch(frame_state: float, supervisor: Array) -> None:
    """Leave FAULT and E-STOP once the operator's side has known of it and then been reset.

    A reset that was pressed before the fault was known on that side is none.
    """
    m = supervisor_of(supervisor)
    status = supervisor_status_of(m.status)
    if frame_state in (FAULT, ESTOP):
        m.acknowledged[()] = 1.0
    elif m.acknowledged[()] > 0.0 and frame_state == IDLE:
        status.state[()], status.reason[()] = IDLE, NONE


@njit(cache=True)
def change_state(
    command_frame: Array,
    link_condition: Array,
    arm_condition: Array,
    bounds: Array,
    supervisor: Array,
) -> bool:
    """Advance the state by one tick, in place; return whether an engagement begins.

    Args:
        command_frame: (10,), as it came.
        link_condition: see `layouts.LinkCondition`.
        arm_condition: see `layouts.ArmCondition`.
        bounds: see `layouts.Bounds`.
        supervisor: memory, see `layouts.Supervisor`.
    """
    m, b = supervisor_of(supervisor), bounds_of(bounds)
    status, frame = supervisor_status_of(m.status), command_frame_of(command_frame)
    link, valid = link_condition_of(link_condition), is_command(command_frame)
    lost, fault = link.lost[()] > 0.0, arm_condition_of(arm_condition).fault[()]
    fault = fault if fault != NONE else link.fault[()]
    fault = fault if valid else BAD_COMMAND
    asked = frame.state[()] if valid else FAULT
    count = frame.engagements[()] if valid else m.seen[()]
    latched = status.state[()] in (FAULT, ESTOP)
    if valid and not lost and asked == ESTOP:
        if status.state[()] != ESTOP:
            stop_for(ESTOP, ESTOP_PRESSED, supervisor)
        m.acknowledged[()] = 1.0
        return False
    if fault != NONE:
        if not latched:
            stop_for(FAULT, fault, supervisor)
        return False
    if lost:
        m.was_lost[()] = 1.0
        if is_engaged(status.state[()]):
            stop_for(HOLD, COMMAND_LOST, supervisor)
        return False
    returned = m.was_lost[()] > 0.0
    m.was_lost[()] = 0.0
    if latched:
        m.seen[()] = count  # an engagement from before the reset is none after it
        release_latch(asked, supervisor)
        return False
    if is_engaged(status.state[()]) and is_engaged(asked) and count == m.seen[()]:
        status.state[()] = asked
        return False
    if is_engaged(asked) and not (returned and b.after_outage != RESUME):
        resumes = returned and status.reason[()] == COMMAND_LOST
        if count != m.seen[()] or resumes:
            engage(count, supervisor)
            return True
    elif is_engaged(status.state[()]):
        stop_for(HOLD, HELD, supervisor)
    if returned:
        m.seen[()] = count  # an engagement from before the outage's end is none after it
    return False
