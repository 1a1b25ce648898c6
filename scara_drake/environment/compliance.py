"""How a surface yields, and how it moves: the part that all kinds of surface share."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from pydrake.math import RigidTransform

from scara_drake.common import checks
from scara_drake.environment import law as rows

Array = NDArray[np.float64]


@dataclass
class ConstantVelocity:
    """x_e(t) = v t, from where the surface is at t = 0."""

    velocity: list[float] = field(default_factory=lambda: [0.0, 0.01, 0.0])  # in W [m/s]

    def validate(self, name: str) -> None:
        """Check the velocity.

        Raises:
            ValueError: a component beyond 2 m/s.
        """
        checks.vector(f"{name}.velocity", self.velocity, 3, -2.0, 2.0)

    def parameters(self) -> list[float]:
        """Direction (3), speed, amplitude, omega, phase of x_e."""
        speed = float(np.linalg.norm(self.velocity))
        direction = np.array(self.velocity) / speed if speed > 0.0 else np.zeros(3)
        return [*direction.tolist(), speed, 0.0, 0.0, 0.0]


@dataclass
class SineMotion:
    """x_e(t) = A sin(2 pi f t + phase) along a direction."""

    direction: list[float] = field(default_factory=lambda: [0.0, 1.0, 0.0])  # unit, in W
    amplitude: float = 0.005  # A [m]
    frequency: float = 0.5  # f [Hz]
    phase: float = 0.0  # [rad]

    def validate(self, name: str) -> None:
        """Check the fields.

        Raises:
            ValueError: a number out of its range, or a direction that is no unit vector.
        """
        check_unit(f"{name}.direction", self.direction)
        checks.number(f"{name}.amplitude", self.amplitude, 0.0, 1.0)
        checks.number(f"{name}.frequency", self.frequency, 0.0, 20.0)
        checks.number(f"{name}.phase", self.phase, -10.0, 10.0)

    def parameters(self) -> list[float]:
        """Direction (3), speed, amplitude, omega, phase of x_e."""
        return [*self.direction, 0.0, self.amplitude, 2 * np.pi * self.frequency, self.phase]


@dataclass(kw_only=True)
class Compliance:
    """How a surface yields and moves; stiffness and damping default to Table 4 of the paper.

    Attributes:
        law: "impedance", equation (52); "hunt_crossley"; or "drake", the compliant point contact of
            the plant between the shape of the tool and that of the surface, with friction.
        stiffness: K [N/m]; [N/mⁿ] with an exponent n.
        damping: B of the impedance [N s/m].
        blend: depth over which the damping of the impedance grows to B [m].
        exponent: n of Hunt and Crossley.
        alpha: of Hunt and Crossley, also in Drake's contact [s/m]: a body that bounces with the
            speed v keeps 1 - alpha v of it, for small v.
        motion: of the surface; None is at rest.
    """

    law: str = "impedance"
    stiffness: float = 1e4
    damping: float = 100.0
    blend: float = 1e-3
    exponent: float = 1.0
    alpha: float = 0.5
    motion: ConstantVelocity | SineMotion | None = None

    def check_compliance(self, name: str) -> None:
        """Check these fields; `name` is the path of the surface in the scenario.

        Raises:
            ValueError: a number out of its range, or a motion that the law does not allow.
        """
        checks.choice(f"{name}.law", self.law, rows.LAWS)
        least = checks.ABOVE_ZERO if self.law == "drake" else 0.0
        checks.number(f"{name}.stiffness", self.stiffness, least, 1e6)
        checks.number(f"{name}.damping", self.damping, 0.0, 1e4)
        checks.number(f"{name}.blend", self.blend, 1e-6, 0.1)
        checks.number(f"{name}.exponent", self.exponent, 1.0, 1.5)
        checks.number(f"{name}.alpha", self.alpha, 0.0, 10.0)
        if self.motion is not None:
            if self.law == "drake":
                raise ValueError(f"{name}.motion: set, allowed none with the law 'drake'")
            self.motion.validate(f"{name}.motion")

    def pose(self) -> RigidTransform:
        """X_WS of the surface frame where the surface is without its motion."""
        raise NotImplementedError

    def pose_at(self, time: float) -> RigidTransform:
        """X_WS at a time [s]."""
        if self.motion is None:
            return self.pose()
        *direction, speed, amplitude, omega, phase = self.motion.parameters()
        offset = speed * time + amplitude * np.sin(omega * time + phase)
        return RigidTransform(offset * np.array(direction)) @ self.pose()

    def row(self, kind: int, size: list[float], edge: float) -> Array:
        """Return the packed row (WIDTH,) of a surface of a kind, for the kernel."""
        row, X_WS = np.zeros(rows.WIDTH), self.pose()
        row[rows.KIND], row[rows.LAW] = kind, rows.LAWS[self.law]
        row[rows.POSITION : rows.ROTATION] = X_WS.translation()
        row[rows.ROTATION : rows.SIZE] = X_WS.rotation().matrix().ravel()
        row[rows.SIZE : rows.SIZE + len(size)] = size
        row[rows.EDGE : rows.DIRECTION] = (
            *(edge, self.stiffness, self.damping, self.blend),
            *(self.exponent, self.alpha),
        )
        if self.motion is not None:
            row[rows.DIRECTION :] = self.motion.parameters()
        return row


def check_unit(name: str, vector: list[float]) -> None:
    """Accept a unit vector (3,), to 0.1 %.

    Raises:
        ValueError: otherwise.
    """
    checks.vector(name, vector, 3, -1.0, 1.0)
    length = float(np.linalg.norm(vector))
    if abs(length - 1.0) > 1e-3:
        raise ValueError(f"{name}: length {length:.4g}, allowed 1 (a unit vector)")
