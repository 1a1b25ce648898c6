"""A surface of your own: the tool presses on a sphere, and the force is K d along its normal.

A surface is a dataclass over `Compliance`, which has the stiffness, the damping and the motion. It
adds a name, a place, a shape to draw, and one thing that the contact asks: how far is a point from
you, and which way is out?

    python examples/own_surface.py
"""

from dataclasses import dataclass

import numpy as np
from pydrake import geometry
from pydrake.math import RigidTransform

import scara_drake as sd
from scara_drake import metrics
from scara_drake.common.fields import number, vector
from scara_drake.environment import Compliance


@dataclass
class Sphere(Compliance):
    """A ball.

    Attributes:
        name: of the sphere, a word.
        centre: in W.
        radius: of the sphere.
    """

    name: str = "ball"
    # The recorded operator holds the tool at (0.85, -0.91, 3.15) at t = 8.4 s: 7 mm inside.
    centre: list[float] = vector([0.87, -1.0, 3.16], "m", -100.0, 100.0)
    radius: float = number(0.1, "m", 1e-3, 100.0)

    def pose(self) -> RigidTransform:
        """X_WS: where the frame S of the surface is in the world W."""
        return RigidTransform(np.array(self.centre))

    def distance(self, p_S: np.ndarray, normal_S: np.ndarray) -> float:
        """Distance [m] of a point in S, negative inside; writes the unit normal."""
        away = float(np.linalg.norm(p_S))
        normal_S[:] = p_S / away if away > 0.0 else [0.0, 0.0, 1.0]
        return away - self.radius

    def shape(self) -> tuple[geometry.Shape, RigidTransform]:
        """What is drawn and stops the other links, and where in S."""
        return geometry.Sphere(self.radius), RigidTransform()

    def corners(self) -> np.ndarray:
        """Points in W that the camera should see [m]."""
        signs = np.stack(np.meshgrid(*[(-1.0, 1.0)] * 3), axis=-1).reshape(-1, 3)
        return np.array(self.centre) + self.radius * signs


ball = Sphere(stiffness=10000.0, damping=100.0)  # [N/m], [N s/m]
scenario = sd.load_scenario("teleoperation")
scenario.environment.surfaces = [ball]  # type: ignore[list-item]  # the union has shipped kinds

recording = sd.simulate(scenario, duration=9.0)
away = recording.p_WE_measured.values - np.array(ball.centre)
depth = ball.radius - np.linalg.norm(away, axis=1)
deepest = int(depth.argmax())
f, normal = recording.f_env_on_tool_W.values[deepest], away[deepest]

print(f"largest force        {float(metrics.contact_force(recording).max()):8.3f} N")
print(f"largest depth d      {1e3 * depth[deepest]:8.3f} mm")
# There the depth no longer grows, so the damper is silent and only the spring is felt.
print(f"force there          {np.linalg.norm(f):8.3f} N")
print(f"K d there            {ball.stiffness * depth[deepest]:8.3f} N")
off = np.linalg.norm(np.cross(f, normal)) / np.linalg.norm(f) / np.linalg.norm(normal)
print(f"force off the normal {off:8.1e} rad")
