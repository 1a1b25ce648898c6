"""The surfaces around the robot: walls, boxes such as a table, and pipes."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from pydrake import geometry
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix

from scara_drake.common import checks
from scara_drake.environment import law as rows
from scara_drake.environment.compliance import Compliance, check_unit

Array = NDArray[np.float64]


@dataclass
class Wall(Compliance):
    """A flat surface. The tool feels the whole half-space behind the plane.

    So nothing slips past an edge; `size` and `thickness` are the block that is drawn and that stops
    the other links, and with the law "drake" the tool too.
    """

    name: str = "wall"
    point: list[float] = field(default_factory=lambda: [0.8, -1.05, 3.0])  # on the surface, W [m]
    normal: list[float] = field(default_factory=lambda: [0.0, 1.0, 0.0])  # unit, out of the wall
    size: list[float] = field(default_factory=lambda: [2.0, 1.6])  # width, height [m]
    thickness: float = 0.08  # [m]

    def validate(self, name: str) -> None:
        """Check the wall; `name` is the field's path in the scenario.

        Raises:
            ValueError: a number out of its range, or a normal that is no unit vector.
        """
        _check_name(name, self.name)
        checks.vector(f"{name}.point", self.point, 3, -100.0, 100.0)
        check_unit(f"{name}.normal", self.normal)
        checks.vector(f"{name}.size", self.size, 2, 0.1, 100.0)
        checks.number(f"{name}.thickness", self.thickness, 1e-3, 10.0)
        self.check_compliance(name)

    def pose(self) -> RigidTransform:
        """X_WS of the surface frame S at `point`: z out of the wall, x along its width, y up."""
        return RigidTransform(_facing(self.normal), np.array(self.point))

    def parameters(self) -> Array:
        """Return the row (WIDTH,) of the kernel."""
        return self.row(rows.WALL, [], 0.0)

    def shape(self) -> tuple[geometry.Shape, RigidTransform]:
        """The block, and its pose X_SG."""
        block = geometry.Box(*self.size, self.thickness)
        return block, RigidTransform([0.0, 0.0, -self.thickness / 2])

    def corners(self) -> Array:
        """Corners (4, 3) of the surface in W [m]."""
        return _corners(self.pose(), [self.size[0] / 2, self.size[1] / 2, 0.0])


@dataclass
class Box(Compliance):
    """A finite block, such as a table; its edges are rounded within the block."""

    name: str = "box"
    centre: list[float] = field(default_factory=lambda: [0.8, -1.15, 3.0])  # W [m]
    rpy: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])  # roll, pitch, yaw [rad]
    size: list[float] = field(default_factory=lambda: [1.0, 0.2, 0.8])  # sides x, y, z [m]
    edge_radius: float = 0.01  # [m]

    def validate(self, name: str) -> None:
        """Check the box; `name` is the field's path in the scenario.

        Raises:
            ValueError: a number out of its range, or edges rounder than the box is thick.
        """
        _check_name(name, self.name)
        checks.vector(f"{name}.centre", self.centre, 3, -100.0, 100.0)
        checks.vector(f"{name}.rpy", self.rpy, 3, -7.0, 7.0)
        checks.vector(f"{name}.size", self.size, 3, 1e-3, 100.0)
        checks.number(f"{name}.edge_radius", self.edge_radius, 0.0, min(self.size) / 2)
        self.check_compliance(name)

    def pose(self) -> RigidTransform:
        """X_WS of the frame S at the centre, along the sides."""
        return RigidTransform(RollPitchYaw(self.rpy), np.array(self.centre))

    def parameters(self) -> Array:
        """Return the row (WIDTH,) of the kernel."""
        half = [side / 2 for side in self.size]
        return self.row(rows.BOX, half, self.edge_radius)

    def shape(self) -> tuple[geometry.Shape, RigidTransform]:
        """The block, and its pose X_SG."""
        return geometry.Box(*self.size), RigidTransform()

    def corners(self) -> Array:
        """Corners (8, 3) in W [m]."""
        return _corners(self.pose(), [side / 2 for side in self.size])


@dataclass
class Cylinder(Compliance):
    """A closed cylinder, such as a pipe; its rims are rounded within it."""

    name: str = "pipe"
    point: list[float] = field(default_factory=lambda: [0.8, -1.15, 3.0])  # amid the axis, W [m]
    direction: list[float] = field(default_factory=lambda: [1.0, 0.0, 0.0])  # unit, of the axis
    radius: float = 0.1  # [m]
    length: float = 1.5  # [m]
    edge_radius: float = 0.01  # [m]

    def validate(self, name: str) -> None:
        """Check the cylinder; `name` is the field's path in the scenario.

        Raises:
            ValueError: a number out of its range, a direction that is no unit vector, or rims
                rounder than the cylinder.
        """
        _check_name(name, self.name)
        checks.vector(f"{name}.point", self.point, 3, -100.0, 100.0)
        check_unit(f"{name}.direction", self.direction)
        checks.number(f"{name}.radius", self.radius, 1e-3, 100.0)
        checks.number(f"{name}.length", self.length, 1e-3, 100.0)
        roundest = min(self.radius, self.length / 2)
        checks.number(f"{name}.edge_radius", self.edge_radius, 0.0, roundest)
        self.check_compliance(name)

    def pose(self) -> RigidTransform:
        """X_WS of the frame S at `point`: z along the axis."""
        return RigidTransform(_facing(self.direction), np.array(self.point))

    def parameters(self) -> Array:
        """Return the row (WIDTH,) of the kernel."""
        size = [self.radius, self.length / 2]
        return self.row(rows.CYLINDER, size, self.edge_radius)

    def shape(self) -> tuple[geometry.Shape, RigidTransform]:
        """The cylinder, and its pose X_SG."""
        return geometry.Cylinder(self.radius, self.length), RigidTransform()

    def corners(self) -> Array:
        """Corners (8, 3) of the block around it, in W [m]."""
        return _corners(self.pose(), [self.radius, self.radius, self.length / 2])


Surface = Wall | Box | Cylinder


@dataclass
class Environment:
    """The surfaces around the robot; none by default, which is free space."""

    surfaces: list[Wall | Box | Cylinder] = field(default_factory=list)

    def validate(self, name: str) -> None:
        """Check each surface.

        Raises:
            ValueError: a surface is not valid, or two share a name.
        """
        for index, surface in enumerate(self.surfaces):
            surface.validate(f"{name}.surfaces[{index}]")
            if surface.name in self.names()[:index]:
                raise ValueError(
                    f"{name}.surfaces[{index}].name: '{surface.name}', allowed a name not yet taken"
                )

    def names(self) -> list[str]:
        """Names of the surfaces, in the order of `penetration`."""
        return [surface.name for surface in self.surfaces]

    def parameters(self) -> Array:
        """Rows (n, WIDTH) of the surfaces for the kernel, see `law`."""
        found = [surface.parameters() for surface in self.surfaces]
        return np.array(found, dtype=np.float64).reshape(-1, rows.WIDTH)


def _check_name(name: str, value: str) -> None:
    if not value or "/" in value:
        raise ValueError(f"{name}.name: '{value}', allowed a word without '/'")


def _facing(direction: list[float]) -> RotationMatrix:
    """R_WS with z along a direction, x level; y up, or along the world's y if z is upright."""
    z = np.array(direction) / np.linalg.norm(direction)
    x = np.cross([0.0, 1.0, 0.0] if abs(z[2]) > 0.99 else [0.0, 0.0, 1.0], z)
    x /= np.linalg.norm(x)
    return RotationMatrix(np.column_stack([x, np.cross(z, x), z]))


def _corners(X_WS: RigidTransform, half: list[float]) -> Array:
    signs = np.stack(np.meshgrid(*[(-h, h) if h > 0.0 else (0.0,) for h in half]), axis=-1)
    corners: Array = (X_WS @ signs.reshape(-1, 3).T).T
    return corners
