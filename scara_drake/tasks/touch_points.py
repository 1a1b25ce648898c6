"""Touch marked points, one after the other."""

from dataclasses import dataclass

import numpy as np

from scara_drake.common.fields import ABOVE_ZERO, number, rows
from scara_drake.tasks.base import Array, TaskBase, check_path


@dataclass
class TouchPoints(TaskBase):
    """Touch marked points of a surface in their order.

    A point is touched when the tool presses on the surface with `least_force`, no farther than
    `tolerance` from it. Between the points the tool need not touch anything, but may.

    Attributes:
        surface: on which the points are, by its name.
        points: in W, in the order in which they are to be touched.
        tolerance: radius of a mark.
        least_force: of a touch.
    """

    surface: str = "wall"
    points: list[list[float]] = rows([[0.7, -1.05, 3.0], [0.9, -1.05, 3.0]], "m", -100.0, 100.0)
    tolerance: float = number(0.02, "m", 1e-4, 1.0)
    least_force: float = number(5.0, "N", ABOVE_ZERO, 1e4)

    def check_together(self, name: str) -> None:
        """Check the points.

        Raises:
            ValueError: there is none, or two in a row are the same.
        """
        check_path(f"{name}.points", self.points, 1)

    def touchable(self) -> set[str]:
        """The surface with the points."""
        return {self.surface}

    def places(self) -> Array:
        """The points."""
        return np.array(self.points)
