"""From the stick of a supervised operator to the tool command: smooth, bounded, without a jump.

The stick and the tool are brought together anew (re-indexed) where an engagement begins, where the
clutch is let go, and where the scale changes; from there on the tool goes where the stick goes, or
as fast. Whenever the operator's side is not ACTIVE the command brakes to rest within its bounds,
and stands.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common import checks
from scara_drake.common.block import Block, Declaration, Input, Memory
from scara_drake.common.fields import check
from scara_drake.common.motion import turn
from scara_drake.common.scratch import scratch
from scara_drake.common.smooth import length_of
from scara_drake.operator.mapping import JoystickMapping, initial_command
from scara_drake.operator.smooth_stick import (
    MOTION,
    brake,
    follow_stick,
    motion_of,
    pack_mapping,
    stick_mapping_of,
)
from scara_drake.operator.stick_filter import OPERATOR_INPUT
from scara_drake.safety import State
from scara_drake.vectors import (
    LIVE_SETTINGS,
    NEUTRAL_SETTINGS,
    ROBOT_REPORT,
    SUPERVISOR_STATUS,
    live_settings_of,
    robot_report_of,
    supervisor_status_of,
    tool_command_of,
)

Array = NDArray[np.float64]

ACTIVE = float(State.ACTIVE)
LARGEST_SCALE = 10.0  # of the live settings


@njit(cache=True)
def begin_where_the_robot_is(robot_report_received: Array, tool_command: Array) -> None:
    """Put the command (8,) where the robot reports to be, in place, if that is a place."""
    there = robot_report_of(robot_report_received).tool_command
    length = length_of(tool_command_of(there).quaternion)
    if np.isfinite(there).all() and length > 0.5:
        tool_command[:] = there
        command = tool_command_of(tool_command)
        for i in range(4):
            command.quaternion[i] /= length


@njit(cache=True)
def map_supervised(
    operator_input: Array,
    operator_status: Array,
    robot_report_received: Array,
    live_settings: Array,
    mapping: Array,
    motion: Array,
    tool_command: Array,
    operator_status_mapped: Array,
) -> None:
    """One tick of `SupervisedMapping`, in place."""
    g, m = stick_mapping_of(mapping), motion_of(motion)
    status = supervisor_status_of(operator_status)
    before = supervisor_status_of(operator_status_mapped)
    command, p, scale = tool_command_of(tool_command), scratch(3), m.scale[()]
    asked = live_settings_of(live_settings).motion_scale
    if np.isfinite(asked):
        scale = min(max(asked, 0.0), LARGEST_SCALE)
    engages = status.engagements[()] != before.engagements[()]
    if engages:
        begin_where_the_robot_is(robot_report_received, tool_command)
    p[:] = command.p
    p[2] -= command.mast[()]
    if status.state[()] == ACTIVE:
        meets = engages or before.state[()] != ACTIVE
        follow_stick(operator_input, meets, scale, p, command.mast[()], mapping, motion)
    else:
        brake(mapping, motion)
    command.mast[()] += g.period * m.climb[0]
    for i in range(3):
        command.p[i] = p[i] + g.period * m.v[i]
    command.p[2] += command.mast[()]
    turn(command.quaternion, m.w, g.period)
    operator_status_mapped[:] = operator_status


class SupervisedMapping(Block):
    """Turns what a supervised operator does into the commanded pose of the tool.

    Ports:
        input operator_input (16): of `StickFilter`.
        input operator_status (4): of `OperatorSupervisor`.
        input robot_report_received (15): after the channel; if not connected, the command begins an
            engagement where it stands.
        input live_settings (5): of which `motion_scale` counts, 0 to 10; 1 if not connected.
        output tool_command (8).
        output operator_status_mapped (4): the status that this command belongs to.

    Update, at t = k period, with r = p_WE - [0, 0, d1] the tool point relative to the arm's base,
    s the stick without its dead zone, and ACTIVE::

        target = origin + scale motion_scale (s - centre)     mode "position"
               = r + lead(rate motion_scale s)                mode "rate"

    drawn into the arm's reach, to which r goes as `common.smooth.approach` does. The mast goes at
    mast_rate times its axis, its hat, and the stick's z while the mast button is down, in place of
    the tool's height; it stops before its limits. The tool turns at turn_rate times the axes of
    orientation. Where ACTIVE begins, centre and origin are the stick, and where r comes to rest;
    where an engagement begins r is put where the robot reports to be. Else all rates go to zero
    within their bounds. Initial: `initial_command`, at rest.

    Args:
        mapping: how the stick drives the tool.
        period: [s].

    Raises:
        ValueError: a field of the mapping, or the period, is out of its bounds.
    """

    def __init__(self, mapping: JoystickMapping, period: float = 1e-3) -> None:
        check(mapping, "mapping")
        checks.number("period", period, 1e-4, 0.1)
        no_report = (np.nan,) * ROBOT_REPORT.size
        super().__init__(
            Declaration(
                inputs={
                    "operator_input": Input(OPERATOR_INPUT.size),
                    "operator_status": Input(SUPERVISOR_STATUS.size),
                    "robot_report_received": Input(ROBOT_REPORT.size, default=no_report),
                    "live_settings": Input(LIVE_SETTINGS.size, default=tuple(NEUTRAL_SETTINGS)),
                },
                memory={
                    "tool_command": Memory(initial_command(mapping), port=True),
                    "operator_status_mapped": Memory(SUPERVISOR_STATUS.size, port=True),
                    "motion": Memory(MOTION.zeros(scale=1.0)),
                },
                parameters={"mapping": pack_mapping(mapping, period)},
                period=period,
                update=map_supervised,
            )
        )
