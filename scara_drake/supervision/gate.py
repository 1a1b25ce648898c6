"""How far a command may lead the arm: workspace, joint limits, singular postures.

Each is one-sided: what leads back is never held, also where the arm is outside already.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.scratch import scratch
from scara_drake.ik.kernels.limiter import limits_of, settings_of, turn
from scara_drake.ik.kernels.postures import Bounds as Joints
from scara_drake.ik.kernels.rates import joint_rates_kernel
from scara_drake.ik.result import ROTATION_LENGTH
from scara_drake.kinematics import (
    D3,
    rotation_from_quaternion_kernel,
    rotation_vector_kernel,
    tool_kinematics_kernel,
)
from scara_drake.safety import Reason
from scara_drake.supervision.layouts import bounds_of
from scara_drake.supervision.placing import following_way
from scara_drake.vectors import servo_state_of, tool_command_of

Array = NDArray[np.float64]

NONE, WORKSPACE = float(Reason.NONE), float(Reason.WORKSPACE)
JOINT_LIMIT, SINGULARITY = float(Reason.JOINT_LIMIT), float(Reason.SINGULARITY)
AHEAD = 0.02  # [s], of the motion of which it is asked whether the arm comes nearer to a limit


@njit(cache=True)
def reach_of(p: Array, centre: Array) -> float:
    """Return how far (3,) is from the circle of the end of the beam, and its nearest point (3,)."""
    radius = np.sqrt(p[0] * p[0] + p[1] * p[1])
    centre[0] = D3 * p[0] / radius if radius > 0.0 else D3
    centre[1] = D3 * p[1] / radius if radius > 0.0 else 0.0
    centre[2] = 0.0
    return np.sqrt((p[0] - centre[0]) ** 2 + (p[1] - centre[1]) ** 2 + p[2] ** 2)


@njit(cache=True)
def keep_in_workspace(command: Array, servo_state: Array, bounds: Array) -> bool:
    """Project a command (8,) into the box and the reach, in place; return whether it was outside.

    What is tangential of a motion along the edge stays. An arm that is outside already may stay.
    """
    b, asked, now = bounds_of(bounds), tool_command_of(command), servo_state_of(servo_state)
    outside = False
    for i in range(3):
        low, high = min(b.box_lower[i], now.p[i]), max(b.box_upper[i], now.p[i])
        inside = min(max(asked.p[i], low), high)
        outside = outside or inside != asked.p[i]
        asked.p[i] = inside
    if settings_of(b.motion).mast_follows == 0.0:
        return outside
    limits = limits_of(b.limits)
    height = min(max(asked.mast[()], limits.lower[0]), limits.upper[0])
    outside = outside or height != asked.mast[()]
    asked.mast[()] = height
    here, p, centre = scratch(3), scratch(3), scratch(3)
    here[:], p[:] = now.p, asked.p
    here[2] -= now.mast[()]
    p[2] -= height
    reach = max(b.reach, reach_of(here, centre))
    distance = reach_of(p, centre)
    if distance <= reach:
        return outside
    for i in range(3):
        asked.p[i] = centre[i] + reach / distance * (p[i] - centre[i])
    asked.p[2] += height
    return True


@njit(cache=True)
def smallest_singular_value(q: Array, motion: Array) -> float:
    """Return that of the controlled rows of the Jacobian at q (6,) [m/rad], by inverse iteration.

    Of the tool point by the joints that follow it; with the orientation, where that is held too, of
    as many directions as there are joints.
    """
    s = settings_of(motion)
    p, R, J, H = scratch(3), scratch(3, 3), scratch(6, 6), scratch(6, 6)
    tool_kinematics_kernel(q, p, R, J)
    first = 1 if s.mast_follows > 0.0 else 0
    for i in range(3):
        for j in range(6):
            J[i, j] *= 0.0 if s.position_first > 0.0 else ROTATION_LENGTH
    size = 3 if s.position_first > 0.0 else 6 - first
    for i in range(size):
        for j in range(size):
            H[i, j] = 0.0
            if s.position_first > 0.0:
                for k in range(first, 6):
                    H[i, j] += J[3 + i, k] * J[3 + j, k]
            else:
                for k in range(6):
                    H[i, j] += J[k, first + i] * J[k, first + j]
    return np.sqrt(max(smallest_eigenvalue(H, size), 0.0))


@njit(cache=True)
def smallest_eigenvalue(H: Array, size: int) -> float:
    """Return that of the symmetric matrix in the first rows of H (6, 6), which is overwritten.

    By Jacobi's rotations, which are exact for eigenvalues that lie together.
    """
    for _ in range(8):
        for i in range(size - 1):
            for j in range(i + 1, size):
                if H[i, j] == 0.0:
                    continue
                theta = 0.5 * (H[j, j] - H[i, i]) / H[i, j]
                t = 1.0 / (abs(theta) + np.sqrt(theta * theta + 1.0))
                t = t if theta >= 0.0 else -t
                c = 1.0 / np.sqrt(t * t + 1.0)
                s = t * c
                for k in range(size):
                    a, b = H[k, i], H[k, j]
                    H[k, i], H[k, j] = c * a - s * b, s * a + c * b
                for k in range(size):
                    a, b = H[i, k], H[j, k]
                    H[i, k], H[j, k] = c * a - s * b, s * a + c * b
    least = H[0, 0]
    for i in range(1, size):
        least = min(least, H[i, i])
    return float(least)


@njit(cache=True)
def share_of_speed(q: Array, rates: Array, bounds: Array) -> tuple[float, float]:
    """Return which share of joint rates (6,) is allowed at q (6,), and a `safety.Reason` why not.

    A joint may go so fast that its way in `horizon` ends at its margin. Towards a singular posture
    the share falls from 1 at `singularity_slow` to 0 at `singularity_stop`.
    """
    b, ahead = bounds_of(bounds), scratch(6)
    limits, share, reason = limits_of(b.limits), 1.0, NONE
    for i in range(6):
        way = b.horizon * abs(rates[i])
        room = limits.upper[i] - q[i] if rates[i] > 0.0 else q[i] - limits.lower[i]
        room -= b.joint_margin[i]
        if way > room and way > 1e-9:
            allowed = max(room, 0.0) / way
            if allowed < share:
                share, reason = allowed, JOINT_LIMIT
        ahead[i] = q[i] + AHEAD * rates[i]
    sigma = smallest_singular_value(q, b.motion)
    if sigma < b.singularity_slow and smallest_singular_value(ahead, b.motion) < sigma:
        span = b.singularity_slow - b.singularity_stop
        allowed = min(max((sigma - b.singularity_stop) / span, 0.0), 1.0)
        if allowed < share:
            share, reason = allowed, SINGULARITY
    return share, reason


@njit(cache=True)
def wanted_rates(
    command: Array, servo_state: Array, q: Array, bounds: Array, errors: Array, rates: Array
) -> None:
    """Write where a command (8,) leads from the limiter: errors (7,) and the joint rates (6,)."""
    b, asked, now = bounds_of(bounds), tool_command_of(command), servo_state_of(servo_state)
    s, limits = settings_of(b.motion), limits_of(b.limits)
    R_desired, R, w, v = scratch(3, 3), scratch(3, 3), scratch(3), scratch(3)
    rotation_from_quaternion_kernel(asked.quaternion, R_desired)
    rotation_from_quaternion_kernel(now.quaternion, R)
    angle = rotation_vector_kernel(R_desired, R, w)
    distance = 0.0
    for i in range(3):
        v[i] = asked.p[i] - now.p[i]
        distance += v[i] * v[i]
        errors[i], errors[3 + i] = v[i], w[i]
    errors[6] = asked.mast[()] - now.mast[()]
    distance, gain = np.sqrt(distance), 0.5 * s.bandwidth
    v *= min(gain, s.max_speed / distance) if distance > 0.0 else 0.0
    w *= min(gain, s.max_turn_rate / angle) if angle > 0.0 else 0.0
    climb = min(max(gain * errors[6], -s.mast_speed), s.mast_speed)
    joints = Joints(1 if s.mast_follows > 0.0 else 0, limits.lower.copy(), limits.upper.copy())
    joint_rates_kernel(q, v, w, joints, s.position_first > 0.0, climb, rates)
    most = 1.0
    for i in range(6):
        most = max(most, abs(rates[i]) / limits.rate[i])
    rates /= most


@njit(cache=True)
def shorten(command: Array, servo_state: Array, errors: Array, share: float, motion: Array) -> None:
    """Draw a command (8,) to where the limiter goes at a share of its speed, in place."""
    asked, now, s = tool_command_of(command), servo_state_of(servo_state), settings_of(motion)
    w = errors[3:6].copy()
    distance = np.sqrt(errors[0] ** 2 + errors[1] ** 2 + errors[2] ** 2)
    angle, height, gain = np.sqrt(np.sum(w * w)), abs(errors[6]), 0.5 * s.bandwidth
    speed = share * min(s.max_speed, gain * distance)
    part = following_way(speed, s.max_acceleration, s.bandwidth)
    part = min(1.0, part / distance) if distance > 0.0 else 0.0
    for i in range(3):
        asked.p[i] = now.p[i] + part * errors[i]
    rate = share * min(s.max_turn_rate, gain * angle)
    part = following_way(rate, s.max_turn_acceleration, s.bandwidth)
    asked.quaternion[:] = now.quaternion
    turn(asked.quaternion, w, min(1.0, part / angle) if angle > 0.0 else 0.0)
    climb = share * min(s.mast_speed, gain * height)
    part = following_way(climb, s.mast_acceleration, s.bandwidth)
    asked.mast[()] = now.mast[()] + (min(1.0, part / height) if height > 0.0 else 0.0) * errors[6]


@njit(cache=True)
def keep_within_limits(command: Array, servo_state: Array, q: Array, bounds: Array) -> float:
    """Bound a command (8,) in place, see above; return a `safety.Reason` why, or 0.

    Args:
        command: that is wanted.
        servo_state: (17,), where the limiter is.
        q: references (6,).
        bounds: see `layouts.Bounds`.
    """
    outside = keep_in_workspace(command, servo_state, bounds)
    errors, rates = scratch(7), scratch(6)
    wanted_rates(command, servo_state, q, bounds, errors, rates)
    share, reason = share_of_speed(q, rates, bounds)
    if share < 1.0:
        shorten(command, servo_state, errors, share, bounds_of(bounds).motion)
        return reason
    return WORKSPACE if outside else NONE
