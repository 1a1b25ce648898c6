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

from scara_drake.common.motion import limit_motion
from scara_drake.ik.inverse_jacobian import joint_rates_kernel
from scara_drake.kinematics import (
    A4,
    D3,
    D6,
    rotation_from_quaternion_kernel,
    rotation_vector_kernel,
    tool_pose_kernel,
)

Array = NDArray[np.float64]

# Layout of the limiter's state: p_WE (3) [m], quaternion of R_WE (4), velocity (3) [m/s], angular
# velocity (3) [rad/s], mast height [m], mast rate [m/s].
POSE_SIZE = 7
MAST = 13
LIMITER_SIZE = 15

# Layout of the settings, see `InverseKinematics`.
SPEED, ACCELERATION, TURN_RATE, TURN_ACCELERATION, MAST_SPEED, MAST_ACCELERATION = range(6)
BANDWIDTH, POSITION_GAIN, ROTATION_GAIN, PERIOD = range(6, 10)
# Rows of the limits (3, 6): lower and upper joint limit, fastest joint rate.
LOWER, UPPER, RATE = range(3)

# Values of the status signal.
TRACKING = 0.0
HOLDING = 1.0  # the target cannot be reached: the last good answer is held
REACH_LIMITED = 2.0  # the target is drawn back into the reach of the arm

# The beam stays horizontal: the tool reaches every point within A4 + D6 of a circle of radius D3
# around the mast. It is kept this far from the edge, where the arm loses a direction of motion.
REACH_LIMIT = 0.98 * (A4 + D6)  # [m]
POSITION_TOLERANCE = 5e-3  # [m], E_Tp
ROTATION_TOLERANCE = 0.0175  # [rad], E_To


@njit(cache=True)
def _turn(quaternion: Array, w: Array, dt: float) -> None:
    """Turn a unit quaternion (w, x, y, z) by the rotation w dt expressed in W, in place."""
    angle = dt * np.sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2])
    c, s = np.cos(0.5 * angle), 0.5 * dt * np.sinc(0.5 * angle / np.pi)
    x, y, z = s * w[0], s * w[1], s * w[2]
    qw, qx, qy, qz = quaternion[0], quaternion[1], quaternion[2], quaternion[3]
    quaternion[0] = c * qw - x * qx - y * qy - z * qz
    quaternion[1] = c * qx + x * qw + y * qz - z * qy
    quaternion[2] = c * qy + y * qw + z * qx - x * qz
    quaternion[3] = c * qz + z * qw + x * qy - y * qx
    quaternion /= np.sqrt(np.sum(quaternion * quaternion))


@njit(cache=True)
def draw_into_reach(p: Array) -> bool:
    """Move a point (3,) relative to the arm's base back into its reach; return whether it was out.

    The point goes straight towards the nearest point of the circle that the end of the beam can
    be on, and stops at `REACH_LIMIT` from it.
    """
    radius = np.sqrt(p[0] * p[0] + p[1] * p[1])
    x = D3 * p[0] / radius if radius > 0.0 else D3
    y = D3 * p[1] / radius if radius > 0.0 else 0.0
    distance = np.sqrt((p[0] - x) ** 2 + (p[1] - y) ** 2 + p[2] ** 2)
    if distance <= REACH_LIMIT:
        return False
    share = REACH_LIMIT / distance
    p[0], p[1], p[2] = x + share * (p[0] - x), y + share * (p[1] - y), share * p[2]
    return True


@njit(cache=True)
def follow_command(
    command: Array,
    limiter: Array,
    mast_follows: bool,
    limits: Array,
    settings: Array,
) -> bool:
    """Advance the limiter (15,) one period towards a tool command (8,); return whether cut back.

    The command is p_WE [m], the quaternion of R_WE, and the mast height [m], which is followed
    only where `mast_follows`. A target beyond the arm's reach from its base is drawn back onto it.

    Args:
        command: target (8,).
        limiter: state, see the layout above; in place.
        mast_follows: whether the mast has a command of its own.
        limits: (3, 6), rows lower and upper joint limit and fastest rate.
        settings: (10,), see the layout above.
    """
    bandwidth, dt = settings[BANDWIDTH], settings[PERIOD]
    cut = False
    if mast_follows:
        target = min(max(command[7], limits[LOWER, 0]), limits[UPPER, 0])
        cut = target != command[7]
        error = np.empty(1)
        error[0] = target - limiter[13]
        speed, acceleration = settings[MAST_SPEED], settings[MAST_ACCELERATION]
        limit_motion(error, limiter[14:15], speed, acceleration, bandwidth, dt)
        limiter[13] += dt * limiter[14]
    error = command[:3].copy()
    if mast_follows:
        error[2] -= limiter[13]
        cut = draw_into_reach(error) or cut
        error[2] += limiter[13]
    for i in range(3):
        error[i] -= limiter[i]
    speed, acceleration = settings[SPEED], settings[ACCELERATION]
    limit_motion(error, limiter[7:10], speed, acceleration, bandwidth, dt)
    R_desired, R = np.empty((3, 3)), np.empty((3, 3))
    rotation_from_quaternion_kernel(command[3:7], R_desired)
    rotation_from_quaternion_kernel(limiter[3:7], R)
    rotation_vector_kernel(R_desired, R, error)
    speed, acceleration = settings[TURN_RATE], settings[TURN_ACCELERATION]
    limit_motion(error, limiter[10:13], speed, acceleration, bandwidth, dt)
    for i in range(3):
        limiter[i] += dt * limiter[7 + i]
    _turn(limiter[3:7], limiter[10:13], dt)
    return cut


@njit(cache=True)
def resolve_rates(
    limiter: Array,
    q: Array,
    mast_follows: bool,
    position_first: bool,
    limits: Array,
    settings: Array,
    rates: Array,
) -> None:
    """Write the joint rates (6,) that follow the limiter and advance q (6,) by them.

    With `position_first` the tool point is followed exactly and the orientation as near as the
    remaining joints allow. All rates are scaled together where one would be too fast, and the
    limiter is slowed by the same factor.

    Args:
        limiter: state (15,), already advanced by `follow_command`; in place.
        q: configuration (6,) of the last period; in place.
        mast_follows: whether the mast has a command of its own.
        position_first: whether orientation comes second.
        limits: (3, 6), rows lower and upper joint limit and fastest rate.
        settings: (10,), see the layout above.
        rates: result (6,).
    """
    p, R, R_desired = np.empty(3), np.empty((3, 3)), np.empty((3, 3))
    v, w = np.empty(3), np.empty(3)
    dt = settings[PERIOD]
    tool_pose_kernel(q, p, R)
    rotation_from_quaternion_kernel(limiter[3:7], R_desired)
    rotation_vector_kernel(R_desired, R, w)
    for i in range(3):
        # Feedback acts on the error before this period's own motion, which v carries.
        before = limiter[i] - dt * limiter[7 + i]
        v[i] = limiter[7 + i] + settings[POSITION_GAIN] * (before - p[i])
        w[i] = limiter[10 + i] + settings[ROTATION_GAIN] * (w[i] - dt * limiter[10 + i])
    scale = _tool_rates(q, v, w, mast_follows, position_first, limiter[14], limits, rates)
    if scale < 1.0:
        for i in range(3):
            limiter[i] -= (1.0 - scale) * dt * limiter[7 + i]
        limiter[13] -= (1.0 - scale) * dt * limiter[14]
        for i in range(7, 15):
            if i != 13:
                limiter[i] *= scale
    for i in range(6):
        # A joint that would pass its limit in this period stops there.
        step = min(max(q[i] + dt * rates[i], limits[LOWER, i]), limits[UPPER, i]) - q[i]
        rates[i] = step / dt
        q[i] += step


@njit(cache=True)
def reference_rates(
    limiter: Array,
    q: Array,
    mast_follows: bool,
    position_first: bool,
    limits: Array,
    rates: Array,
) -> None:
    """Write the joint rates (6,) of the limiter's motion at q, without feedback, within bounds."""
    v, w = limiter[7:10].copy(), limiter[10:13].copy()
    _tool_rates(q, v, w, mast_follows, position_first, limiter[14], limits, rates)


@njit(cache=True)
def _tool_rates(
    q: Array,
    v: Array,
    w: Array,
    mast_follows: bool,
    position_first: bool,
    mast_rate: float,
    limits: Array,
    rates: Array,
) -> float:
    """Write the joint rates (6,) of a tool velocity, scaled to the limits; return the scale."""
    first = 1 if mast_follows else 0
    lower, upper = limits[LOWER], limits[UPPER]
    joint_rates_kernel(q, v, w, first, position_first, mast_rate, lower, upper, rates)
    scale = 1.0
    for i in range(6):
        if abs(rates[i]) > limits[RATE, i]:
            scale = min(scale, limits[RATE, i] / abs(rates[i]))
    for i in range(6):
        rates[i] *= scale
    return scale


@njit(cache=True)
def rest(limiter: Array, desired: Array) -> None:
    """Set the rates of the limiter (15,) and of the references (12,) to zero, in place."""
    limiter[7:13] = 0.0
    limiter[14] = 0.0
    desired[6:] = 0.0


@njit(cache=True)
def servo_step(
    command: Array,
    limiter: Array,
    desired: Array,
    mast_follows: bool,
    position_first: bool,
    limits: Array,
    settings: Array,
) -> float:
    """Advance limiter (15,) and references (12,) one period, in place; return the status."""
    q = desired[:6].copy()
    good = limiter.copy()
    rates = np.empty(6)
    cut = follow_command(command, limiter, mast_follows, limits, settings)
    resolve_rates(limiter, q, mast_follows, position_first, limits, settings, rates)
    if not pose_reached(limiter, q, position_first):
        limiter[:] = good
        rest(limiter, desired)
        return HOLDING
    desired[:6] = q
    desired[6:] = rates
    return REACH_LIMITED if cut else TRACKING


@njit(cache=True)
def pose_reached(limiter: Array, q: Array, position_only: bool) -> bool:
    """Return whether the tool of q is within 5 mm, and 0.0175 rad where asked, of the limiter."""
    p, R, R_desired, w = np.empty(3), np.empty((3, 3)), np.empty((3, 3)), np.empty(3)
    tool_pose_kernel(q, p, R)
    distance = 0.0
    for i in range(3):
        distance += (limiter[i] - p[i]) ** 2
    if np.sqrt(distance) > POSITION_TOLERANCE:
        return False
    if position_only:
        return True
    rotation_from_quaternion_kernel(limiter[3:7], R_desired)
    return rotation_vector_kernel(R_desired, R, w) <= ROTATION_TOLERANCE
