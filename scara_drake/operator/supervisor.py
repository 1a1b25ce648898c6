"""The operator's supervisor: whether the arm may follow him now, and if not, why."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common import checks
from scara_drake.common.block import Block, Declaration, Input, Memory
from scara_drake.common.fields import check
from scara_drake.operator.stick_filter import OPERATOR_INPUT, operator_input_of
from scara_drake.operator.supervision import (
    NONE,
    OperatorSupervision,
    first_watch,
    supervision_of,
    tell_warnings,
    watch_of,
)
from scara_drake.safety import Reason, State
from scara_drake.vectors import (
    DEVICE_STATUS,
    ROBOT_REPORT,
    SUPERVISOR_STATUS,
    device_status_of,
    operator_buttons_of,
    robot_report_of,
    supervisor_status_of,
)

Array = NDArray[np.float64]

FROM_ROBOT = 20  # reasons from here on are the robot's own; others it repeats from the operator

# As numbers, see `supervision`.
IDLE, ACTIVE, CLUTCH = float(State.IDLE), float(State.ACTIVE), float(State.CLUTCH)
HOLD, FAULT, ESTOP = float(State.HOLD), float(State.FAULT), float(State.ESTOP)
RELEASED, HELD = float(Reason.RELEASED), float(Reason.HELD)
CLUTCHED = float(Reason.CLUTCHED)
ESTOP_PRESSED, BAD_SAMPLE = float(Reason.ESTOP_PRESSED), float(Reason.BAD_SAMPLE)
DEVICE_LOST, DEVICE_STALE = float(Reason.DEVICE_LOST), float(Reason.DEVICE_STALE)
REPORT_LOST, COMMAND_LOST = float(Reason.REPORT_LOST), float(Reason.COMMAND_LOST)


@njit(cache=True)
def is_silent(device_status: Array, supervision: Array, watch: Array) -> bool:
    """Whether the device has said nothing for too long, as far as its clock can tell."""
    s, w = supervision_of(supervision), watch_of(watch)
    fresh = device_status_of(device_status).age <= s.stale_after  # NaN is not
    return not fresh or w.backwards_time[()] > s.stale_after


@njit(cache=True)
def find_cause(
    operator_input: Array,
    device_status: Array,
    robot_report_received: Array,
    report_silence: float,
    supervision: Array,
    watch: Array,
) -> tuple[float, float]:
    """Return the state that is asked for now, ACTIVE if nothing speaks against it, and why.

    A stop that the robot reports is a cause in the tick in which it is heard of first.
    """
    seen, d = operator_input_of(operator_input), device_status_of(device_status)
    robot = supervisor_status_of(robot_report_of(robot_report_received).status)
    button, s, w = operator_buttons_of(seen.buttons), supervision_of(supervision), watch_of(watch)
    heard = bool(np.isfinite(robot_report_of(robot_report_received).status).all())
    news = False
    if heard:
        worse = robot.state[()] >= HOLD and robot.state[()] > w.robot_state[()]
        news = (worse or robot.faults[()] != w.robot_faults[()]) and robot.reason[()] >= FROM_ROBOT
        w.robot_state[()], w.robot_faults[()] = robot.state[()], robot.faults[()]
    if button.estop > 0.0:
        return ESTOP, ESTOP_PRESSED
    if not (seen.bad[()] < s.bad_samples and d.bad_samples < s.bad_samples):  # NaN is not
        return FAULT, BAD_SAMPLE
    if news and robot.state[()] >= FAULT:
        return FAULT, robot.reason[()]
    if not d.connected > 0.0:
        return HOLD, DEVICE_LOST
    if button.hold > 0.0:
        return HOLD, HELD
    if news and robot.state[()] == HOLD:
        return HOLD, robot.reason[()]
    if is_silent(device_status, supervision, watch):
        return HOLD, DEVICE_STALE
    if not heard or not report_silence <= s.report_after:
        return HOLD, REPORT_LOST
    return ACTIVE, NONE


@njit(cache=True)
def stop(state: float, reason: float, operator_status: Array) -> None:
    """Go to a state that stops, in place; count it unless the operator asked for no more."""
    now = supervisor_status_of(operator_status)
    now.state[()], now.reason[()] = state, reason
    if reason != HELD and reason != RELEASED:
        now.faults[()] += 1.0


@njit(cache=True)
def go_on(
    buttons: Array,
    pressed: bool,
    robot_state: float,
    supervision: Array,
    watch: Array,
    operator_status: Array,
) -> None:
    """The next state where nothing speaks against following and nothing is latched, in place."""
    button, s, w = operator_buttons_of(buttons), supervision_of(supervision), watch_of(watch)
    now = supervisor_status_of(operator_status)
    held = button.engage > 0.0 or s.dead_man == 0.0
    if now.state[()] in (ACTIVE, CLUTCH):
        if not held or (pressed and s.dead_man == 0.0):
            stop(HOLD, RELEASED, operator_status)
            return
        clutched = button.clutch > 0.0
        now.state[()] = CLUTCH if clutched else ACTIVE
        now.reason[()] = CLUTCHED if clutched else w.warning[()]
        return
    resumes = s.resumes > 0.0 and w.interrupted[()] > 0.0 and held
    if (pressed or resumes) and robot_state < FAULT:
        now.state[()], now.reason[()] = ACTIVE, w.warning[()]
        now.engagements[()] += 1.0


@njit(cache=True)
def remember(
    buttons: Array, gone: bool, asked: float, why: float, supervision: Array, watch: Array
) -> None:
    """Keep the buttons for the next tick, and whether a hold may still resume, in place.

    What is held through a loss of the device has to be let go before it is pressed again.
    """
    button, w = operator_buttons_of(buttons), watch_of(watch)
    w.engage[()] = 1.0 if gone else button.engage
    w.reset[()] = 1.0 if gone else button.reset
    other = asked != ACTIVE and why not in (DEVICE_STALE, REPORT_LOST, COMMAND_LOST)
    released = button.engage == 0.0 and supervision_of(supervision).dead_man > 0.0
    if other or released:
        w.interrupted[()] = 0.0


@njit(cache=True)
def supervise(
    operator_input: Array,
    device_status: Array,
    robot_report_received: Array,
    age_down: Array,
    delay_down: Array,
    supervision: Array,
    watch: Array,
    operator_status: Array,
) -> None:
    """One tick of `OperatorSupervisor`, in place."""
    seen, w = operator_input_of(operator_input), watch_of(watch)
    now, button = supervisor_status_of(operator_status), operator_buttons_of(seen.buttons)
    robot = supervisor_status_of(robot_report_of(robot_report_received).status)
    tell_warnings(seen.spikes[()], device_status, supervision, watch)
    asked, why = find_cause(
        operator_input,
        device_status,
        robot_report_received,
        age_down[0] - delay_down[0],
        supervision,
        watch,
    )
    pressed = button.engage > 0.0 and w.engage[()] == 0.0
    reset = button.reset > 0.0 and w.reset[()] == 0.0
    there = device_status_of(device_status).connected > 0.0
    w.waits[()] = max(w.waits[()] - supervision_of(supervision).period, 0.0)
    gone = not there or is_silent(device_status, supervision, watch) or w.waits[()] > 0.0
    remember(seen.buttons, gone, asked, why, supervision, watch)
    state = now.state[()]
    if asked >= FAULT:
        if asked > state:
            stop(asked, why, operator_status)
    elif state >= FAULT:
        if reset:
            now.state[()], now.reason[()] = IDLE, why
    elif reset and state == IDLE and robot.state[()] >= FAULT:
        # The robot has not taken the last reset: latched again, so that it hears of the next one.
        stop(FAULT, robot.reason[()], operator_status)
    elif asked == HOLD:
        if state in (ACTIVE, CLUTCH):
            stop(HOLD, why, operator_status)
            w.interrupted[()] = 1.0 if why in (DEVICE_STALE, REPORT_LOST, COMMAND_LOST) else 0.0
        now.reason[()] = why
    else:
        if state == IDLE:
            now.reason[()] = robot.reason[()] if robot.state[()] >= FAULT else NONE
        go_on(seen.buttons, pressed, robot.state[()], supervision, watch, operator_status)


class OperatorSupervisor(Block):
    """Says whether the arm may follow the operator, and if not, why.

    Ports:
        input operator_input (16): of `StickFilter`.
        input device_status (4): of the device; one that is always there if not connected.
        input robot_report_received (15): after the channel; of an idle robot if not connected.
        input age_down (1), delay_down (1) [s]: of the packet of the report, if it comes in packets.
        output operator_status (4): state, reason, engagements, faults; see `safety`.

    Update, at t = k period: an emergency stop, bad samples and a fault of the robot latch ESTOP or
    FAULT, which a press of reset leaves to IDLE once its cause is gone. A device that is lost or
    silent, a robot that is silent or holds, and the hold button stop ACTIVE and CLUTCH; so does the
    dead-man button where it is let go. A press of it, not its being held, goes ACTIVE from IDLE and
    HOLD, if nothing speaks against it and the robot is in no fault. ACTIVE tells the warning that
    is fresh as its reason. Initial: IDLE.

    Args:
        config: when it stops.
        live: there is a device, whose buttons may be held by something at the start; those of a
            trace are pressed from its first row on.
        period: [s].

    Raises:
        ValueError: a field, or the period, is out of its bounds.
    """

    def __init__(
        self, config: OperatorSupervision, live: bool = True, period: float = 1e-3
    ) -> None:
        check(config, "operator")
        checks.number("period", period, 1e-4, 0.1)
        super().__init__(
            Declaration(
                inputs={
                    "operator_input": Input(OPERATOR_INPUT.size),
                    "device_status": Input(DEVICE_STATUS.size, default=(1.0, 0.0, 0.0, 0.0)),
                    "robot_report_received": Input(
                        ROBOT_REPORT.size, default=(0.0,) * ROBOT_REPORT.size
                    ),
                    "age_down": Input(1, default=(0.0,)),
                    "delay_down": Input(1, default=(0.0,)),
                },
                memory={
                    "operator_status": Memory(SUPERVISOR_STATUS.size, port=True),
                    "watch": Memory(first_watch(config, live)),
                },
                parameters={"supervision": config.parameters(period)},
                period=period,
                update=supervise,
            )
        )
