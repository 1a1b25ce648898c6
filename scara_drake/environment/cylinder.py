"""A cylinder, such as a pipe."""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydrake import geometry
from pydrake.math import RigidTransform

from scara_drake.common import checks
from scara_drake.common.fields import number, vector
from scara_drake.environment.compliance import Compliance, check_name, check_unit
from scara_drake.environment.place import corners_of, facing, rounded_distance

Array = NDArray[np.float64]


@dataclass
class Cylinder(Compliance):
    """A closed cylinder, such as a pipe; its rims are rounded within it.

    Attributes:
        name: of the cylinder, a word.
        point: amid the axis, in W.
        direction: unit vector along the axis, in W.
        radius: of the cylinder.
        length: of the cylinder.
        edge_radius: of the rims; at most the radius, and half the length.
    """

    name: str = "pipe"
    point: list[float] = vector([0.8, -1.15, 3.0], "m", -100.0, 100.0)
    direction: list[float] = vector([1.0, 0.0, 0.0], "1", -1.0, 1.0)
    radius: float = number(0.1, "m", 1e-3, 100.0)
    length: float = number(1.5, "m", 1e-3, 100.0)
    edge_radius: float = number(0.01, "m", 0.0)

    def check_together(self, name: str) -> None:
        """Check the name, the direction, the rims and the compliance.

        Raises:
            ValueError: the name is no word, the direction no unit vector, or the rims rounder than
                the cylinder; see `Compliance`.
        """
        check_name(name, self.name)
        check_unit(f"{name}.direction", self.direction)
        roundest = min(self.radius, self.length / 2)
        checks.number(f"{name}.edge_radius", self.edge_radius, 0.0, roundest)
        super().check_together(name)

    def pose(self) -> RigidTransform:
        """X_WS of the frame S at `point`: z along the axis."""
        return RigidTransform(facing(self.direction), np.array(self.point))

    def half_lengths(self) -> list[float]:
        """Return the radius and half the length, and zero (3,) [m]."""
        return [self.radius, self.length / 2, 0.0]

    def edge(self) -> float:
        """Return the radius of the rims [m]."""
        return self.edge_radius

    def shape(self) -> tuple[geometry.Shape, RigidTransform]:
        """The cylinder, and its pose X_SG."""
        return geometry.Cylinder(self.radius, self.length), RigidTransform()

    def corners(self) -> Array:
        """Corners (8, 3) of the block around it, in W [m]."""
        return corners_of(self.pose(), [self.radius, self.radius, self.length / 2])


@njit(cache=True)
def cylinder_distance(p_S: Array, half: Array, edge: float, normal_S: Array) -> float:
    """Signed distance [m] of a point from a cylinder around z; see `surface_distance`.

    In the plane through the axis and the point it is a box.
    """
    across = np.hypot(p_S[0], p_S[1])
    distance = rounded_distance(np.array([across, p_S[2]]), half[:2], edge, normal_S[1:])
    outward = normal_S[1]
    normal_S[0] = outward * p_S[0] / across if across > 0.0 else outward
    normal_S[1] = outward * p_S[1] / across if across > 0.0 else 0.0
    return distance
