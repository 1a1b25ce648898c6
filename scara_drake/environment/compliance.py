"""How a surface yields, and how it moves: the part that all kinds of surface share."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydrake import geometry
from pydrake.math import RigidTransform

from scara_drake.common import checks
from scara_drake.common.fields import ABOVE_ZERO, choice, number, vector
from scara_drake.environment.law import LAWS

Array = NDArray[np.float64]
# Of x_e(t) = direction (speed t + amplitude sin(omega t + phase)), by the names of `SurfaceRow`.
Course = dict[str, ArrayLike]

AT_REST: Course = {
    "direction": [0.0, 0.0, 0.0],
    "speed": 0.0,
    "amplitude": 0.0,
    "omega": 0.0,
    "phase": 0.0,
}


@dataclass
class ConstantVelocity:
    """x_e(t) = v t, from where the surface is at t = 0.

    Attributes:
        velocity: v in W.
    """

    velocity: list[float] = vector([0.0, 0.01, 0.0], "m/s", -2.0, 2.0)

    def course(self) -> Course:
        """Return x_e by the names of `SurfaceRow`."""
        speed = float(np.linalg.norm(self.velocity))
        direction = np.array(self.velocity) / speed if speed > 0.0 else np.zeros(3)
        return AT_REST | {"direction": direction, "speed": speed}


@dataclass
class SineMotion:
    """x_e(t) = A sin(2 pi f t + phase) along a direction.

    Attributes:
        direction: unit vector in W.
        amplitude: A.
        frequency: f.
        phase: at t = 0.
    """

    direction: list[float] = vector([0.0, 1.0, 0.0], "1", -1.0, 1.0)
    amplitude: float = number(0.005, "m", 0.0, 1.0)
    frequency: float = number(0.5, "Hz", 0.0, 20.0)
    phase: float = number(0.0, "rad", -10.0, 10.0)

    def check_together(self, name: str) -> None:
        """Check that the direction is a unit vector.

        Raises:
            ValueError: it is not.
        """
        check_unit(f"{name}.direction", self.direction)

    def course(self) -> Course:
        """Return x_e by the names of `SurfaceRow`."""
        return AT_REST | {
            "direction": self.direction,
            "amplitude": self.amplitude,
            "omega": 2 * np.pi * self.frequency,
            "phase": self.phase,
        }


@dataclass(kw_only=True)
class Compliance:
    """How a surface yields and moves; stiffness and damping default to Table 4 of the paper.

    A kind of surface adds its `name` and its place to these, and says in a kernel of the table
    `DISTANCES`, or in its method `distance`, how far a point is from it.

    Attributes:
        law: "impedance", equation (52); "hunt_crossley"; or "drake", the compliant point contact of
            the plant between the shape of the tool and that of the surface, with friction.
        stiffness: K; with an exponent n its unit is N/mⁿ.
        damping: B of the impedance.
        blend: depth over which the damping of the impedance grows to B.
        exponent: n of Hunt and Crossley.
        alpha: of Hunt and Crossley, also in Drake's contact: a body that bounces with the speed v
            keeps 1 - alpha v of it, for small v.
        motion: of the surface; None is at rest.
    """

    law: str = choice("impedance", list(LAWS))
    stiffness: float = number(1e4, "N/m", 0.0, 1e6, symbol="K_e", equation="(52)")
    damping: float = number(100.0, "N s/m", 0.0, 1e4, symbol="B_e", equation="(52)")
    blend: float = number(1e-3, "m", 1e-6, 0.1)
    exponent: float = number(1.0, "1", 1.0, 1.5)
    alpha: float = number(0.5, "s/m", 0.0, 10.0)
    motion: ConstantVelocity | SineMotion | None = None

    def check_together(self, name: str) -> None:
        """Check what Drake's contact asks for.

        Raises:
            ValueError: no stiffness with the law "drake", or a motion.
        """
        if self.law == "drake":
            checks.number(f"{name}.stiffness", self.stiffness, ABOVE_ZERO, 1e6)
            if self.motion is not None:
                raise ValueError(f"{name}.motion: set, allowed none with the law 'drake'")

    def pose(self) -> RigidTransform:
        """X_WS of the surface frame where the surface is without its motion."""
        raise NotImplementedError

    def distance(self, p_S: Array, normal_S: Array) -> float:
        """Signed distance [m] of a point (3,), in the frame S; writes the unit gradient (3,).

        It is asked of the kinds that are not in `DISTANCES`, once a tick: plain Python will do.
        """
        raise NotImplementedError

    def half_lengths(self) -> list[float]:
        """Return `half` of `SurfaceRow` (3,) [m]."""
        return [0.0, 0.0, 0.0]

    def edge(self) -> float:
        """Return the radius of the edges [m]."""
        return 0.0

    def shape(self) -> tuple[geometry.Shape, RigidTransform]:
        """What is drawn and stops the links, and its pose X_SG."""
        raise NotImplementedError

    def corners(self) -> Array:
        """Corners (n, 3) in W [m] of what is to be seen."""
        raise NotImplementedError

    def course(self) -> Course:
        """Return the motion by the names of `SurfaceRow`."""
        return AT_REST if self.motion is None else self.motion.course()

    def pose_at(self, time: float) -> RigidTransform:
        """X_WS at a time [s]."""
        if self.motion is None:
            return self.pose()
        course = {name: np.array(value) for name, value in self.course().items()}
        wave = course["amplitude"] * np.sin(course["omega"] * time + course["phase"])
        offset = course["speed"] * time + wave
        return RigidTransform(offset * course["direction"]) @ self.pose()


def check_unit(name: str, direction: list[float]) -> None:
    """Accept a unit vector (3,), to 0.1 %.

    Raises:
        ValueError: otherwise.
    """
    length = float(np.linalg.norm(direction))
    if abs(length - 1.0) > 1e-3:
        raise ValueError(f"{name}: length {length:.4g}, allowed 1 (a unit vector)")


def check_name(name: str, value: str) -> None:
    """Accept the name of a surface.

    Raises:
        ValueError: it is no word, see `checks.word`.
    """
    checks.word(f"{name}.name", value)
