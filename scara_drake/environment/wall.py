"""A wall: a flat surface."""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydrake import geometry
from pydrake.math import RigidTransform

from scara_drake.common.fields import number, vector
from scara_drake.environment.compliance import Compliance, check_name, check_unit
from scara_drake.environment.place import corners_of, facing

Array = NDArray[np.float64]


@dataclass
class Wall(Compliance):
    """A flat surface. The tool feels the whole half-space behind the plane.

    So nothing slips past an edge; `size` and `thickness` are the block that is drawn and that stops
    the other links, and with the law "drake" the tool too.

    Attributes:
        name: of the wall, a word.
        point: on the surface, in W.
        normal: unit vector out of the wall, in W.
        size: width and height of the block.
        thickness: of the block.
    """

    name: str = "wall"
    point: list[float] = vector([0.8, -1.05, 3.0], "m", -100.0, 100.0)
    normal: list[float] = vector([0.0, 1.0, 0.0], "1", -1.0, 1.0)
    size: list[float] = vector([2.0, 1.6], "m", 0.1, 100.0)
    thickness: float = number(0.08, "m", 1e-3, 10.0)

    def check_together(self, name: str) -> None:
        """Check the name, the normal and the compliance.

        Raises:
            ValueError: the name is no word or the normal no unit vector; see `Compliance`.
        """
        check_name(name, self.name)
        check_unit(f"{name}.normal", self.normal)
        super().check_together(name)

    def pose(self) -> RigidTransform:
        """X_WS of the surface frame S at `point`: z out of the wall, x along its width, y up."""
        return RigidTransform(facing(self.normal), np.array(self.point))

    def shape(self) -> tuple[geometry.Shape, RigidTransform]:
        """The block, and its pose X_SG."""
        width, height = self.size
        block = geometry.Box(width, height, self.thickness)
        return block, RigidTransform(np.array([0.0, 0.0, -self.thickness / 2]))

    def corners(self) -> Array:
        """Corners (4, 3) of the surface in W [m]."""
        return corners_of(self.pose(), [self.size[0] / 2, self.size[1] / 2, 0.0])


@njit(cache=True)
def wall_distance(p_S: Array, half: Array, edge: float, normal_S: Array) -> float:
    """Signed distance [m] of a point from the plane z = 0; see `surface_distance`."""
    normal_S[0] = normal_S[1] = 0.0
    normal_S[2] = 1.0
    return p_S[2]
