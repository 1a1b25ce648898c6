"""Follow a line on a surface at a set force."""

from dataclasses import dataclass

import numpy as np

from scara_drake.common.fields import ABOVE_ZERO, number, rows
from scara_drake.tasks.base import Array, TaskBase, check_path


@dataclass
class TraceLine(TaskBase):
    """Follow a line on a surface from its first point to its last, pressing with a set force.

    The path error is the tool's distance from the line along the surface: what the tool is below
    the surface is its force, and no error of the path.

    Attributes:
        surface: on which the line is, by its name.
        points: of the line, in W; straight between them.
        force: with which the tool is to press.
        force_tolerance: around it.
        tolerance: half the width of the line.
    """

    surface: str = "vessel"
    points: list[list[float]] = rows([[0.7, -1.05, 3.0], [0.9, -1.05, 3.0]], "m", -100.0, 100.0)
    force: float = number(20.0, "N", ABOVE_ZERO, 1e4)
    force_tolerance: float = number(10.0, "N", ABOVE_ZERO, 1e4)
    tolerance: float = number(0.01, "m", 1e-4, 1.0)

    def check_together(self, name: str) -> None:
        """Check the line.

        Raises:
            ValueError: it has fewer than two points, or two in a row are the same.
        """
        check_path(f"{name}.points", self.points, 2)

    def touchable(self) -> set[str]:
        """The surface with the line."""
        return {self.surface}

    def places(self) -> Array:
        """The points of the line."""
        return np.array(self.points)
