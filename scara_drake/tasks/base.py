"""What all training tasks share: the time they are given, and what may be touched.

A collision is contact where the task asks for none: the penetration of the tool in a surface that
`touchable` does not name, or any contact of another link. The tool's penetrations are recorded per
surface; a stretch of them above zero is one collision. The other links are Drake's: a run in which
one touches leaves the compiled engine, and is run in Drake.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scara_drake.common import checks
from scara_drake.common.fields import ABOVE_ZERO, number

Array = NDArray[np.float64]


@dataclass(kw_only=True)
class TaskBase:
    """Of every task.

    Attributes:
        most_time: after which the task counts as not done.
        most_force: on the tool; more is a mistake.
    """

    most_time: float = number(120.0, "s", 1.0, 86400.0)
    most_force: float = number(200.0, "N", ABOVE_ZERO, 1e5)

    def touchable(self) -> set[str]:
        """Return the names of the surfaces that the tool may touch."""
        return set()

    def places(self) -> Array:
        """Return the places (n, 3) [m] in W that the operator has to see."""
        return np.empty((0, 3))

    def check_scene(self, name: str, surfaces: Sequence[str], pipe: bool) -> None:
        """Check that a scenario has what the task is about.

        Args:
            name: of the task in the scenario.
            surfaces: names of the surfaces there.
            pipe: whether there is one to cut.

        Raises:
            ValueError: it does not.
        """
        for surface in sorted(self.touchable()):
            checks.choice(f"{name}.surface", surface, surfaces)


def check_path(name: str, points: list[list[float]], fewest: int) -> None:
    """Accept a path of some points, no two neighbours at the same place.

    Raises:
        ValueError: otherwise.
    """
    if not fewest <= len(points) <= 1000:
        raise ValueError(f"{name}: {len(points)} points, allowed {fewest} to 1000")
    steps = np.linalg.norm(np.diff(np.array(points), axis=0), axis=1)
    for index in np.flatnonzero(steps < 1e-4):
        raise ValueError(f"{name}[{index + 1}]: the place of the one before, allowed another")
