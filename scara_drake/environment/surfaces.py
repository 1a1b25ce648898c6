"""The surfaces around the robot: the table of their kinds, and the environment made of them."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.choose import chooser
from scara_drake.environment.box import Box, box_distance
from scara_drake.environment.compliance import Compliance
from scara_drake.environment.cylinder import Cylinder, cylinder_distance
from scara_drake.environment.law import NUMBERS, SURFACE, surface_of
from scara_drake.environment.pipe import PipeCut
from scara_drake.environment.wall import Wall, wall_distance

Array = NDArray[np.float64]

# A kind is a dataclass in a file of its own, named in the union, and its distance in the table. One
# that is not in the table says it by its method, see `own`.
Surface = Wall | Box | Cylinder
DISTANCES: Final[dict[type, Callable[[Array, Array, float, Array], float]]] = {
    Wall: wall_distance,
    Box: box_distance,
    Cylinder: cylinder_distance,
}
KINDS: Final = list(DISTANCES)
WALL: Final = KINDS.index(Wall)
NOWHERE: Final = np.full(3, np.nan)
distance_by: Any = chooser(list(DISTANCES.values()))


@njit(cache=True)
def surface_distance(surface: Array, p_S: Array, normal_S: Array) -> float:
    """Signed distance [m] of a point (3,) from a surface, both in the surface frame S.

    Writes the unit gradient (3,), the normal out of the surface. Outside, and up to `edge` below a
    rounded edge, it is continuous; deeper it jumps where two faces, or all sides of a pipe, are
    equally near.

    Args:
        surface: of `surface_row`. A wall is the plane z = 0. A box has half its sides in `half`; a
            cylinder around z has its radius and half its length there. Their edges are rounded with
            the radius `edge`, within the sharp shape.
        p_S: where [m].
        normal_S: receives the gradient.
    """
    s = surface_of(surface)
    return distance_by(s.kind, p_S, s.half, s.edge, normal_S)


def is_own(surface: Compliance) -> bool:
    """Whether a surface is of a kind that is not in the table."""
    return type(surface) not in DISTANCES


def surface_row(surface: Compliance) -> Array:
    """Return a surface as `surface_of` reads it.

    One that is not in the table is a wall that `own` has yet to place: its force is NaN.
    """
    X_WS, own = surface.pose(), is_own(surface)
    return SURFACE.pack(
        kind=WALL if own else KINDS.index(type(surface)),
        law=NUMBERS[surface.law],
        p_WS=NOWHERE if own else X_WS.translation(),
        R_WS=X_WS.rotation().matrix(),
        half=surface.half_lengths(),
        edge=surface.edge(),
        stiffness=surface.stiffness,
        damping=surface.damping,
        blend=surface.blend,
        exponent=surface.exponent,
        alpha=surface.alpha,
        **surface.course(),
    )


@dataclass
class Environment:
    """What stands around the robot.

    Attributes:
        surfaces: of which the tool feels each; none is free space.
        cut: a pipe that the tool's blade cuts.
    """

    surfaces: list[Surface] = field(default_factory=list)
    cut: PipeCut | None = None

    def check_together(self, name: str) -> None:
        """Check that no two surfaces share a name, nor one with the pipe.

        Raises:
            ValueError: two do.
        """
        if self.cut is not None and self.cut.name in self.names():
            raise ValueError(
                f"{name}.cut.name: '{self.cut.name}', allowed a name that no surface has"
            )
        for index, surface in enumerate(self.surfaces):
            if surface.name in self.names()[:index]:
                raise ValueError(
                    f"{name}.surfaces[{index}].name: '{surface.name}', allowed a name not yet taken"
                )

    def names(self) -> list[str]:
        """Names of the surfaces, in the order of `penetration`."""
        return [surface.name for surface in self.surfaces]

    def parameters(self) -> Array:
        """Rows (n, width) of the surfaces, each as `surface_of` reads it."""
        found = [surface_row(surface) for surface in self.surfaces]
        return np.array(found, dtype=np.float64).reshape(-1, SURFACE.size)
