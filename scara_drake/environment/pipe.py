"""A pipe that the tool can cut."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from pydrake.math import RigidTransform

from scara_drake.common import checks
from scara_drake.common.fields import number, vector
from scara_drake.environment.blade import Blade
from scara_drake.environment.compliance import check_name, check_unit
from scara_drake.environment.cut_layout import CUT
from scara_drake.environment.cylinder import Cylinder
from scara_drake.environment.place import corners_of, facing

Array = NDArray[np.float64]


@dataclass
class PipeCut:
    """A pipe that the tool's blade cuts, see `cut_law`.

    Attributes:
        name: of the pipe, a word.
        point: amid the axis, in W.
        direction: unit vector along the axis, in W.
        radius: outside; the default is a pipe DN 65 of EN 10255.
        wall: thickness.
        length: of the pipe.
        specific_energy: u, to cut a volume of its material. Steels need 2 to 9 J/mm³, stainless
            ones 2 to 5, aluminium 0.4 to 1 (Kalpakjian and Schmid, Manufacturing Engineering and
            Technology, table 21.2).
        cells_around: of the section, from angle to angle.
        cells_through: of the section, from the inside to the outside.
        blade: that cuts.
    """

    name: str = "pipe"
    point: list[float] = vector([0.8, -1.0, 3.0], "m", -100.0, 100.0)
    direction: list[float] = vector([0.0, 0.0, 1.0], "1", -1.0, 1.0)
    radius: float = number(0.03805, "m", 1e-3, 10.0)
    wall: float = number(0.0029, "m", 1e-4, 10.0)
    length: float = number(1.2, "m", 1e-2, 100.0)
    specific_energy: float = number(3e9, "J/m^3", 1e6, 1e12)
    cells_around: int = number(120, "", 8, 1000)
    cells_through: int = number(3, "", 1, 20)
    blade: Blade = field(default_factory=Blade)

    def check_together(self, name: str) -> None:
        """Check the name, the direction, the wall and that the blade can pass the pipe.

        Raises:
            ValueError: the name is no word, the direction no unit vector, the wall thicker than the
                radius, or the pipe too thick for the blade.
        """
        check_name(name, self.name)
        check_unit(f"{name}.direction", self.direction)
        checks.number(f"{name}.wall", self.wall, 0.0, self.radius)
        checks.number(f"{name}.radius", self.radius, 0.0, self.blade.radius)

    def pose(self) -> RigidTransform:
        """X_WS of the frame S at `point`: z along the axis."""
        return RigidTransform(facing(self.direction), np.array(self.point))

    def solid(self) -> Cylinder:
        """Return the whole of it as a surface, which stops the links."""
        return Cylinder(
            name=self.name,
            point=self.point,
            direction=self.direction,
            radius=self.radius,
            length=self.length,
            edge_radius=0.0,
        )

    def corners(self) -> Array:
        """Corners (8, 3) of the block around it, in W [m]."""
        return corners_of(self.pose(), [self.radius, self.radius, self.length / 2])

    def section(self) -> float:
        """Area of the wall [m²]: with the kerf it is the volume of a straight cut."""
        return float(np.pi * self.wall * (2.0 * self.radius - self.wall))

    def circle(self) -> Array:
        """Return cosine and sine of the angle of each cell (2 cells_around,)."""
        angles = 2.0 * np.pi * (np.arange(self.cells_around) + 0.5) / self.cells_around
        return np.column_stack([np.cos(angles), np.sin(angles)]).ravel()

    def parameters(self) -> Array:
        """Return pipe and blade as `cut_law.cut_of` reads them."""
        X_WS, blade = self.pose(), self.blade
        return CUT.pack(
            p_WS=X_WS.translation(),
            R_WS=X_WS.rotation().matrix(),
            inner=self.radius - self.wall,
            outer=self.radius,
            half_length=self.length / 2,
            energy=self.specific_energy,
            around=self.cells_around,
            through=self.cells_through,
            radius=blade.radius,
            kerf=blade.kerf,
            clearance=(blade.kerf - blade.body) / 2,
            speed=abs(blade.speed),
            turn=np.sign(blade.speed),
            stall_force=blade.stall_force(),
            stalled_below=blade.stalled_below,
            feed_ratio=blade.feed_ratio,
            stiffness=blade.stiffness,
            damping=blade.damping,
            side_stiffness=blade.side_stiffness,
            side_damping=blade.side_damping,
            friction=blade.friction,
            circle=self.circle(),
        )
