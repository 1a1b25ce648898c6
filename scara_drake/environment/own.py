"""Surfaces of kinds that no compiled kernel knows: their distance is asked of them, once a tick.

A law of contact needs of a surface its depth, its normal and its rate, and all of these are the
same for the wall that touches it where it is nearest. So each of these surfaces is, for a tick, the
wall of `tangent_row`, and the kernels go on as ever.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scara_drake.environment.compliance import Compliance
from scara_drake.environment.law import SURFACE, course_at
from scara_drake.environment.place import facing
from scara_drake.environment.surfaces import Environment, is_own
from scara_drake.kinematics import forward_kinematics

Array = NDArray[np.float64]


def tangent_row(surface: Compliance, row: Array, t: float, p_WE: Array) -> Array:
    """Return the row of the wall that is as far from a point as a surface, with the same normal.

    Args:
        surface: one that has a `distance`.
        row: of `surface_row`.
        t: for its motion [s].
        p_WE: the point (3,) [m].
    """
    s = SURFACE.unpack(row)
    offset, _ = course_at(s, t)
    p_at_rest, normal_S = p_WE - offset * s.direction, np.empty(3)
    distance = surface.distance(surface.pose().inverse() @ p_at_rest, normal_S)
    normal_W = s.R_WS @ normal_S
    on_plane = p_at_rest - distance * normal_W
    names = s._asdict() | {"p_WS": on_plane, "R_WS": facing(normal_W.tolist()).matrix()}
    return SURFACE.pack(**names)


@dataclass(frozen=True)
class OwnSurfaces:
    """The surfaces of an environment that are not in the table, by their index in it."""

    surfaces: dict[int, Compliance]

    @classmethod
    def of(cls, environment: Environment) -> OwnSurfaces:
        """Return those of an environment."""
        return cls({k: each for k, each in enumerate(environment.surfaces) if is_own(each)})

    def rows(self, t: float, state: Array, surfaces: Array) -> Array:
        """Return the rows (n, width) of all surfaces, for the tool of a robot state (12,)."""
        p_WE = forward_kinematics(state[:6])[:3, 3]
        rows = surfaces.copy()
        for k, surface in self.surfaces.items():
            rows[k] = tangent_row(surface, surfaces[k], t, p_WE)
        return rows
