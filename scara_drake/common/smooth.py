"""Motions with bounded speed, acceleration and jerk, which know no robot.

A velocity is followed, or a point is approached, tick by tick. The bounds hold for the length of
each vector, at every tick and whatever is wanted.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.layout import Layout
from scara_drake.common.scratch import scratch

Array = NDArray[np.float64]

# Shares of acceleration and jerk that an approach plans with: what is left lets the velocity, which
# lags behind what is wanted, follow the plan without passing the point.
PLANNED_ACCELERATION, PLANNED_JERK = 0.6, 0.2
HALVINGS = 6  # of the change of a tick, to keep the speed within its bound
WIDEST = 3  # entries of a vector


class Bounds(NamedTuple):
    """Of a motion, per second; of a turn with rad in place of m.

    Attributes:
        speed: [m/s].
        acceleration: [m/s^2].
        jerk: [m/s^3].
    """

    speed: float
    acceleration: float
    jerk: float


BOUNDS = Layout(Bounds)
bounds_of = BOUNDS.reader()


@njit(cache=True)
def length_of(vector: Array) -> float:
    """Length of a vector (n,)."""
    total = 0.0
    for i in range(vector.size):
        total += vector[i] * vector[i]
    return float(np.sqrt(total))


@njit(cache=True)
def ramp_sum(height: float) -> float:
    """What a ramp adds up to that starts at `height` and falls by 1 a tick until it is at 0."""
    steps = np.floor(height)
    return (steps + 1.0) * (height - 0.5 * steps) if height > 0.0 else 0.0


@njit(cache=True)
def ramp_height(total: float) -> float:
    """Height from which a ramp that falls by 1 a tick adds up to `total`: undoes `ramp_sum`."""
    steps = np.floor(0.5 * (np.sqrt(1.0 + 8.0 * total) - 1.0))
    return total / (steps + 1.0) + 0.5 * steps


@njit(cache=True)
def stays_slow(v: Array, change: Array, bounds: Array, dt: float) -> bool:
    """Whether a speed stays within its bound with an acceleration (n,) that then ramps down."""
    b = bounds_of(bounds)
    step, a = b.jerk * dt, length_of(change)
    ahead = dt + (dt * step * ramp_sum(a / step - 1.0) / a if a > 0.0 else 0.0)
    total = 0.0
    for i in range(v.size):
        total += (v[i] + ahead * change[i]) ** 2
    return bool(total <= b.speed * b.speed)


@njit(cache=True)
def change_velocity(wanted: Array, v: Array, a: Array, bounds: Array, dt: float) -> None:
    """Advance a velocity (n,) and its acceleration (n,) by a tick towards what is wanted, in place.

    Along a line it takes the least time and arrives without passing: the acceleration is the
    largest from which it can still ramp down before the velocity is there.

    Args:
        wanted: (n,), n up to 3, no longer than the bound of the speed.
        v: within that bound.
        a: within its bound, and such that it can ramp down before `v` leaves its own.
        bounds: see `Bounds`.
        dt: of the tick [s].
    """
    b, n = bounds_of(bounds), v.size
    step = b.jerk * dt  # of the acceleration, in a tick
    change, least = scratch(3), scratch(3)
    change, least = change[:n], least[:n]
    for i in range(n):
        change[i] = wanted[i] - v[i]
    missing = length_of(change)
    goal = min(step * ramp_height(missing / (dt * step)), b.acceleration)
    scale = goal / missing if missing > 0.0 else 0.0
    for i in range(n):
        change[i] = scale * change[i] - a[i]
    size, before = length_of(change), length_of(a)
    shrink = step / size if size > step else 1.0
    rest = max(before - step, 0.0) / before if before > 0.0 else 0.0
    for i in range(n):
        change[i] = a[i] + shrink * change[i]
        least[i] = rest * a[i]  # ramps down: never faster than foreseen
    for _ in range(HALVINGS):
        if stays_slow(v, change, bounds, dt):
            break
        for i in range(n):
            change[i] = 0.5 * (change[i] + least[i])
    if not stays_slow(v, change, bounds, dt):
        change[:] = least
    for i in range(n):
        a[i] = change[i]
        v[i] += dt * a[i]


@njit(cache=True)
def approach_speed(distance: float, bounds: Array, bandwidth: float) -> float:
    """Speed at which a point may be approached from a distance, such that it is not passed.

    The distance is the one in which a speed is shed with `PLANNED_JERK` and
    `PLANNED_ACCELERATION`: v sqrt(v / j), and v²/2a + v a/2j from v = a²/j on.
    """
    b = bounds_of(bounds)
    a, j = PLANNED_ACCELERATION * b.acceleration, PLANNED_JERK * b.jerk
    if distance <= a * a * a / (j * j):
        speed = np.cbrt(j * distance * distance)
    else:
        knee = a * a / (2.0 * j)
        speed = np.sqrt(knee * knee + 2.0 * a * distance) - knee
    return float(min(speed, bandwidth * distance, b.speed))


@njit(cache=True)
def approach_distance(speed: float, bounds: Array, bandwidth: float) -> float:
    """Distance at which a point is approached with a speed: undoes `approach_speed`."""
    b = bounds_of(bounds)
    a, j = PLANNED_ACCELERATION * b.acceleration, PLANNED_JERK * b.jerk
    if speed <= a * a / j:
        distance = speed * np.sqrt(speed / j)
    else:
        distance = speed * speed / (2.0 * a) + speed * a / (2.0 * j)
    return float(max(distance, speed / bandwidth))


@njit(cache=True)
def approach(error: Array, v: Array, a: Array, bounds: Array, bandwidth: float, dt: float) -> None:
    """Advance a velocity and its acceleration by a tick towards a point, in place.

    Args:
        error: (n,) from here to the point.
        v: (n,), see `change_velocity`.
        a: (n,), see `change_velocity`.
        bounds: see `Bounds`.
        bandwidth: of the last of the way [1/s].
        dt: of the tick [s].
    """
    wanted = scratch(3)
    wanted = wanted[: v.size]
    distance = length_of(error)
    scale = approach_speed(distance, bounds, bandwidth) / distance if distance > 0.0 else 0.0
    for i in range(v.size):
        wanted[i] = scale * error[i]
    change_velocity(wanted, v, a, bounds, dt)
