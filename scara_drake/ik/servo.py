"""One sample of the inverse kinematics in the loop: limit the command, then resolve its rates.

A second-order limiter follows the command with bounded speed and acceleration, so its own state is
a smooth tool motion (p, v, R, w) whatever the channel delivers. The joints follow it by resolved
rates, q' = J⁺ (v + gain (p - p(q))): the velocity reference is that q' and the position reference
its integral, so that the two agree exactly and nothing is differentiated.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.scratch import scratch
from scara_drake.ik.kernels.limiter import (
    follow_command,
    limits_of,
    settings_of,
    slow_down,
)
from scara_drake.ik.kernels.postures import Bounds
from scara_drake.ik.kernels.rates import joint_rates_kernel
from scara_drake.ik.leading_back import CATCHING_UP as CATCHING_UP
from scara_drake.ik.leading_back import (
    OUTWARD_SHARE,
    leads_back,
    retreat,
    share_of_tolerance,
)
from scara_drake.kinematics import (
    rotation_from_quaternion_kernel,
    rotation_vector_kernel,
    tool_pose_kernel,
)
from scara_drake.vectors import (
    POSE,
    SERVO_STATE,
    pose_vector,
    servo_state_of,
    state_of,
)

Array = NDArray[np.float64]

# Values of the status signal.
TRACKING = 0.0
HOLDING = 1.0  # the target cannot be reached: the last good answer is held
REACH_LIMITED = 2.0  # the target is drawn back into the reach of the arm


@njit(cache=True)
def resolve_rates(
    servo_state: Array, q: Array, settings: Array, limits: Array, rates: Array
) -> None:
    """Write the joint rates (6,) that follow the limiter and advance q (6,) by them.

    With `position_first` the tool point is followed exactly and the orientation as near as the
    remaining joints allow. All rates are scaled together where one would be too fast, and the
    limiter is slowed by the same factor.

    Args:
        servo_state: (17,), already advanced by `follow_command`; in place.
        q: configuration (6,) of the last period; in place.
        settings: see `limiter.Settings`.
        limits: see `limiter.Limits`.
        rates: result (6,).
    """
    now, s, bounds = servo_state_of(servo_state), settings_of(settings), limits_of(limits)
    p, R, R_desired = scratch(3), scratch(3, 3), scratch(3, 3)
    v, w = scratch(3), scratch(3)
    dt = s.period
    tool_pose_kernel(q, p, R)
    rotation_from_quaternion_kernel(now.quaternion, R_desired)
    rotation_vector_kernel(R_desired, R, w)
    for i in range(3):
        # Feedback acts on the error before this period's own motion, which v carries.
        before = now.p[i] - dt * now.v[i]
        v[i] = now.v[i] + s.position_gain * (before - p[i])
        w[i] = now.w[i] + s.rotation_gain * (w[i] - dt * now.w[i])
    scale = _tool_rates(q, v, w, now.mast_rate[()], settings, limits, rates)
    if scale < 1.0:
        slow_down(servo_state, scale, dt)
    for i in range(6):
        # A joint that would pass its limit in this period stops there.
        step = min(max(q[i] + dt * rates[i], bounds.lower[i]), bounds.upper[i]) - q[i]
        rates[i] = step / dt
        q[i] += step


@njit(cache=True)
def reference_rates(
    servo_state: Array, q: Array, settings: Array, limits: Array, rates: Array
) -> None:
    """Write the joint rates (6,) of the limiter's motion at q, without feedback, within bounds."""
    now = servo_state_of(servo_state)
    _tool_rates(q, now.v.copy(), now.w.copy(), now.mast_rate[()], settings, limits, rates)


@njit(cache=True)
def _tool_rates(
    q: Array, v: Array, w: Array, mast_rate: float, settings: Array, limits: Array, rates: Array
) -> float:
    """Write the joint rates (6,) of a tool velocity, scaled to the limits; return the scale."""
    s, most = settings_of(settings), limits_of(limits)
    bounds = Bounds(1 if s.mast_follows > 0.0 else 0, most.lower, most.upper)
    joint_rates_kernel(q, v, w, bounds, s.position_first > 0.0, mast_rate, rates)
    scale = 1.0
    for i in range(6):
        if abs(rates[i]) > most.rate[i]:
            scale = min(scale, most.rate[i] / abs(rates[i]))
    for i in range(6):
        rates[i] *= scale
    return scale


@njit(cache=True)
def hold(good: Array, servo_state: Array, state_desired: Array) -> None:
    """Put the limiter back to what it was in `good` (17,), at rest, and the references to rest."""
    servo_state[:] = good
    now = servo_state_of(servo_state)
    now.v[:] = 0.0
    now.w[:] = 0.0
    now.mast_rate[()] = 0.0
    now.status[()] = HOLDING
    state_of(state_desired).v[:] = 0.0


@njit(cache=True)
def servo_step(
    tool_command: Array, state_desired: Array, servo_state: Array, settings: Array, limits: Array
) -> None:
    """Advance the limiter and the references one period, in place.

    Args:
        tool_command: (8,).
        state_desired: references (12,).
        servo_state: (17,); the status tells what was done.
        settings: see `limiter.Settings`.
        limits: see `limiter.Limits`.
    """
    desired, now, s = state_of(state_desired), servo_state_of(servo_state), settings_of(settings)
    q, good, rates = scratch(6), scratch(17), scratch(6)
    q[:], good[:] = desired.q, servo_state
    cut = follow_command(tool_command, servo_state, settings, limits)
    resolve_rates(servo_state, q, settings, limits, rates)
    position_only = s.position_first > 0.0
    error = share_of_tolerance(servo_state, q, position_only)
    if error > OUTWARD_SHARE:
        ahead, there = good.copy(), desired.q.copy()
        back = leads_back(tool_command, good, settings, limits, ahead, there)
        if not back or error > 1.0:
            hold(good, servo_state, state_desired)
            if back:
                retreat(servo_state, state_desired, ahead, there, limits, s.period)
            return
    desired.q[:] = q
    desired.v[:] = rates
    now.status[()] = REACH_LIMITED if cut else TRACKING


@njit(cache=True)
def approach(q: Array, answer: Array, limits: Array, period: float, rates: Array) -> bool:
    """Move q (6,) towards an answer (6,) as far as the joints can in a period, in place.

    All joints arrive together. Writes the rates (6,) and returns True where it is too far.
    """
    most, slowest = limits_of(limits), 1.0
    for i in range(6):
        slowest = max(slowest, abs(answer[i] - q[i]) / (period * most.rate[i]))
    for i in range(6):
        step = (answer[i] - q[i]) / slowest
        if slowest > 1.0:
            rates[i] = step / period
        q[i] = q[i] + step if slowest > 1.0 else answer[i]
    return slowest > 1.0


def servo_state_at(q: Array) -> Array:
    """Return the state (17,) of a servo at rest at the tool pose of q (6,)."""
    pose = POSE.unpack(pose_vector(q))
    return SERVO_STATE.zeros(p=pose.p, quaternion=pose.quaternion, mast=q[0], status=TRACKING)
