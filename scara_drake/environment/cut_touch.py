"""What a blade and a cell of a pipe's section do to each other, as kernels; see `cut_law`."""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.scratch import scratch
from scara_drake.dynamics.spatial import Vector, cross, dot, plus, times
from scara_drake.environment.cut_layout import Cut
from scara_drake.kinematics import tool_kinematics_kernel

Array = NDArray[np.float64]


class Disc(NamedTuple):
    """Where the blade is, in the pipe's frame S, and how it moves.

    Attributes:
        tip: the tool point [m].
        centre: of the disc [m].
        axis: of the disc.
        velocity: of the tool point [m/s].
        rate: of the tool [rad/s].
        place: of the kerf, along the pipe's axis [m].
    """

    tip: Vector
    centre: Vector
    axis: Vector
    velocity: Vector
    rate: Vector
    place: float


class Touch(NamedTuple):
    """What a cell and the blade have to do with each other.

    Attributes:
        area: of the cell [m²].
        overlap: A [m²].
        lever: from the tool point to the cell [m].
        outward: of the rim, at the cell.
        along: as the teeth run there.
        slide: speed of the tool along the teeth's [m/s].
        normal: N [N].
        wedge: of the side's spring, along the rim's normal [N].
        side: S along the blade's axis [N].
        across: where the cell is across the blade [m].
        bend: e, beyond the clearance [m].
        arm: distance from the blade's axis, over its radius.
    """

    area: float
    overlap: float
    lever: Vector
    outward: Vector
    along: Vector
    slide: float
    normal: float
    wedge: float
    side: float
    across: float
    bend: float
    arm: float


CRUMB = 1e-6  # share of a cell that holds nothing
NOTHING = (0.0, 0.0, 0.0)
APART = Touch(0.0, 0.0, NOTHING, NOTHING, NOTHING, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@njit(cache=True)
def disc_at(state: Array, c: Cut, J: Array) -> Disc:
    """Return where the blade of a robot state (12,) is; write the Jacobian (6, 6) of its tip."""
    p, R = scratch(3), scratch(3, 3)
    tool_kinematics_kernel(state[:6], p, R, J)
    tip = in_pipe(c, (p[0] - c.p_WS[0], p[1] - c.p_WS[1], p[2] - c.p_WS[2]))
    ahead = in_pipe(c, (R[0, 2], R[1, 2], R[2, 2]))
    axis = in_pipe(c, (R[0, 1], R[1, 1], R[2, 1]))
    w = scratch(6)
    for i in range(6):
        w[i] = 0.0
        for j in range(6):
            w[i] += J[i, j] * state[6 + j]
    rate, velocity = in_pipe(c, (w[0], w[1], w[2])), in_pipe(c, (w[3], w[4], w[5]))
    return Disc(tip, plus(tip, times(-c.radius, ahead)), axis, velocity, rate, 0.0)


@njit(cache=True)
def in_pipe(c: Cut, a: Vector) -> Vector:
    """A vector of W in the pipe's frame S."""
    R = c.R_WS
    return (
        R[0, 0] * a[0] + R[1, 0] * a[1] + R[2, 0] * a[2],
        R[0, 1] * a[0] + R[1, 1] * a[1] + R[2, 1] * a[2],
        R[0, 2] * a[0] + R[1, 2] * a[1] + R[2, 2] * a[2],
    )


@njit(cache=True)
def in_world(c: Cut, a: Vector) -> Vector:
    """A vector of the pipe's frame S in W."""
    R = c.R_WS
    return (
        R[0, 0] * a[0] + R[0, 1] * a[1] + R[0, 2] * a[2],
        R[1, 0] * a[0] + R[1, 1] * a[1] + R[1, 2] * a[2],
        R[2, 0] * a[0] + R[2, 1] * a[1] + R[2, 2] * a[2],
    )


@njit(cache=True)
def ring(c: Cut, number: int) -> float:
    """Radius amid a ring of cells [m]."""
    return c.inner + (number + 0.5) * (c.outer - c.inner) / c.through


@njit(cache=True, inline="always")
def meets(c: Cut, disc: Disc, r: float, angle: int, left: float, kerf: float) -> int:
    """Return 0 where a cell is far from the blade, 2 where they touch, or may; see `touch`.

    And 1 where the cell is cut and the blade has its clearance in it.
    """
    x, y = r * c.circle[2 * angle] - disc.centre[0], r * c.circle[2 * angle + 1] - disc.centre[1]
    z, margin = disc.place - disc.centre[2], c.outer - c.inner + 7.0 * c.outer / c.around
    across = x * disc.axis[0] + y * disc.axis[1] + z * disc.axis[2]
    if x * x + y * y + z * z - across * across > (c.radius + margin) ** 2:
        return 0
    return 1 if left <= CRUMB and abs(across - kerf) <= c.clearance else 2


@njit(cache=True)
def touch(c: Cut, disc: Disc, r: float, angle: int, left: float, kerf: float) -> Touch:
    """Return what a cell of the section and the blade have to do with each other.

    Args:
        c: pipe and blade.
        disc: the blade.
        r: radius of its ring [m].
        angle: its number in the ring.
        left: its share that is left.
        kerf: where it was across the blade at its removal [m].
    """
    deep, wide = (c.outer - c.inner) / c.through, 2.0 * math.pi / c.around
    out = (c.circle[2 * angle], c.circle[2 * angle + 1], 0.0)
    place = (r * out[0], r * out[1], disc.place)
    from_centre = plus(place, times(-1.0, disc.centre))
    across = dot(from_centre, disc.axis)
    in_plane = plus(from_centre, times(-across, disc.axis))
    far = max(math.sqrt(dot(in_plane, in_plane)), 1e-9)
    outward = times(1.0 / far, in_plane)
    cosine = min(abs(dot(outward, out)), 1.0)
    length = cosine * deep + math.sqrt(1.0 - cosine * cosine) * r * wide
    covered = min(max(0.5 + (c.radius - far) / length, 0.0), 1.0)
    if covered == 0.0:
        return APART
    area = r * wide * deep
    left = left if left > CRUMB else 0.0
    overlap = area * max(covered + left - 1.0, 0.0)
    lever = plus(place, times(-1.0, disc.tip))
    velocity = plus(disc.velocity, cross(disc.rate, lever))
    along = times(c.turn, cross(disc.axis, outward))
    approach = max(1.0 + c.damping * dot(velocity, outward), 0.0)
    wedge, side, bend = beside(c, across - kerf, -dot(velocity, disc.axis))
    share = min(covered, 1.0 - left) * area / section(c)
    edge = area / (section(c) * length) if covered < min(1.0 - left, 1.0) else 0.0
    return Touch(
        area,
        overlap,
        lever,
        outward,
        along,
        dot(velocity, along),
        c.stiffness * overlap * approach,
        edge * wedge,
        share * side,
        across,
        bend if share > 0.0 else 0.0,
        far / c.radius,
    )


@njit(cache=True)
def section(c: Cut) -> float:
    """Area of the pipe's wall [m²]."""
    return math.pi * (c.outer**2 - c.inner**2)


@njit(cache=True)
def beside(c: Cut, across: float, rate: float) -> tuple[float, float, float]:
    """Return K_s e² / 2 [J], S [N] and e [m] of a whole section that is `across` the blade."""
    bend = max(abs(across) - c.clearance, 0.0)
    if bend == 0.0:
        return 0.0, 0.0, 0.0
    sign = 1.0 if across > 0.0 else -1.0
    force = max(c.side_stiffness * bend + c.side_damping * sign * rate, 0.0)
    return 0.5 * c.side_stiffness * bend * bend, sign * force, bend
