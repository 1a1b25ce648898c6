"""Where a scripted operator moves next, as kernels: by the leg's line, the force, and his skill."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.draws import normal
from scara_drake.common.scratch import scratch
from scara_drake.operator.skills import leg_of, person_of

Array = NDArray[np.float64]

NEAR: Final = 0.01  # [m], from here on a surface is approached in small moves
TOUCHED: Final = 0.5  # [N], what is felt as touch
BACK: Final = 1.5  # times the force that stops the advance: he backs off
ENOUGH: Final = 0.5  # of a leg's force: it is pressed on
TREMOR: Final = 9.0  # [Hz]
DRAWS: Final = 4  # random numbers of a move


@njit(cache=True)
def dot(a: Array, b: Array) -> float:
    """Inner product of two arrays (3,)."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True)
def unit_from(a: Array, b: Array, unit: Array) -> float:
    """Write the unit vector (3,) from a to b, zero where they are one; return their distance."""
    for i in range(3):
        unit[i] = b[i] - a[i]
    length = math.sqrt(dot(unit, unit))
    for i in range(3):
        unit[i] = unit[i] / length if length > 0.0 else 0.0
    return length


@njit(cache=True)
def leg_done(leg: Array, seen: Array, felt: Array) -> bool:
    """Whether a leg looks done: near enough beside the normal and, on a surface, pressed on it."""
    g = leg_of(leg)
    away = scratch(3)
    for i in range(3):
        away[i] = g.p[i] - seen[i]
    along = dot(away, g.normal)
    for i in range(3):
        away[i] -= along * g.normal[i]
    pressed = dot(g.normal, g.normal) == 0.0 or dot(felt, g.normal) >= ENOUGH * g.force
    return pressed and math.sqrt(dot(away, away)) <= g.tolerance


@njit(cache=True)
def next_move(
    leg: Array, person: Array, start: Array, seen: Array, felt: Array, move: Array
) -> None:
    """Write the move (3,) [m] that he means to make: along the leg's line, and by its force.

    Without a normal the advance shrinks with the force that is felt, and turns back above `BACK`
    times the leg's. On a surface the normal part of the move follows the force alone, and before
    the touch comes down in moves of `approach`.
    """
    g, s = leg_of(leg), person_of(person)
    line, aim = scratch(3), scratch(3)
    length = unit_from(start, g.p, line)
    gone = 0.0
    for i in range(3):
        gone += (seen[i] - start[i]) * line[i]
    ahead = min(g.stride * s.haste, max(length - gone, 0.0) + 1e-12)
    free = dot(g.normal, g.normal) == 0.0
    if free and g.force > 0.0:
        load = s.heed * math.sqrt(dot(felt, felt)) / g.force
        ahead = -g.stride if load > BACK else ahead * max(1.0 - load, 0.0)
    reached = min(gone + ahead, length)
    for i in range(3):
        aim[i] = start[i] + reached * line[i]
        move[i] = s.correction * (aim[i] - seen[i])
    if free:
        return
    pressed, height = dot(felt, g.normal), 0.0
    for i in range(3):
        height += (seen[i] - g.p[i]) * g.normal[i]
    if pressed > TOUCHED:
        down = max(min(s.force_gain * (g.force - pressed), s.approach), -s.approach)
    else:
        down = max(height - NEAR, s.approach)
    across = down + dot(move, g.normal)
    for i in range(3):
        move[i] -= across * g.normal[i]


@njit(cache=True)
def scatter(leg: Array, person: Array, seed: int, count: int, move: Array) -> None:
    """Add the spread of his aim to a move (3,) [m]; towards a surface he goes by the feel."""
    g, s = leg_of(leg), person_of(person)
    length = math.sqrt(dot(move, move))
    down = dot(move, g.normal)
    noise = scratch(3)
    for i in range(3):
        noise[i] = normal(seed, DRAWS * count + i) * (s.aim + s.spread * length)
    felt = dot(noise, g.normal)
    of_down = normal(seed, DRAWS * count + 3) * s.spread * down
    for i in range(3):
        move[i] += noise[i] + (of_down - felt) * g.normal[i]


@njit(cache=True)
def hold_stick(t: float, aim: Array, person: Array, joystick_axes: Array) -> None:
    """Write the axes (5,) that ask for a tool point (3,), with the tremor of the hand."""
    k = person_of(person)
    for i in range(3):
        shake = k.tremor * math.sin(2.0 * math.pi * TREMOR * t + 2.1 * i)
        axis = (aim[i] + shake - k.centre[i]) / max(k.scale, 1e-9)
        bent = math.copysign(abs(axis) * (1.0 - k.dead_zone) + k.dead_zone, axis)
        joystick_axes[i] = min(max(bent if axis != 0.0 else 0.0, -1.0), 1.0)
