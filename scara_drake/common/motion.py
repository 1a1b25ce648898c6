"""Motions that know no robot: a follower with bounds, turns, minimum jerk."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]


@njit(cache=True)
def limit_motion(
    error: Array,
    rate: Array,
    max_speed: float,
    max_acceleration: float,
    bandwidth: float,
    dt: float,
) -> None:
    """Advance the rate (n,) of a critically damped follower of `error` (n,), in place.

    Free of its bounds it is e'' + 2 bandwidth e' + bandwidth² e = 0. The wanted speed is also held
    below sqrt(a |e|), so that the bounded acceleration can stop it at the target.
    """
    distance = 0.0
    for i in range(error.size):
        distance += error[i] * error[i]
    distance = np.sqrt(distance)
    gain = 0.5 * bandwidth
    speed = min(gain * distance, max_speed, np.sqrt(max_acceleration * distance))
    scale = speed / distance if distance > 0.0 else 0.0
    change = 0.0
    for i in range(error.size):
        step = 2.0 * bandwidth * dt * (scale * error[i] - rate[i])
        change += step * step
    change = np.sqrt(change)
    shrink = min(1.0, max_acceleration * dt / change) if change > 0.0 else 1.0
    for i in range(error.size):
        rate[i] += shrink * 2.0 * bandwidth * dt * (scale * error[i] - rate[i])


@njit(cache=True)
def turn(quaternion: Array, w: Array, dt: float) -> None:
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
def minimum_jerk(x: Array | float) -> Any:
    """Share of the way at the share x of the time, both 0 to 1: 10 x³ - 15 x⁴ + 6 x⁵.

    Between rests it has the least integral of the squared jerk (Flash and Hogan, 1985). For a
    number or for an array of any shape.
    """
    return x * x * x * (10.0 + x * (6.0 * x - 15.0))


@njit(cache=True)
def minimum_jerk_rate(x: Array | float) -> Any:
    """Slope of `minimum_jerk`: 30 x² (1 - x)²."""
    return 30.0 * x * x * (1.0 - x) * (1.0 - x)
