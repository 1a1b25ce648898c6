"""Whether a link other than the tool may touch a surface: only Drake knows that contact.

Each shape of a link is enclosed by a segment with a radius. A distance changes by no more than one
moves, so along the segment the next point to look at is half as far away as the surface is from
this: no point between them is nearer than half of that either.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydrake.geometry import Box, Capsule, Cylinder, SceneGraph, Shape, Sphere
from pydrake.multibody.plant import MultibodyPlant

from scara_drake.common.layout import Layout
from scara_drake.dynamics.arm import moving_joints
from scara_drake.dynamics.equations import arm_of, work_of
from scara_drake.dynamics.spatial import Vector, plus, rotated, times, vector
from scara_drake.engine.errors import NotCompilableError
from scara_drake.environment.law import SURFACE, surface_of
from scara_drake.environment.surfaces import Environment, surface_distance, surface_row

Array = NDArray[np.float64]

STEP = 1e-3  # [m], the least from point to point of a segment
FASTEST = 5.0  # [m/s], no point of a link is while nobody looks
LOOK_AGAIN = 1000  # ticks, after which it is looked again in any case
# How far a point of a link may be from the axis of each joint, [m]; as the mast slides, 1.
LEVERS = np.array([1.0, 2.5, 2.5, 1.8, 1.0, 1.0])


class Segment(NamedTuple):
    """A shape of a link, in the frame of the link.

    Attributes:
        link: its number.
        start: of the segment (3,) [m].
        end: of the segment (3,) [m].
        radius: around it [m].
    """

    link: float
    start: Array
    end: Array
    radius: float


SEGMENT = Layout(Segment, start=3, end=3)
segment_of = SEGMENT.reader()


@njit(cache=True)
def clearance(surface: Array, p_W: Vector, p_S: Array, normal: Array) -> float:
    """Distance [m] of a point from the sharp shape of a surface, or less.

    The edges of a surface are rounded within that shape. The arrays (3,) are written over.
    """
    s = surface_of(surface)
    for i in range(3):
        p_S[i] = 0.0
        for j in range(3):
            p_S[i] += s.R_WS[j, i] * (p_W[j] - s.p_WS[j])
    return surface_distance(surface, p_S, normal) - s.edge


@njit(cache=True)
def speed_bound(state: Array) -> float:
    """Return a speed [m/s] that no point of a link exceeds, of the state (12,) of the arm."""
    total = 0.0
    for i in range(LEVERS.size):
        total += LEVERS[i] * abs(state[LEVERS.size + i])
    return total


@njit(cache=True)
def is_fast(surfaces: Array, state: Array) -> bool:
    """Whether the arm, in state (12,), is too fast not to be looked at, if anything is there."""
    return surfaces.shape[0] > 0 and not speed_bound(state) < FASTEST


@njit(cache=True)
def ticks_clear(segments: Array, surfaces: Array, arm: Array, work: Array, state: Array) -> int:
    """Return for how many ticks no link can touch a surface; 0 where one may already.

    It holds while the arm is not fast, see `is_fast`; where it is, for the next tick.

    Args:
        segments: rows (n, 8), see `Segment`.
        surfaces: rows (m, width) of those that stand still, see `surface_row`.
        arm: see `equations.Arm`.
        work: see `equations.Work`; the links stand where they were before the last step.
        state: of the arm after it (12,).
    """
    a, k = arm_of(arm), work_of(work)
    most = a.period * max(FASTEST, 2.0 * speed_bound(state))  # that a link moves in a tick
    least = LOOK_AGAIN * most
    p_S, normal = np.empty(3), np.empty(3)
    for row in range(segments.shape[0]):
        g = segment_of(segments[row])
        link = int(g.link)
        start, end = (g.start[0], g.start[1], g.start[2]), (g.end[0], g.end[1], g.end[2])
        along = plus(end, times(-1.0, start))
        length = math.sqrt(along[0] ** 2 + along[1] ** 2 + along[2] ** 2)
        for index in range(surfaces.shape[0]):
            reached = 0.0
            while reached <= length:
                share = reached / length if length > 0.0 else 0.0
                p_L = plus(start, times(share, along))
                p_W = plus(vector(k.p_WL, link, 0), rotated(k.R_WL, link, p_L))
                clear = clearance(surfaces[index], p_W, p_S, normal) - g.radius - STEP
                least = min(least, 0.5 * clear)
                if least < most:
                    return 0
                reached += max(0.5 * clear, STEP)
    return int(least / most)


def watched(
    plant: MultibodyPlant, scene_graph: SceneGraph, environment: Environment
) -> tuple[Array, Array]:
    """Return the rows of the links' shapes, and of the surfaces that they could touch.

    Raises:
        NotCompilableError: a shape is of a kind that the watch does not know.
    """
    links, surfaces = watched_links(plant, scene_graph), watched_surfaces(environment)
    return links, surfaces[: surfaces.shape[0] if links.shape[0] else 0]


def watched_surfaces(environment: Environment) -> Array:
    """Return the rows of what the links could touch: surfaces that stand still, and the pipe."""
    rows = [surface_row(surface) for surface in environment.surfaces if surface.motion is None]
    if environment.cut is not None:
        rows.append(surface_row(environment.cut.solid()))
    return np.array(rows, dtype=np.float64).reshape(-1, SURFACE.size)


def watched_links(plant: MultibodyPlant, scene_graph: SceneGraph) -> Array:
    """Return the rows of the shapes that Drake would let touch a surface.

    Raises:
        NotCompilableError: one is of a kind that the watch does not know.
    """
    inspector = scene_graph.model_inspector()
    fixed = plant.GetCollisionGeometriesForBody(plant.world_body())
    rows = []
    for link, joint in enumerate(moving_joints(plant)):
        body = joint.child_body()
        for shape in plant.GetCollisionGeometriesForBody(body):
            if any(not inspector.CollisionFiltered(shape, other) for other in fixed):
                half, radius = _enclosing(inspector.GetShape(shape), body.name())
                X_LG = inspector.GetPoseInFrame(shape)
                rows.append(
                    SEGMENT.pack(
                        link=link,
                        start=X_LG @ np.array([0.0, 0.0, -half]),
                        end=X_LG @ np.array([0.0, 0.0, half]),
                        radius=radius,
                    )
                )
    return np.array(rows, dtype=np.float64).reshape(-1, SEGMENT.size)


def _enclosing(shape: Shape, link: str) -> tuple[float, float]:
    """Return half the length and the radius [m] of a segment on z that encloses a shape."""
    if isinstance(shape, Sphere):
        return 0.0, shape.radius()
    if isinstance(shape, Capsule | Cylinder):
        return 0.5 * shape.length(), shape.radius()
    if isinstance(shape, Box):
        return 0.5 * shape.height(), 0.5 * math.hypot(shape.width(), shape.depth())
    raise NotCompilableError(f"{link}: shape {type(shape).__name__} is not watched")
