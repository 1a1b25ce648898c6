"""The limiter of tool commands: whatever is commanded, its own state is a smooth tool motion."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.layout import Layout
from scara_drake.common.motion import limit_motion, turn
from scara_drake.common.scratch import scratch
from scara_drake.kinematics import (
    draw_into_reach,
    rotation_from_quaternion_kernel,
    rotation_vector_kernel,
)
from scara_drake.vectors import servo_state_of, tool_command_of

Array = NDArray[np.float64]


class Settings(NamedTuple):
    """`InverseKinematics` in a kernel.

    Attributes:
        mast_follows: 1 where the mast has a command of its own, or 0.
        position_first: 1 where orientation comes second, or 0.
        max_speed: of the tool point [m/s].
        max_acceleration: [m/s^2].
        max_turn_rate: of the tool [rad/s].
        max_turn_acceleration: [rad/s^2].
        mast_speed: [m/s].
        mast_acceleration: [m/s^2].
        bandwidth: of the limiter [1/s].
        position_gain: of the resolved rates [1/s].
        rotation_gain: [1/s].
        period: [s].
    """

    mast_follows: float
    position_first: float
    max_speed: float
    max_acceleration: float
    max_turn_rate: float
    max_turn_acceleration: float
    mast_speed: float
    mast_acceleration: float
    bandwidth: float
    position_gain: float
    rotation_gain: float
    period: float


class Limits(NamedTuple):
    """Of the joints, (6,) each.

    Attributes:
        lower: positions [m, rad].
        upper: positions [m, rad].
        rate: fastest rates [m/s, rad/s].
    """

    lower: Array
    upper: Array
    rate: Array


SETTINGS = Layout(Settings)
LIMITS = Layout(Limits, lower=6, upper=6, rate=6)
settings_of = SETTINGS.reader()
limits_of = LIMITS.reader()


@njit(cache=True)
def _follow_mast(target: float, servo_state: Array, settings: Array) -> None:
    """Advance the mast of the limiter one period towards a height [m]."""
    s, now = settings_of(settings), servo_state_of(servo_state)
    error, rate = scratch(1), now.mast_rate.reshape(1)
    error[0] = target - now.mast[()]
    limit_motion(error, rate, s.mast_speed, s.mast_acceleration, s.bandwidth, s.period)
    now.mast[()] += s.period * now.mast_rate[()]


@njit(cache=True)
def follow_command(tool_command: Array, servo_state: Array, settings: Array, limits: Array) -> bool:
    """Advance the limiter one period towards a tool command; return whether that was cut back.

    The mast height is followed only where `mast_follows`. A target beyond the arm's reach from its
    base is drawn back onto it.

    Args:
        tool_command: target (8,).
        servo_state: (17,), of which the limiter is changed in place.
        settings: see `Settings`.
        limits: see `Limits`.
    """
    command, now = tool_command_of(tool_command), servo_state_of(servo_state)
    s, bounds = settings_of(settings), limits_of(limits)
    bandwidth, dt = s.bandwidth, s.period
    cut = False
    if s.mast_follows > 0.0:
        target = min(max(command.mast[()], bounds.lower[0]), bounds.upper[0])
        cut = target != command.mast[()]
        _follow_mast(target, servo_state, settings)
    error = scratch(3)
    error[:] = command.p
    if s.mast_follows > 0.0:
        error[2] -= now.mast[()]
        cut = draw_into_reach(error) or cut
        error[2] += now.mast[()]
    for i in range(3):
        error[i] -= now.p[i]
    limit_motion(error, now.v, s.max_speed, s.max_acceleration, bandwidth, dt)
    R_desired, R = scratch(3, 3), scratch(3, 3)
    rotation_from_quaternion_kernel(command.quaternion, R_desired)
    rotation_from_quaternion_kernel(now.quaternion, R)
    rotation_vector_kernel(R_desired, R, error)
    limit_motion(error, now.w, s.max_turn_rate, s.max_turn_acceleration, bandwidth, dt)
    for i in range(3):
        now.p[i] += dt * now.v[i]
    turn(now.quaternion, now.w, dt)
    return cut


@njit(cache=True)
def slow_down(servo_state: Array, scale: float, dt: float) -> None:
    """Slow the limiter's motion of this period down by a factor, and take back what is too much."""
    now = servo_state_of(servo_state)
    for i in range(3):
        now.p[i] -= (1.0 - scale) * dt * now.v[i]
    now.mast[()] -= (1.0 - scale) * dt * now.mast_rate[()]
    for i in range(3):
        now.v[i] *= scale
        now.w[i] *= scale
    now.mast_rate[()] *= scale
