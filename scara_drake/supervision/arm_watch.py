"""The watch over the arm: what is wrong with it, whoever commands."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.block import Block, Declaration, Input, Memory
from scara_drake.common.fields import check
from scara_drake.common.layout import Cell, Layout
from scara_drake.common.scratch import scratch
from scara_drake.joints import EFFORT, MAX_SPEED
from scara_drake.kinematics import quaternion_from_rotation_kernel, tool_pose_kernel
from scara_drake.safety import Reason
from scara_drake.supervision.config import RobotSupervision
from scara_drake.supervision.layouts import ARM_CONDITION, arm_condition_of
from scara_drake.vectors import STATE, state_of, tool_command_of

Array = NDArray[np.float64]

NONE, BAD_MEASUREMENT = float(Reason.NONE), float(Reason.BAD_MEASUREMENT)
TRACKING, OVER_FORCE = float(Reason.TRACKING), float(Reason.OVER_FORCE)
SPEED_LIMIT, EFFORT_LIMIT = float(Reason.SPEED_LIMIT), float(Reason.EFFORT_LIMIT)
WINDUP, CHATTER = float(Reason.WINDUP), float(Reason.CHATTER)
AT_SPEED = 0.999  # of a joint's fastest rate, from which on it is at it
EFFORT_TIME = 0.1  # [s], over which the variation of the efforts is averaged


class ArmBounds(NamedTuple):
    """Of `RobotSupervision`, and of the drives.

    Attributes:
        tracking_tool: [m].
        tracking_angle: [rad].
        tracking_ticks: for which the arm is away before it counts as lost.
        max_force: [N].
        chatter: [1/s].
        warn_ticks: for which a condition lasts before it is told.
        forget: share of the average of the efforts' variation that a tick takes off.
        period: [s].
        effort: limits (6,) [N, N m].
        rate: fastest (6,) [m/s, rad/s].
    """

    tracking_tool: float
    tracking_angle: float
    tracking_ticks: float
    max_force: float
    chatter: float
    warn_ticks: float
    forget: float
    period: float
    effort: Array
    rate: Array


class History(NamedTuple):
    """Memory of the watch, in ticks: how long each condition has lasted.

    Attributes:
        away: from the references.
        fast: at a speed limit.
        full: at an effort limit.
        wound: outside the boundary layer.
        actuation: last one (6,) [N, N m].
    """

    away: Cell
    fast: Cell
    full: Cell
    wound: Cell
    actuation: Array


ARM_BOUNDS = Layout(ArmBounds, effort=6, rate=6)
HISTORY = Layout(History, away=(), fast=(), full=(), wound=(), actuation=6)
arm_bounds_of = ARM_BOUNDS.reader()
history_of = HISTORY.reader()


@njit(cache=True)
def measure(state: Array, f_env_on_tool_W: Array, arm_condition: Array) -> None:
    """Write the measured pose of the tool, and the force."""
    arm, q = arm_condition_of(arm_condition), state_of(state).q
    tool, R = tool_command_of(arm.tool), scratch(3, 3)
    tool_pose_kernel(q, tool.p, R)
    quaternion_from_rotation_kernel(R, tool.quaternion)
    tool.mast[()] = q[0]
    arm.f[:] = f_env_on_tool_W
    arm.force[()] = np.sqrt(np.sum(arm.f * arm.f))


@njit(cache=True)
def is_away(state: Array, state_desired: Array, bounds: Array, arm_condition: Array) -> bool:
    """Return whether the tool or a joint is farther from its reference than it may be."""
    b, now, wanted = arm_bounds_of(bounds), state_of(state), state_of(state_desired)
    p, R = scratch(3), scratch(3, 3)
    tool_pose_kernel(wanted.q, p, R)
    tool = tool_command_of(arm_condition_of(arm_condition).tool)
    p -= tool.p
    if np.sqrt(np.sum(p * p)) > b.tracking_tool:
        return True
    for i in range(1, 6):
        if abs(now.q[i] - wanted.q[i]) > b.tracking_angle:
            return True
    return abs(now.q[0] - wanted.q[0]) > b.tracking_tool


@njit(cache=True)
def lasts(cell: Cell, condition: bool, ticks: float) -> bool:
    """Count for how long a condition lasts; return whether that is longer than some ticks."""
    cell[()] = cell[()] + 1.0 if condition else 0.0
    return bool(cell[()] > ticks)


@njit(cache=True)
def warning_of(
    state_desired: Array,
    actuation: Array,
    saturation: Array,
    bounds: Array,
    history: Array,
    arm_condition: Array,
) -> float:
    """Return the `safety.Reason` that is to be told, or 0; the gravest first."""
    b, m, arm = arm_bounds_of(bounds), history_of(history), arm_condition_of(arm_condition)
    desired = state_of(state_desired)
    fast = full = wound = False
    variation = 0.0
    for i in range(6):
        fast = fast or abs(desired.v[i]) > AT_SPEED * b.rate[i]
        bits = int(saturation[i])
        wound, full = wound or bits % 2 == 1, full or bits >= 2
        variation = max(variation, abs(actuation[i] - m.actuation[i]) / b.effort[i])
    m.actuation[:] = actuation
    arm.efforts[()] += b.forget * (variation / b.period - arm.efforts[()])
    fast, full = lasts(m.fast, fast, b.warn_ticks), lasts(m.full, full, b.warn_ticks)
    wound = lasts(m.wound, wound, b.warn_ticks)
    if full:
        return EFFORT_LIMIT
    if wound:
        return WINDUP
    if arm.efforts[()] > b.chatter:
        return CHATTER
    return SPEED_LIMIT if fast else NONE


@njit(cache=True)
def watch_arm(
    state: Array,
    state_desired: Array,
    f_env_on_tool_W: Array,
    actuation: Array,
    saturation: Array,
    bounds: Array,
    history: Array,
    arm_condition: Array,
) -> None:
    """One tick of `ArmWatch`, in place."""
    b, m, arm = arm_bounds_of(bounds), history_of(history), arm_condition_of(arm_condition)
    arm.fault[()] = NONE
    if not (np.isfinite(state).all() and np.isfinite(f_env_on_tool_W).all()):
        arm.fault[()] = BAD_MEASUREMENT
        return
    measure(state, f_env_on_tool_W, arm_condition)
    away = is_away(state, state_desired, bounds, arm_condition)
    arm.away[()] = 1.0 if away else 0.0
    if lasts(m.away, away, b.tracking_ticks):
        arm.fault[()], m.away[()] = TRACKING, 0.0
    elif arm.force[()] > b.max_force:
        arm.fault[()] = OVER_FORCE
    arm.warning[()] = warning_of(
        state_desired, actuation, saturation, bounds, history, arm_condition
    )


class ArmWatch(Block):
    """Finds what is wrong with the arm.

    Ports:
        input state (12): as the sensors show it [m, rad, m/s, rad/s]; NaN is a fault.
        input state_desired (12): references.
        input f_env_on_tool_W (3) [N]: zero where unconnected; NaN is a fault.
        input actuation (6), saturation (6): of the controller, zero where unconnected.
        output arm_condition (16): see `layouts.ArmCondition`.

    Update, at t = k period: BAD_MEASUREMENT where state or force is no number;
    TRACKING, for a tick, each time that the arm has been away from its references for
    `tracking_time`; OVER_FORCE while the force is above `max_force`. Warnings after
    `warn_time`: EFFORT_LIMIT and WINDUP by the bits of `saturation`, SPEED_LIMIT by the references;
    CHATTER by max |d tau / dt| / tau_max over the joints, averaged over 0.1 s. Initial: nothing is
    wrong.

    Args:
        config: checked.
        initial: measured pose of the tool at the start, a tool command (8,).
        period: [s].

    Raises:
        ValueError: a field is out of its bounds.
    """

    def __init__(self, config: RobotSupervision, initial: Array, period: float = 1e-3) -> None:
        check(config, "supervision.robot")
        zeros = (0.0,) * 6
        super().__init__(
            Declaration(
                inputs={
                    "state": Input(STATE.size),
                    "state_desired": Input(STATE.size),
                    "f_env_on_tool_W": Input(3, default=zeros[:3]),
                    "actuation": Input(6, default=zeros),
                    "saturation": Input(6, default=zeros),
                },
                memory={
                    "arm_condition": Memory(ARM_CONDITION.zeros(tool=initial), port=True),
                    "history": Memory(HISTORY.size),
                },
                parameters={
                    "bounds": ARM_BOUNDS.pack(
                        tracking_tool=config.tracking_tool,
                        tracking_angle=config.tracking_angle,
                        tracking_ticks=math.ceil(config.tracking_time / period),
                        max_force=config.max_force,
                        chatter=config.chatter,
                        warn_ticks=math.ceil(config.warn_time / period),
                        forget=-math.expm1(-period / EFFORT_TIME),
                        period=period,
                        effort=EFFORT,
                        rate=MAX_SPEED,
                    )
                },
                period=period,
                update=watch_arm,
            )
        )
