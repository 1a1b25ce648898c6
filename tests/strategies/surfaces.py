"""Surfaces within the reach of the arm."""

import numpy as np
from hypothesis import strategies as st

from scara_drake.environment.box import Box
from scara_drake.environment.cylinder import Cylinder
from scara_drake.environment.surfaces import Surface
from scara_drake.environment.wall import Wall

units = st.floats(0.0, 1.0)
signs = st.floats(-1.0, 1.0)


def direction(x: float, y: float, z: float) -> list[float]:
    """A unit vector."""
    v = np.array([x, y, z]) + 1e-3
    return list(v / np.linalg.norm(v))


@st.composite
def surfaces(draw: st.DrawFn) -> Surface:
    """A surface within the arm's reach, at a mast of 3 m."""
    place = [2.0 * draw(signs), 2.0 * draw(signs), 3.0 + 2.0 * draw(signs)]
    axis = direction(*(draw(signs) for _ in range(3)))
    kind = draw(st.sampled_from(["wall", "box", "cylinder"]))
    if kind == "wall":
        return Wall(point=place, normal=axis, thickness=0.02 + draw(units))
    if kind == "box":
        size = [0.05 + draw(units) for _ in range(3)]
        edge = 0.5 * draw(units) * min(size)
        turn = [3.0 * draw(signs) for _ in range(3)]
        return Box(centre=place, rpy=turn, size=size, edge_radius=edge)
    radius, length = 0.02 + draw(units), 0.05 + 2.0 * draw(units)
    edge = draw(units) * min(radius, 0.5 * length)
    return Cylinder(point=place, direction=axis, radius=radius, length=length, edge_radius=edge)
