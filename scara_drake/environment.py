"""What the tool can touch: walls, and the impedance contact of the tool point with them.

Equation (52) of the paper, made unilateral. With the penetration d = n . (p_wall - p_tool) and its
rate d' = -n . v_tool, the environment pushes the tool along the normal n with::

    f = max(0, K d + b(d) B d'),   b(d) = min(d / blend, 1),   where d > 0;   else f = 0

The raw equation steps by B d' at touch and pulls the tool back on a fast retreat. The blend b lets
the damping grow over the first millimetre, so the force starts at zero; the clamp never pulls.
"""

from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydrake.geometry import Box, CollisionFilterDeclaration, GeometrySet, SceneGraph
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from scara_drake import checks, robot
from scara_drake.kinematics import tool_kinematics_kernel
from scara_drake.state import declare_state

Array = NDArray[np.float64]

WALL_COLOR = (0.42, 0.58, 0.74, 0.30)
EDGE_COLOR = (0.20, 0.29, 0.40, 1.0)
_EDGE = 0.03  # width of the drawn edge frame [m]
_TOOL_LINKS = ("link_6", robot.TOOL_FRAME)


@njit(cache=True)
def contact_force(
    p_WE: Array, v_WE: Array, surfaces: Array, penetration: Array, f_W: Array
) -> None:
    """Write the penetrations (n,) [m] and the force (3,) [N] on a point (3,) moving at v (3,).

    `surfaces` is `Environment.parameters`; the forces of several surfaces add up.
    """
    f_W[:] = 0.0
    for i in range(surfaces.shape[0]):
        depth = rate = 0.0
        for k in range(3):
            n = surfaces[i, 3 + k]
            depth += n * (surfaces[i, k] - p_WE[k])
            rate -= n * v_WE[k]
        penetration[i] = max(depth, 0.0)
        if depth > 0.0:
            stiffness, damping, blend = surfaces[i, 6], surfaces[i, 7], surfaces[i, 8]
            f = max(stiffness * depth + damping * min(depth / blend, 1.0) * rate, 0.0)
            for k in range(3):
                f_W[k] += f * surfaces[i, 3 + k]


@njit(cache=True)
def tool_contact(
    state: Array, surfaces: Array, penetration: Array, f_W: Array, generalized_force: Array
) -> None:
    """Write the contact of the tool point of a robot state (12,), and J_vᵀ f (6,) [N, N m]."""
    p, v, R, J = np.empty(3), np.zeros(3), np.empty((3, 3)), np.empty((6, 6))
    tool_kinematics_kernel(state[:6], p, R, J)
    for i in range(3):
        for j in range(6):
            v[i] += J[3 + i, j] * state[6 + j]
    contact_force(p, v, surfaces, penetration, f_W)
    for j in range(6):
        generalized_force[j] = J[3, j] * f_W[0] + J[4, j] * f_W[1] + J[5, j] * f_W[2]


@dataclass
class Wall:
    """A flat compliant surface; stiffness and damping default to Table 4 of the paper.

    The tool feels the whole half-space behind the plane, so nothing slips past an edge; `size` and
    `thickness` are the block that is drawn and that stops the other links.
    """

    name: str = "wall"
    point: list[float] = field(default_factory=lambda: [0.8, -1.05, 3.0])  # on the surface, W [m]
    normal: list[float] = field(default_factory=lambda: [0.0, 1.0, 0.0])  # unit, out of the wall
    size: list[float] = field(default_factory=lambda: [2.0, 1.6])  # width, height [m]
    thickness: float = 0.08  # [m]
    stiffness: float = 1e4  # K [N/m]
    damping: float = 100.0  # B [N s/m]
    blend: float = 1e-3  # depth over which the damping grows to B [m]

    def validate(self, name: str) -> None:
        """Check the wall; `name` is the field's path in the scenario.

        Raises:
            ValueError: a number out of its range, or a normal that is no unit vector.
        """
        if not self.name or "/" in self.name:
            raise ValueError(f"{name}.name: '{self.name}', allowed a word without '/'")
        checks.vector(f"{name}.point", self.point, 3, -100.0, 100.0)
        checks.vector(f"{name}.normal", self.normal, 3, -1.0, 1.0)
        length = float(np.linalg.norm(self.normal))
        if abs(length - 1.0) > 1e-3:
            raise ValueError(f"{name}.normal: length {length:.4g}, allowed 1 (a unit vector)")
        checks.vector(f"{name}.size", self.size, 2, 0.1, 100.0)
        checks.number(f"{name}.thickness", self.thickness, 1e-3, 10.0)
        checks.number(f"{name}.stiffness", self.stiffness, 0.0, 1e6)
        checks.number(f"{name}.damping", self.damping, 0.0, 1e4)
        checks.number(f"{name}.blend", self.blend, 1e-6, 0.1)

    def pose(self) -> RigidTransform:
        """X_WS of the surface frame S at `point`: z out of the wall, x along its width, y up."""
        z = np.array(self.normal) / np.linalg.norm(self.normal)
        level = abs(z[2]) > 0.99  # a floor or a ceiling: its height runs along the world's y
        x = np.cross([0.0, 1.0, 0.0] if level else [0.0, 0.0, 1.0], z)
        x /= np.linalg.norm(x)
        R_WS = np.column_stack([x, np.cross(z, x), z])
        return RigidTransform(RotationMatrix(R_WS), np.array(self.point))


@dataclass
class Environment:
    """The surfaces around the robot; none by default, which is free space."""

    surfaces: list[Wall] = field(default_factory=list)

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
        """Rows (n, 9) of the contact: point (3) [m], unit normal (3), K, B, blend; in W."""
        rows = [
            [*s.point, *s.pose().rotation().col(2), s.stiffness, s.damping, s.blend]
            for s in self.surfaces
        ]
        return np.array(rows, dtype=np.float64).reshape(-1, 9)


class ImpedanceContact(LeafSystem):
    """Contact of the tool point with the surfaces of an environment, equation (52).

    Input port:
        state (12): q, v measured [m, rad, m/s, rad/s]
    Output ports, all discrete state:
        f_env_on_tool_W (3): force of the environment on the tool point [N]
        generalized_force (6): J_vᵀ f [N, N m]
        penetration (n): depth below each surface, zero outside [m]; n may be 0
    Update (every period) and initial: the same equations, see `tool_contact`.

    A plant with sampled output ports steps before discrete states are updated: the force written at
    tick k is that of the state from which step k + 1 starts, so the contact adds no delay.
    """

    def __init__(self, environment: Environment, period: float = 1e-3):
        super().__init__()
        self._surfaces = environment.parameters()
        self._state = self.DeclareVectorInputPort("state", 12)
        self._f = declare_state(self, 3, "f_env_on_tool_W")
        self._generalized = declare_state(self, 6, "generalized_force")
        self._penetration = declare_state(self, len(environment.surfaces), "penetration")
        self.DeclareInitializationDiscreteUpdateEvent(self._update)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        tool_contact(
            self._state.Eval(context),
            self._surfaces,
            discrete.get_mutable_value(self._penetration),
            discrete.get_mutable_value(self._f),
            discrete.get_mutable_value(self._generalized),
        )


def add_walls(plant: MultibodyPlant, scene_graph: SceneGraph, environment: Environment) -> None:
    """Draw the walls, fixed to the world, and let them stop every link but the tool.

    The tool against a wall is `ImpedanceContact`'s: Drake's own contact between the two is
    excluded, or the force would count twice. Call it after `robot.add_scara`, because the exclusion
    holds for shapes that exist, and before `plant.Finalize()`, because it adds shapes.
    """
    tool = plant.CollectRegisteredGeometries([plant.GetBodyByName(name) for name in _TOOL_LINKS])
    world = plant.world_body()
    filters = scene_graph.collision_filter_manager()
    for wall in environment.surfaces:
        X_WS = wall.pose()
        width, height = wall.size
        block = Box(width, height, wall.thickness)
        X_WB = X_WS @ RigidTransform([0.0, 0.0, -wall.thickness / 2])
        plant.RegisterVisualGeometry(world, X_WB, block, wall.name, np.array(WALL_COLOR))
        for index, (bar, p_BF) in enumerate(_edge_frame(width, height, wall.thickness)):
            edge, X_WF = f"{wall.name}_edge_{index}", X_WB @ RigidTransform(p_BF)
            plant.RegisterVisualGeometry(world, X_WF, bar, edge, np.array(EDGE_COLOR))
        shape = plant.RegisterCollisionGeometry(
            world, X_WB, block, f"{wall.name}_shape", CoulombFriction(0.6, 0.5)
        )
        filters.Apply(CollisionFilterDeclaration().ExcludeBetween(tool, GeometrySet(shape)))


def _edge_frame(width: float, height: float, thickness: float) -> list[tuple[Box, list[float]]]:
    """Four bars around a block, each with its place in the block's frame."""
    x, y = (width + _EDGE) / 2, (height + _EDGE) / 2
    flat = Box(width + 2 * _EDGE, _EDGE, thickness)
    upright = Box(_EDGE, height, thickness)
    return [(flat, [0, y, 0]), (flat, [0, -y, 0]), (upright, [x, 0, 0]), (upright, [-x, 0, 0])]
