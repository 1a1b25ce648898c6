"""How an arm that is held finds out that its command leads back, and how it then goes there."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.scratch import scratch
from scara_drake.ik.kernels.errors import error_kernel
from scara_drake.ik.kernels.limiter import limits_of, settings_of, turn
from scara_drake.ik.kernels.postures import Bounds, Goal
from scara_drake.ik.kernels.refine import Descent, refine_kernel
from scara_drake.ik.result import POSITION_TOLERANCE, ROTATION_LENGTH, ROTATION_TOLERANCE
from scara_drake.kinematics import rotation_from_quaternion_kernel, rotation_vector_kernel
from scara_drake.vectors import servo_state_of, state_of, tool_command_of

Array = NDArray[np.float64]

CATCHING_UP = 3.0  # of the status: on the way to a posture that is further than a period's motion
# The arm follows up to this share of the tolerances, and up to all of them only where the command
# leads back: else a way back that first costs a millionth more would be held for ever.
OUTWARD_SHARE = 0.9
# Of their speed limits, where the joints go straight to a posture that is nearer to the command.
RETREAT_SHARE = 0.1
# How far ahead it is asked whether the command leads back [m], [rad], and with how many steps.
AHEAD, AHEAD_ANGLE, AHEAD_STEPS = 0.02, 0.05, 15
FAR = 0.5  # a posture further away than this is on another branch [m], [rad]


@njit(cache=True)
def share_of_tolerance(servo_state: Array, q: Array, position_only: bool) -> float:
    """Return the larger of the errors of q (6,) at the limiter's pose, in their tolerances."""
    now, R_desired = servo_state_of(servo_state), scratch(3, 3)
    rotation_from_quaternion_kernel(now.quaternion, R_desired)
    position, rotation = error_kernel(q, now.p, R_desired)
    share = position / POSITION_TOLERANCE
    return share if position_only else max(share, rotation / ROTATION_TOLERANCE)


@njit(cache=True)
def leads_back(
    tool_command: Array, good: Array, settings: Array, limits: Array, ahead: Array, there: Array
) -> bool:
    """Return whether the pose a little ahead, towards the command, is better met than this one.

    Both by least squares, which has the errors that are left at each. Where the way begins over
    worse poses, as beside a singular posture, it is the command itself that has to be met.

    Args:
        tool_command: (8,).
        good: the limiter (17,) where the arm is held.
        settings: see `limiter.Settings`.
        limits: see `limiter.Limits`.
        ahead: copy of `good`; returns the limiter ahead.
        there: posture (6,) that is held; returns the one ahead.
    """
    command, now = tool_command_of(tool_command), servo_state_of(good)
    position_only, here = settings_of(settings).position_first > 0.0, there.copy()
    R, R_desired, w = scratch(3, 3), scratch(3, 3), scratch(3)
    rotation_from_quaternion_kernel(now.quaternion, R)
    rotation_from_quaternion_kernel(command.quaternion, R_desired)
    angle = rotation_vector_kernel(R_desired, R, w)
    distance = np.sqrt(np.sum((command.p - now.p) ** 2))
    share = min(1.0, AHEAD / max(distance, AHEAD), AHEAD_ANGLE / max(angle, AHEAD_ANGLE))
    held = there.copy()
    look_ahead(tool_command, good, settings, limits, 0.0, ahead, here)
    before = share_of_tolerance(good, here, position_only)
    after = look_ahead(tool_command, good, settings, limits, share, ahead, there)
    if after <= 1.0 and np.abs(there - held).max() <= FAR and after < 0.99 * before:
        return True
    there[:] = held
    after = look_ahead(tool_command, good, settings, limits, 1.0, ahead, there)
    return after <= OUTWARD_SHARE and np.abs(there - held).max() <= FAR


@njit(cache=True)
def look_ahead(
    tool_command: Array,
    good: Array,
    settings: Array,
    limits: Array,
    share: float,
    ahead: Array,
    there: Array,
) -> float:
    """Move limiter (17,) and posture (6,) by a share of the way to a command, in place.

    Returns the error that is left there, see `share_of_tolerance`.
    """
    command, now, then = tool_command_of(tool_command), servo_state_of(good), servo_state_of(ahead)
    s, most, R, w = settings_of(settings), limits_of(limits), scratch(3, 3), scratch(3)
    ahead[:] = good
    R_ahead = scratch(3, 3)
    rotation_from_quaternion_kernel(now.quaternion, R)
    rotation_from_quaternion_kernel(command.quaternion, R_ahead)
    rotation_vector_kernel(R_ahead, R, w)
    for i in range(3):
        then.p[i] += share * (command.p[i] - now.p[i])
    turn(then.quaternion, w, share)
    first_joint = 1 if s.mast_follows > 0.0 else 0
    if first_joint == 1:
        height = now.mast[()] + share * (command.mast[()] - now.mast[()])
        then.mast[()] = there[0] = min(max(height, most.lower[0]), most.upper[0])
    rotation_from_quaternion_kernel(then.quaternion, R_ahead)
    bounds = Bounds(first_joint, most.lower.copy(), most.upper.copy())
    position_only = s.position_first > 0.0
    length, none = 0.0 if position_only else ROTATION_LENGTH, scratch(0, 2)
    descent = Descent(length, FAR, AHEAD_STEPS, False)
    refine_kernel(there, Goal(then.p.copy(), R_ahead, bounds), descent, none)
    return share_of_tolerance(ahead, there, position_only)


@njit(cache=True)
def retreat(
    servo_state: Array,
    state_desired: Array,
    ahead: Array,
    there: Array,
    limits: Array,
    period: float,
) -> None:
    """Move references (12,) and limiter (17,) straight towards those ahead, slowly, in place."""
    desired, now, then = state_of(state_desired), servo_state_of(servo_state), servo_state_of(ahead)
    slowest, rate = 1.0, limits_of(limits).rate
    for i in range(6):
        slowest = max(slowest, abs(there[i] - desired.q[i]) / (RETREAT_SHARE * period * rate[i]))
    R, R_ahead, w = scratch(3, 3), scratch(3, 3), scratch(3)
    rotation_from_quaternion_kernel(now.quaternion, R)
    rotation_from_quaternion_kernel(then.quaternion, R_ahead)
    rotation_vector_kernel(R_ahead, R, w)
    for i in range(6):
        step = (there[i] - desired.q[i]) / slowest
        desired.q[i] += step
        desired.v[i] = step / period
    for i in range(3):
        now.p[i] += (then.p[i] - now.p[i]) / slowest
    now.mast[()] += (then.mast[()] - now.mast[()]) / slowest
    turn(now.quaternion, w, 1.0 / slowest)
    now.status[()] = CATCHING_UP
