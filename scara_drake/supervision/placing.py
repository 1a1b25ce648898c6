"""Where commands are: the point at which what moves can stop, and commands put beside others."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.scratch import scratch
from scara_drake.ik.kernels.limiter import settings_of, turn
from scara_drake.vectors import servo_state_of, tool_command_of

Array = NDArray[np.float64]


@njit(cache=True)
def stopping_way(speed: float, acceleration: float, bandwidth: float) -> float:
    """How far ahead [m] a target stops the limiter from a speed [m/s], as fast as it may.

    The limiter (`common.motion.limit_motion`) brakes with its whole acceleration a until the speed
    is a / b, then runs out as exp(-b t), without passing the target: v² / 2a + a / 2b², and v / b
    where the speed is below a / b from the beginning.
    """
    knee = acceleration / bandwidth
    if speed <= knee:
        return speed / bandwidth
    return (speed * speed + knee * knee) / (2.0 * acceleration)


@njit(cache=True)
def following_way(speed: float, acceleration: float, bandwidth: float) -> float:
    """How far ahead [m] a target lets the limiter keep a speed [m/s]."""
    return max(2.0 * speed / bandwidth, speed * speed / acceleration)


@njit(cache=True)
def place_at_stop(servo_state: Array, motion: Array, command: Array) -> None:
    """Write the command (8,) at which the limiter stops, as fast as it may; all parts together.

    Args:
        servo_state: (17,), one period old when the command acts.
        motion: see `limiter.Settings`.
        command: written.
    """
    now, s, stop = servo_state_of(servo_state), settings_of(motion), tool_command_of(command)
    speed = np.sqrt(np.sum(now.v * now.v))
    way = stopping_way(speed, s.max_acceleration, s.bandwidth) + s.period * speed
    for i in range(3):
        stop.p[i] = now.p[i] + (way / speed * now.v[i] if speed > 0.0 else 0.0)
    rate = np.sqrt(np.sum(now.w * now.w))
    angle = stopping_way(rate, s.max_turn_acceleration, s.bandwidth) + s.period * rate
    stop.quaternion[:] = now.quaternion
    if rate > 0.0:
        turn(stop.quaternion, now.w, angle / rate)
    climb = abs(now.mast_rate[()])
    height = stopping_way(climb, s.mast_acceleration, s.bandwidth) + s.period * climb
    stop.mast[()] = now.mast[()] + np.sign(now.mast_rate[()]) * height


@njit(cache=True)
def multiply(one: Array, other: Array, product: Array) -> None:
    """Write the product (4,) of two unit quaternions w, x, y, z; it may be one of them."""
    a, b, c, d = one[0], one[1], one[2], one[3]
    w, x, y, z = other[0], other[1], other[2], other[3]
    product[0] = a * w - b * x - c * y - d * z
    product[1] = a * x + b * w + c * z - d * y
    product[2] = a * y + c * w + d * x - b * z
    product[3] = a * z + d * w + b * y - c * x
    product /= np.sqrt(np.sum(product * product))


@njit(cache=True)
def offset_between(command: Array, held: Array, offset: Array) -> None:
    """Write the offset (8,) that puts a command (8,) where another is held."""
    first, there, o = tool_command_of(command), tool_command_of(held), tool_command_of(offset)
    inverse = scratch(4)
    inverse[0] = first.quaternion[0]
    for i in range(3):
        o.p[i] = there.p[i] - first.p[i]
        inverse[1 + i] = -first.quaternion[1 + i]
    multiply(there.quaternion, inverse, o.quaternion)
    o.mast[()] = there.mast[()] - first.mast[()]


@njit(cache=True)
def put_beside(command: Array, offset: Array, placed: Array) -> None:
    """Write a command (8,) shifted, turned and lifted by an offset (8,)."""
    asked, o, there = tool_command_of(command), tool_command_of(offset), tool_command_of(placed)
    for i in range(3):
        there.p[i] = asked.p[i] + o.p[i]
    multiply(o.quaternion, asked.quaternion, there.quaternion)
    there.mast[()] = asked.mast[()] + o.mast[()]
