"""Reach through an opening to a place, and touch nothing."""

from dataclasses import dataclass

import numpy as np

from scara_drake.common.fields import number, vector
from scara_drake.tasks.base import Array, TaskBase


@dataclass
class ReachInto(TaskBase):
    """Bring the tool through an opening to a goal, stay there, and come out again.

    Nothing may be touched: every contact is a collision.

    Attributes:
        goal: where the tool point is to be, in W.
        tolerance: radius of the goal.
        stay: how long the tool is to be there without a break.
        opening: middle of the opening, in W.
        outward: unit vector through the opening, away from the goal; the tool is out again when it
            is beyond the plane of the opening.
        size: width and height of the opening.
    """

    goal: list[float] = vector([0.8, -1.2, 3.0], "m", -100.0, 100.0)
    tolerance: float = number(0.02, "m", 1e-4, 1.0)
    stay: float = number(1.0, "s", 0.0, 60.0)
    opening: list[float] = vector([0.8, -1.0, 3.0], "m", -100.0, 100.0)
    outward: list[float] = vector([0.0, 1.0, 0.0], "1", -1.0, 1.0)
    size: list[float] = vector([0.3, 0.3], "m", 1e-3, 100.0)

    def check_together(self, name: str) -> None:
        """Check the opening.

        Raises:
            ValueError: `outward` is no unit vector, or the goal is not behind the opening.
        """
        outward = np.array(self.outward)
        length = float(np.linalg.norm(outward))
        if abs(length - 1.0) > 1e-3:
            raise ValueError(f"{name}.outward: length {length:.4g}, allowed 1 (a unit vector)")
        if self.depth_of(np.array(self.goal)) <= 0.0:
            raise ValueError(f"{name}.goal: before the opening, allowed behind it")

    def depth_of(self, p_W: Array) -> Array:
        """Return how far places (..., 3) [m] are behind the plane of the opening [m]."""
        return np.asarray((np.array(self.opening) - p_W) @ np.array(self.outward))

    def places(self) -> Array:
        """The middle of the opening, and the goal."""
        return np.array([self.opening, self.goal])
