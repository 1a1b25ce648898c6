"""How the stick of a supervised operator moves a command: smooth, bounded, within reach."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.layout import Cell, Layout
from scara_drake.common.scratch import scratch
from scara_drake.common.smooth import (
    BOUNDS,
    approach,
    approach_distance,
    bounds_of,
    change_velocity,
    length_of,
)
from scara_drake.kinematics import draw_into_reach
from scara_drake.operator.mapping import (
    MAST_HIGH,
    MAST_LOW,
    JoystickMapping,
    remove_dead_zone,
)
from scara_drake.operator.stick_filter import operator_input_of
from scara_drake.vectors import joystick_axes_of, operator_buttons_of

Array = NDArray[np.float64]

FINEST = 5.0  # ticks in a time constant of the last of the way


class StickMapping(NamedTuple):
    """`JoystickMapping` in a kernel, see `common.smooth.Bounds`.

    Attributes:
        rate_mode: 1 or 0.
        scale: [m] at full stick.
        rate: [m/s] at full stick.
        dead_zone: of the stick's travel.
        bandwidth: of the last of the way [1/s].
        period: [s].
        tool: bounds (3,) of the point relative to the arm's base.
        turn: bounds (3,) of the tool's turn; its speed is that of a full turn.
        mast: bounds (3,) of the mast; its speed is that at full stick.
    """

    rate_mode: float
    scale: float
    rate: float
    dead_zone: float
    bandwidth: float
    period: float
    tool: Array
    turn: Array
    mast: Array


class Motion(NamedTuple):
    """Memory of the mapping.

    Attributes:
        v: velocity (3,) of the point relative to the arm's base [m/s].
        a: its acceleration (3,) [m/s^2].
        w: angular velocity (3,) of the tool [rad/s].
        w_dot: angular acceleration (3,) [rad/s^2].
        climb: rate (1,) of the mast [m/s].
        climb_dot: its acceleration (1,) [m/s^2].
        origin: (3,) where the stick was brought together with the tool, [m] from the arm's base.
        centre: (3,) of the stick there.
        target: (3,) where the point is to go, within reach [m].
        scale: of the live settings.
    """

    v: Array
    a: Array
    w: Array
    w_dot: Array
    climb: Array
    climb_dot: Array
    origin: Array
    centre: Array
    target: Array
    scale: Cell


STICK_MAPPING = Layout(StickMapping, tool=3, turn=3, mast=3)
MOTION = Layout(
    Motion,
    v=3,
    a=3,
    w=3,
    w_dot=3,
    climb=1,
    climb_dot=1,
    origin=3,
    centre=3,
    target=3,
    scale=(),
)
stick_mapping_of = STICK_MAPPING.reader()
motion_of = MOTION.reader()


def pack_mapping(mapping: JoystickMapping, period: float) -> Array:
    """Return a mapping over a period [s] as `stick_mapping_of` reads it."""
    build_up = mapping.max_acceleration / mapping.max_jerk

    def bounds(speed: float, acceleration: float) -> Array:
        return BOUNDS.pack(speed=speed, acceleration=acceleration, jerk=acceleration / build_up)

    return STICK_MAPPING.pack(
        rate_mode=mapping.mode == "rate",
        scale=mapping.scale,
        rate=mapping.rate,
        dead_zone=mapping.dead_zone,
        bandwidth=1.0 / max(mapping.smoothing, FINEST * period),
        period=period,
        tool=bounds(mapping.max_speed, mapping.max_acceleration),
        turn=bounds(mapping.turn_rate, mapping.turn_acceleration),
        mast=bounds(mapping.mast_rate, mapping.mast_acceleration),
    )


@njit(cache=True)
def bring_together(stick: Array, p: Array, mapping: Array, motion: Array) -> None:
    """Let the stick (3,) stand for the place where the point (3,) comes to rest, in place."""
    g, m = stick_mapping_of(mapping), motion_of(motion)
    b, speed = bounds_of(g.tool), length_of(m.v)
    # From a speed v to rest: v/2 (v/a + a/j), or v sqrt(v/j) where a is not reached.
    if speed > b.acceleration * b.acceleration / b.jerk:
        time = 0.5 * (speed / b.acceleration + b.acceleration / b.jerk)
    else:
        time = np.sqrt(speed / b.jerk)
    for i in range(3):
        m.centre[i] = stick[i]
        m.origin[i] = p[i] + time * m.v[i]
        m.target[i] = m.origin[i]


@njit(cache=True)
def lead(wanted: Array, bounds: Array, bandwidth: float, way: Array) -> None:
    """Write the way (n,) to a point that is approached with a wanted velocity (n,)."""
    asked = length_of(wanted)
    speed = min(asked, bounds_of(bounds).speed)
    scale = approach_distance(speed, bounds, bandwidth) / asked if asked > 0.0 else 0.0
    for i in range(way.size):
        way[i] = scale * wanted[i]


@njit(cache=True)
def aim(stick: Array, p: Array, mapping: Array, motion: Array) -> None:
    """Write the target of the point (3,), within the arm's reach, in place."""
    g, m = stick_mapping_of(mapping), motion_of(motion)
    if g.rate_mode > 0.0:
        wanted, way = scratch(3), scratch(3)
        for i in range(3):
            wanted[i] = m.scale[()] * g.rate * stick[i]
        lead(wanted, g.tool, g.bandwidth, way)
        for i in range(3):
            m.target[i] = p[i] + way[i]
    else:
        for i in range(3):
            way_of_stick = m.scale[()] * g.scale * (stick[i] - m.centre[i])
            m.target[i] = m.origin[i] + way_of_stick
    draw_into_reach(m.target)


@njit(cache=True)
def climb(command: float, height: float, mapping: Array, motion: Array) -> None:
    """Advance the rate of the mast towards what its axis commands, -1 to 1, in place."""
    g, m = stick_mapping_of(mapping), motion_of(motion)
    wanted, way = scratch(1), scratch(1)
    wanted[0] = bounds_of(g.mast).speed * min(max(command, -1.0), 1.0)
    lead(wanted, g.mast, g.bandwidth, way)
    way[0] = min(max(height + way[0], MAST_LOW), MAST_HIGH) - height
    approach(way, m.climb, m.climb_dot, g.mast, g.bandwidth, g.period)


@njit(cache=True)
def brake(mapping: Array, motion: Array) -> None:
    """Advance all rates by a tick towards rest, in place."""
    g, m = stick_mapping_of(mapping), motion_of(motion)
    rest = scratch(3)
    rest[:] = 0.0
    change_velocity(rest, m.v, m.a, g.tool, g.period)
    change_velocity(rest, m.w, m.w_dot, g.turn, g.period)
    change_velocity(rest[:1], m.climb, m.climb_dot, g.mast, g.period)


@njit(cache=True)
def follow_stick(
    operator_input: Array,
    meets: bool,
    scale: float,
    p: Array,
    height: float,
    mapping: Array,
    motion: Array,
) -> None:
    """Advance all rates by a tick as the operator commands, in place.

    Args:
        operator_input: (16,).
        meets: stick and tool are brought together here.
        scale: of the live settings.
        p: (3,) the point relative to the arm's base [m].
        height: of the mast [m].
        mapping: see `StickMapping`.
        motion: see `Motion`.
    """
    seen, g, m = operator_input_of(operator_input), stick_mapping_of(mapping), motion_of(motion)
    axes, lifts = joystick_axes_of(seen.axes), operator_buttons_of(seen.buttons).mast > 0.0
    stick, error, wanted = scratch(3), scratch(3), scratch(3)
    for i in range(3):
        stick[i] = remove_dead_zone(seen.axes[i], g.dead_zone)
    mast = remove_dead_zone(axes.mast_axis, g.dead_zone) + axes.mast_hat
    if lifts:
        mast += stick[2]
    if meets:
        bring_together(stick, p, mapping, motion)
    elif scale != m.scale[()]:
        for i in range(3):
            m.origin[i], m.centre[i] = m.target[i], stick[i]
    m.scale[()] = scale
    if lifts and g.rate_mode > 0.0:
        stick[2] = 0.0
    elif lifts:  # the height of the tool stays where it was
        m.origin[2], m.centre[2] = m.target[2], stick[2]
    aim(stick, p, mapping, motion)
    for i in range(3):
        error[i] = m.target[i] - p[i]
        wanted[i] = bounds_of(g.turn).speed * seen.orientation[i]
    approach(error, m.v, m.a, g.tool, g.bandwidth, g.period)
    size = length_of(wanted)
    if size > bounds_of(g.turn).speed:
        for i in range(3):
            wanted[i] *= bounds_of(g.turn).speed / size
    change_velocity(wanted, m.w, m.w_dot, g.turn, g.period)
    climb(mast, height, mapping, motion)
