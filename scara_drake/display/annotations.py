"""What the operator sees beside the robot: ghost, trail, contact force and moving surfaces.

Everything that moves is drawn by transforms and properties with a time stamp, never by replacing
shapes, so that a recording plays in the saved page as the run did.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from pydrake.common.value import Value
from pydrake.geometry import (
    Box,
    Cylinder,
    FrameId,
    Meshcat,
    MeshcatCone,
    QueryObject,
    Rgba,
    Role,
    SceneGraphInspector,
    Shape,
    Sphere,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from scara_drake.common.pace import Pace
from scara_drake.display import look
from scara_drake.environment import Surface
from scara_drake.environment.scene import drawing
from scara_drake.kinematics import rotation_from_quaternion_kernel, tool_pose_kernel

Array = NDArray[np.float64]

PERIOD = 1.0 / 32.0  # of the pictures [s]
TRAIL_PERIOD = 1.0 / 16.0  # [s]
BEHIND = 0.02  # of a run in real time [s]: pictures wait
ROBOT = "illustration"  # where Drake's visualizer puts the robot
_ROOT = "annotations"


class SceneAnnotations(LeafSystem):
    """Draws in Meshcat the desired tool as a ghost, the trail of the tool and the contact force.

    And the surfaces that move, where they are; those at rest are in the plant's geometry.

    And the robot itself, whose shapes Drake's visualizer has put into the scene.

    And a sky of another colour while the operator's device is lost; and, of a device that pushes,
    its motion and where the hand wants it.

    Input ports (all but the first may stay unconnected; what they describe is not drawn then):
        state (12): q, v measured [m, rad, m/s, rad/s]
        X_WE_desired (7): p (3) [m], quaternion w, x, y, z of the desired tool
        f_env_on_tool_W (3): force of the environment on the tool point [N]
        device_connected (1): 0 while the operator's device is lost
        motion_master (6): x, v of a device that pushes [m, m/s]
        hand_target (3): where the hand wants it [m]
        query_object: of the scene graph
    Discrete state: the index of the newest point of the trail, and its points (n, 3) [m] as a ring.
    Update (every TRAIL_PERIOD): the tool point joins the trail. Initial: all its points are there.
    Publish (every PERIOD): the pictures, at the time of the context in a recording; none while a
    run in real time is more than BEHIND late, so that a slow browser gets less to do.

    Attributes:
        pace: of the run.
    """

    __slots__ = ()  # so that it can be freed, see `Collectable`

    def __init__(self, meshcat: Meshcat, points: int = 64, surfaces: Sequence[Surface] = ()):
        super().__init__()
        self._meshcat, self._points = meshcat, points
        self.pace, self._dropped = Pace(), False
        self._frames: list[tuple[str, FrameId]] = []
        self._moving = [surface for surface in surfaces if surface.motion is not None]
        self._state = self.DeclareVectorInputPort("state", 12)
        self._desired = self.DeclareVectorInputPort("X_WE_desired", 7)
        self._force = self.DeclareVectorInputPort("f_env_on_tool_W", 3)
        self._connected = self.DeclareVectorInputPort("device_connected", 1)
        self._held = {
            name: self.DeclareVectorInputPort(name, size)
            for name, size in (("motion_master", 6), ("hand_target", 3))
        }
        self._query = self.DeclareAbstractInputPort("query_object", Value(QueryObject()))
        self._trail = int(self.DeclareDiscreteState(np.r_[-1.0, np.zeros(3 * points)]))
        self.DeclareInitializationDiscreteUpdateEvent(self._start_trail)
        self.DeclarePeriodicDiscreteUpdateEvent(TRAIL_PERIOD, 0.0, self._extend_trail)
        self.DeclareInitializationPublishEvent(self._draw)
        self.DeclareForcedPublishEvent(self._draw)
        self.DeclarePeriodicPublishEvent(PERIOD, 0.0, self._move)

    def _tool_point(self, context: Context) -> Array:
        p_WE, R_WE = np.empty(3), np.empty((3, 3))
        tool_pose_kernel(self._state.Eval(context)[:6], p_WE, R_WE)
        return p_WE

    def _start_trail(self, context: Context, discrete: DiscreteValues) -> None:
        if context.get_time() > 0.0:
            return  # a clone goes on
        trail = discrete.get_mutable_value(self._trail)
        trail[0] = 0.0
        trail[1:].reshape(-1, 3)[:] = self._tool_point(context)

    def _extend_trail(self, context: Context, discrete: DiscreteValues) -> None:
        trail = discrete.get_mutable_value(self._trail)
        newest = int(trail[0] + 1) % self._points
        trail[0] = newest
        trail[1 + 3 * newest : 4 + 3 * newest] = self._tool_point(context)

    def _draw(self, context: Context) -> None:
        """Put the shapes into the scene, then everything in its place."""
        meshcat = self._meshcat
        meshcat.Delete(_ROOT)
        if self._query.HasValue(context):
            self._frames = _frames(self._query.Eval(context).inspector())
        for part in look.GHOST:
            _draw_part(meshcat, f"{_ROOT}/ghost", part)
        for part in (look.SHAFT, look.TIP):
            _draw_part(meshcat, f"{_ROOT}/force", part)
            # The wall, though translucent, would wash the arrow out.
            path = f"{_ROOT}/force/{part.name}/<object>"
            meshcat.SetProperty(path, "renderOrder", 1.0)
            meshcat.SetProperty(path, "material.depthTest", False)
        board = f"{_ROOT}/board"
        for part in (look.BOARD, *look.HELD.values()):
            _draw_part(meshcat, board, part)
        meshcat.SetTransform(board, RigidTransform(look.BOARD_PLACE))
        tube = Cylinder(look.TRAIL_RADIUS, 1.0)
        for index in range(self._points):
            meshcat.SetObject(f"{_ROOT}/trail/{index}/tube", tube, Rgba(*look.MEASURED))
        for surface in self._moving:
            for name, shape, X_SG, color in drawing(surface):
                path = f"{_ROOT}/surfaces/{surface.name}/{name}"
                meshcat.SetObject(path, shape, Rgba(*color))
                meshcat.SetTransform(path, X_SG)
        self._place(context, range(self._points))

    def _move(self, context: Context) -> None:
        behind, dropped = self.pace.lateness > BEHIND, self._dropped
        self._dropped = behind
        if behind:
            self.pace.pictures_dropped += 1
            return
        if dropped:
            self._place(context, range(self._points))
            return
        # Of the trail, only three pieces change or are about to: the one that grows, the one that
        # has just been finished, and the oldest, which is stamped once more because a recording
        # would else let it drift to its next place from its first moment on.
        newest = int(context.get_discrete_state(self._trail).value()[0])
        self._place(context, (newest - 1, newest, newest + 1))

    def _place(self, context: Context, pieces: range | tuple[int, ...]) -> None:
        time, tool = context.get_time(), self._tool_point(context)
        self._place_robot(context, time)
        self._place_ghost(context, time)
        self._place_force(context, time, tool)
        self._place_held(context, time)
        self._color_sky(context, time)
        for surface in self._moving:
            path = f"{_ROOT}/surfaces/{surface.name}"
            self._meshcat.SetTransform(path, surface.pose_at(time), time)
        trail = context.get_discrete_state(self._trail).value()
        newest, points = int(trail[0]), trail[1:].reshape(-1, 3)
        self._meshcat.SetProperty(f"{_ROOT}/trail", "visible", newest >= 0, time)
        for piece in pieces:
            index = piece % self._points
            end = tool if index == newest else points[(index + 1) % self._points]
            self._place_tube(f"{_ROOT}/trail/{index}", points[index], end, time)

    def _place_robot(self, context: Context, time: float) -> None:
        if self._frames:
            query = self._query.Eval(context)
            for path, frame in self._frames:
                self._meshcat.SetTransform(path, query.GetPoseInWorld(frame), time)

    def _place_ghost(self, context: Context, time: float) -> None:
        known = self._desired.HasValue(context)
        self._meshcat.SetProperty(f"{_ROOT}/ghost", "visible", known, time)
        if known:
            pose, R_WE = self._desired.Eval(context), np.empty((3, 3))
            rotation_from_quaternion_kernel(pose[3:], R_WE)
            X_WE = RigidTransform(RotationMatrix(R_WE), pose[:3])
            self._meshcat.SetTransform(f"{_ROOT}/ghost", X_WE, time)

    def _place_force(self, context: Context, time: float, tool: Array) -> None:
        f_W = self._force.Eval(context) if self._force.HasValue(context) else np.zeros(3)
        size = float(np.linalg.norm(f_W))
        path, meshcat = f"{_ROOT}/force", self._meshcat
        meshcat.SetProperty(path, "visible", size >= look.SMALLEST_FORCE, time)
        if size >= look.SMALLEST_FORCE:
            shaft = float(look.shaft_length(size))
            X_WF = RigidTransform(RotationMatrix.MakeFromOneVector(f_W, 2), tool)
            meshcat.SetTransform(path, X_WF, time)
            middle = [0.0, 0.0, float(look.shaft_middle(shaft))]
            meshcat.SetProperty(f"{path}/shaft", "position", middle, time)
            meshcat.SetProperty(f"{path}/shaft", "scale", [1.0, 1.0, shaft], time)

    def _place_held(self, context: Context, time: float) -> None:
        held = [name for name, port in self._held.items() if port.HasValue(context)]
        self._meshcat.SetProperty(f"{_ROOT}/board", "visible", bool(held), time)
        for name in held:
            place = look.on_board(self._held[name].Eval(context)[:3])
            path = f"{_ROOT}/board/{look.HELD[name].name}"
            self._meshcat.SetTransform(path, RigidTransform(place), time)

    def _color_sky(self, context: Context, time: float) -> None:
        if self._connected.HasValue(context):
            sky = look.SKY if self._connected.Eval(context)[0] else look.SKY_LOST
            for name, color in sky.items():
                self._meshcat.SetProperty("/Background/<object>", name, color, time)

    def _place_tube(self, path: str, start: Array, end: Array, time: float) -> None:
        along = end - start
        length = float(np.linalg.norm(along))
        R = RotationMatrix.MakeFromOneVector(along, 2) if length > 1e-6 else RotationMatrix()
        self._meshcat.SetTransform(path, RigidTransform(R, (start + end) / 2), time)
        scale = [1.0, 1.0, max(length, 1e-6)]
        self._meshcat.SetProperty(f"{path}/tube", "scale", scale, time)


def _frames(inspector: SceneGraphInspector) -> list[tuple[str, FrameId]]:
    """Return the frames that carry shapes, with their paths in the scene."""
    return [
        (f"{ROBOT}/{inspector.GetName(frame).replace('::', '/')}", frame)
        for frame in inspector.GetAllFrameIds()
        if frame != inspector.world_frame_id()
        and inspector.NumGeometriesForFrameWithRole(frame, Role.kIllustration)
    ]


def _draw_part(meshcat: Meshcat, root: str, part: look.Part) -> None:
    shape, X_PS = _shape(part), RigidTransform(part.X)
    if part.shape == "cone":  # Drake's has its tip at the origin and opens along z
        turned = RotationMatrix.MakeXRotation(np.pi)
        X_PS = X_PS @ RigidTransform(turned, np.array([0.0, 0.0, part.size[1] / 2]))
    meshcat.SetObject(f"{root}/{part.name}", shape, Rgba(*part.color))
    meshcat.SetTransform(f"{root}/{part.name}", X_PS)


def _shape(part: look.Part) -> Shape:
    if part.shape == "box":
        return Box(*part.size)
    if part.shape == "sphere":
        return Sphere(*part.size)
    radius, length = part.size
    if part.shape == "cone":
        return MeshcatCone(length, radius, radius)
    return Cylinder(radius, length)
