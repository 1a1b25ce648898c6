"""References that are put where the arm is, where it was away from them."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.scratch import scratch
from scara_drake.ik.kernels.limiter import limits_of
from scara_drake.ik.servo import servo_step
from scara_drake.kinematics import quaternion_from_rotation_kernel, tool_pose_kernel
from scara_drake.vectors import servo_state_of, state_of

Array = NDArray[np.float64]


@njit(cache=True)
def put_at(state: Array, state_desired: Array, servo_state: Array, limits: Array) -> None:
    """Put references (12,) and limiter (17,), in place, at rest where a state (12,) is."""
    measured, desired = state_of(state), state_of(state_desired)
    now, bounds, R = servo_state_of(servo_state), limits_of(limits), scratch(3, 3)
    for i in range(6):
        desired.q[i] = min(max(measured.q[i], bounds.lower[i]), bounds.upper[i])
        desired.v[i] = 0.0
    tool_pose_kernel(desired.q, now.p, R)
    quaternion_from_rotation_kernel(R, now.quaternion)
    now.mast[()] = desired.q[0]
    now.v[:] = 0.0
    now.w[:] = 0.0
    now.mast_rate[()] = 0.0


@njit(cache=True)
def restarting_step(
    tool_command: Array,
    references_restart: Array,
    state: Array,
    state_desired: Array,
    servo_state: Array,
    settings: Array,
    limits: Array,
) -> None:
    """`servo_step`, or in its place a restart where that is asked for and the state is known."""
    if references_restart[0] > 0.0 and np.isfinite(state).all():
        put_at(state, state_desired, servo_state, limits)
    else:
        servo_step(tool_command, state_desired, servo_state, settings, limits)
