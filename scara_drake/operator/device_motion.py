r"""How a kinesthetic device moves in a hand over a period, as a kernel: with Coulomb friction too.

Each axis is a mass with friction at a hand, see `master`,

.. math::

    m \dot v + b v + K x = c + r t - f_c\,\mathrm{sign}(v)

with b and K of device and hand together, and c + r t the force of the hand's target and of the
actuator. At rest the friction takes what is on it up to f_c. Without friction a period is one
product with the exponential of the system. With it, the instants at which the mass stops and breaks
away are found, and between them the motion is exact: so friction only takes energy, and nothing
chatters about rest.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.layout import Layout

Array = NDArray[np.float64]

TERMS = 18  # of the series of a step whose rates times its length are at most one half
HALVINGS = 60  # of an interval with an event in it: to the last digit
EVENTS = 64  # in a period, after which the device rests until its end
SWING = 3.0  # an acceleration changes its sign once at most in less than pi / omega


class MasterRow(NamedTuple):
    """A device and its hand in a kernel.

    Attributes:
        transition: Phi (2, 4), see `move_device`.
        stiffness: of the hand [N/m].
        damping: of the hand [N s/m].
        limit: of the actuators [N].
        period: [s].
        mass: of the device [kg].
        viscous: friction of device and hand [N s/m].
        friction: Coulomb's [N].
        workspace: where its ends are [m].
    """

    transition: Array
    stiffness: float
    damping: float
    limit: float
    period: float
    mass: float
    viscous: float
    friction: float
    workspace: float


DEVICE = Layout(MasterRow, transition=(2, 4))
device_of = DEVICE.reader()


class Axis(NamedTuple):
    """One axis that slides, in a kernel: m v' + b v + K x = c + r t.

    Attributes:
        m: [kg].
        b: [N s/m].
        K: [N/m].
        c: force at the start, that of the friction in it [N].
        r: its slope [N/s].
    """

    m: float
    b: float
    K: float
    c: float
    r: float


@njit(cache=True)
def slide(axis: Axis, x: float, v: float, h: float) -> tuple[float, float]:
    """Return position [m] and velocity [m/s] after h [s], by the series of the exact solution."""
    steps = 1 + int(2.0 * h * (axis.b / axis.m + math.sqrt(axis.K / axis.m)))
    dt = h / steps
    for step in range(steps):
        force, slope = axis.c + axis.r * step * dt, axis.r * dt
        term_x, term_v = x, v
        for order in range(1, TERMS):
            push = force - axis.K * term_x - axis.b * term_v
            term_x, term_v = term_v * dt / order, push * dt / (axis.m * order)
            force, slope = slope, 0.0
            x += term_x
            v += term_v
    return x, v


@njit(cache=True)
def acceleration(axis: Axis, x: float, v: float, t: float) -> float:
    """Return m v' [N] at a time t [s] after the start."""
    return axis.c + axis.r * t - axis.K * x - axis.b * v


@njit(cache=True)
def turning(axis: Axis, x: float, v: float, h: float) -> float:
    """Return when the acceleration changes its sign [s], which it does once within h [s]."""
    low, high = 0.0, h
    side = acceleration(axis, x, v, 0.0)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        x_there, v_there = slide(axis, x, v, middle)
        if acceleration(axis, x_there, v_there, middle) * side > 0.0:
            low = middle
        else:
            high = middle
    return high


@njit(cache=True)
def stopping(axis: Axis, x: float, v: float, side: float, h: float) -> float:
    """Return when a mass that slides to a side (1, -1) stops [s]; h [s] if not before.

    Within h its acceleration changes its sign once at most, so its speed has one extremum.
    """
    x_end, v_end = slide(axis, x, v, h)
    low, high = 0.0, h
    before = side * acceleration(axis, x, v, 0.0)
    if v == 0.0:
        before = max(before, 0.0)  # it breaks away: what is below zero is a rounding
    after = side * acceleration(axis, x_end, v_end, h)
    if side * v_end > 0.0:
        if not before < 0.0 < after:
            return h
        high = turning(axis, x, v, h)
        if side * slide(axis, x, v, high)[1] > 0.0:
            return h
    elif before >= 0.0 > after:
        low = turning(axis, x, v, h)  # of the speed that is largest there
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if side * slide(axis, x, v, middle)[1] > 0.0:
            low = middle
        else:
            high = middle
    return high


@njit(cache=True)
def stick_and_slip(d: MasterRow, x: float, v: float, c: float, r: float) -> tuple[float, float]:
    """Return position [m] and velocity [m/s] after a period, with friction.

    Args:
        d: the device.
        x: position [m].
        v: velocity [m/s]; zero is rest.
        c: force of the hand's target and the actuator at the start [N].
        r: its slope [N/s].
    """
    longest = SWING / math.sqrt(d.stiffness / d.mass) if d.stiffness > 0.0 else math.inf
    left = d.period
    for _ in range(EVENTS):
        if v != 0.0:
            side = math.copysign(1.0, v)
        else:
            push = c - d.stiffness * x
            side = math.copysign(1.0, push)
            if abs(push) <= d.friction:
                side = math.copysign(1.0, r)
                until = (side * d.friction - push) / r if r != 0.0 else math.inf
                if until >= left:
                    return x, v
                c += r * until
                left -= until
        axis = Axis(d.mass, d.viscous, d.stiffness, c - side * d.friction, r)
        h = min(left, longest)
        stop = stopping(axis, x, v, side, h)
        x, v = slide(axis, x, v, stop)
        if stop < h or not side * v > 0.0:
            v = 0.0
        c += r * stop
        left -= stop
        if left <= 0.0:
            break
    return x, v


@njit(cache=True)
def move_device(
    device: Array, f_master: Array, target_next: Array, motion: Array, target: Array, f_hand: Array
) -> None:
    """Move the device (6,) and its hand by one period, in place.

    Each axis is (x, v) <- Phi (x, v, c, r): c and r are the constant and the slope of the force
    that the hand's target and the actuator exert over the period. With friction see
    `stick_and_slip`. At the end of the workspace the device stops without a rebound.

    Args:
        device: of `Master.parameters`.
        f_master: commanded force on the hand's motion, positive resists positive motion (3,) [N].
        target_next: the hand's target at the end of the period (3,) [m].
        motion: x, v (6,).
        target: the hand's target at the start, moved to the end (3,) [m].
        f_hand: force of the hand at the end (3,) [N], written.
    """
    d = device_of(device)
    phi = d.transition
    positions, speeds = motion[:3], motion[3:]
    for i in range(3):
        speed = (target_next[i] - target[i]) / d.period
        force = min(max(f_master[i], -d.limit), d.limit)
        c = d.stiffness * target[i] + d.damping * speed - force
        r = d.stiffness * speed
        x, v = positions[i], speeds[i]
        if d.friction > 0.0:
            positions[i], speeds[i] = stick_and_slip(d, x, v, c, r)
        else:
            positions[i] = phi[0, 0] * x + phi[0, 1] * v + phi[0, 2] * c + phi[0, 3] * r
            speeds[i] = phi[1, 0] * x + phi[1, 1] * v + phi[1, 2] * c + phi[1, 3] * r
        if abs(positions[i]) > d.workspace:
            positions[i] = math.copysign(d.workspace, positions[i])
            speeds[i] = 0.0
        target[i] = target_next[i]
        f_hand[i] = d.stiffness * (target[i] - positions[i]) + d.damping * (speed - speeds[i])
