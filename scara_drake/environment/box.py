"""A box: a finite block."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pydrake import geometry
from pydrake.math import RigidTransform, RollPitchYaw

from scara_drake.common import checks
from scara_drake.common.fields import number, vector
from scara_drake.environment.compliance import Compliance, check_name
from scara_drake.environment.place import corners_of, rounded_distance

Array = NDArray[np.float64]

box_distance = rounded_distance


@dataclass
class Box(Compliance):
    """A finite block, such as a table; its edges are rounded within the block.

    Attributes:
        name: of the box, a word.
        centre: in W.
        rpy: roll, pitch, yaw in W.
        size: sides x, y, z.
        edge_radius: at most half the shortest side.
    """

    name: str = "box"
    centre: list[float] = vector([0.8, -1.15, 3.0], "m", -100.0, 100.0)
    rpy: list[float] = vector([0.0, 0.0, 0.0], "rad", -7.0, 7.0)
    size: list[float] = vector([1.0, 0.2, 0.8], "m", 1e-3, 100.0)
    edge_radius: float = number(0.01, "m", 0.0)

    def check_together(self, name: str) -> None:
        """Check the name, the edges and the compliance.

        Raises:
            ValueError: the name is no word, or the edges rounder than the box is thick; see
                `Compliance`.
        """
        check_name(name, self.name)
        checks.number(f"{name}.edge_radius", self.edge_radius, 0.0, min(self.size) / 2)
        super().check_together(name)

    def pose(self) -> RigidTransform:
        """X_WS of the frame S at the centre, along the sides."""
        return RigidTransform(RollPitchYaw(np.array(self.rpy)), np.array(self.centre))

    def half_lengths(self) -> list[float]:
        """Return half the sides (3,) [m]."""
        return [side / 2 for side in self.size]

    def edge(self) -> float:
        """Return the radius of the edges [m]."""
        return self.edge_radius

    def shape(self) -> tuple[geometry.Shape, RigidTransform]:
        """The block, and its pose X_SG."""
        return geometry.Box(*self.size), RigidTransform()

    def corners(self) -> Array:
        """Corners (8, 3) in W [m]."""
        return corners_of(self.pose(), self.half_lengths())
