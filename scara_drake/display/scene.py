"""What the operator sees in Meshcat: robot, surfaces, ghost, trail, contact force, Stop button.

Everything that moves is drawn by transforms and properties with a time stamp, never by replacing
shapes, so that a recording plays in the saved page as the run did.
"""

import os
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import Cylinder, Meshcat, MeshcatCone, Rgba, SceneGraph, Sphere
from pydrake.lcm import DrakeLcm
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Context, DiagramBuilder, DiscreteValues, LeafSystem
from pydrake.visualization import ApplyVisualizationConfig, VisualizationConfig

from scara_drake.environment import Environment, Surface
from scara_drake.environment.scene import drawing
from scara_drake.kinematics import rotation_from_quaternion_kernel, tool_pose_kernel

Array = NDArray[np.float64]

PERIOD = 1.0 / 32.0  # of the pictures [s]
TRAIL_PERIOD = 1.0 / 16.0  # [s]
GHOST_COLOR = Rgba(0.95, 0.05, 0.75, 0.40)
TRAIL_COLOR = Rgba(0.05, 0.62, 0.45, 1.0)
FORCE_COLOR = Rgba(0.90, 0.04, 0.04, 0.99)  # not opaque: drawn after the translucent wall

FORCE_THRESHOLD = 1.0  # below it no arrow is drawn [N]
_METRES_PER_NEWTON = 1.0 / 400.0
_LONGEST_ARROW = 0.9  # [m]
_HEAD = 0.14  # length of the arrow head [m]
_ARM = np.array([[-0.3, 0.5, 3.0], [0.0, 0.0, 3.9], [1.3, -0.6, 3.0], [0.6, 0.6, 2.6]])  # [m]
_VIEW = np.array([1.0, 0.6, 0.5])  # from the scene to the camera
_ZOOM = 2.2
_HALF_HEIGHT = np.tan(np.deg2rad(75.0 / 2)) / _ZOOM  # of the picture, one metre from the camera
_ASPECT = 1.5  # width to height; a wider window shows more
_FILL = 0.9  # part of the picture that the scene fills
_ROOT = "annotations"


def set_camera(meshcat: Meshcat, environment: Environment) -> None:
    """Look at the arm, the foot of the mast and the surfaces from the operator's side."""
    points = [p.copy() for p in _ARM]
    for surface in environment.surfaces:
        points += list(surface.corners())
    target = (np.min(points, axis=0) + np.max(points, axis=0)) / 2
    # The camera's axes; the nearest distance from which each point falls within the picture.
    back = _VIEW / np.linalg.norm(_VIEW)
    right = np.cross([0.0, 0.0, 1.0], back) / np.hypot(back[0], back[1])
    up = np.cross(back, right)
    offsets = np.array(points) - target
    high, wide = np.abs(offsets @ up), np.abs(offsets @ right) / _ASPECT
    distance = float(np.max(offsets @ back + np.maximum(high, wide) / (_FILL * _HALF_HEIGHT)))
    meshcat.SetCameraPose(target + distance * back, target)
    # A longer lens than the default 75 degrees, so that the picture is less bent.
    meshcat.SetProperty("/Cameras/default/rotated/<object>", "zoom", _ZOOM)
    meshcat.SetProperty("/Background/<object>", "top_color", [0.78, 0.86, 0.94])
    meshcat.SetProperty("/Background/<object>", "bottom_color", [0.99, 0.99, 0.99])
    meshcat.SetProperty("/Axes", "visible", False)


class SceneAnnotations(LeafSystem):
    """Draws in Meshcat the desired tool as a ghost, the trail of the tool and the contact force.

    And the surfaces that move, where they are; those at rest are in the plant's geometry.

    Input ports (the last two may stay unconnected; what they describe is not drawn then):
        state (12): q, v measured [m, rad, m/s, rad/s]
        X_WE_desired (7): p (3) [m], quaternion w, x, y, z of the desired tool
        f_env_on_tool_W (3): force of the environment on the tool point [N]
    Discrete state: the index of the newest point of the trail, and its points (n, 3) [m] as a ring.
    Update (every TRAIL_PERIOD): the tool point joins the trail. Initial: all its points are there.
    Publish (every PERIOD): the pictures, at the time of the context in a recording.
    """

    def __init__(self, meshcat: Meshcat, points: int = 64, surfaces: Sequence[Surface] = ()):
        super().__init__()
        self._meshcat, self._points = meshcat, points
        self._moving = [surface for surface in surfaces if surface.motion is not None]
        self._state = self.DeclareVectorInputPort("state", 12)
        self._desired = self.DeclareVectorInputPort("X_WE_desired", 7)
        self._force = self.DeclareVectorInputPort("f_env_on_tool_W", 3)
        self._trail = self.DeclareDiscreteState(np.r_[-1.0, np.zeros(3 * points)])
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
        _draw_ghost(meshcat, f"{_ROOT}/ghost")
        _draw_arrow(meshcat, f"{_ROOT}/force")
        for index in range(self._points):
            meshcat.SetObject(f"{_ROOT}/trail/{index}/tube", Cylinder(0.008, 1.0), TRAIL_COLOR)
        for surface in self._moving:
            for name, shape, X_SG, color in drawing(surface):
                path = f"{_ROOT}/surfaces/{surface.name}/{name}"
                meshcat.SetObject(path, shape, Rgba(*color))
                meshcat.SetTransform(path, X_SG)
        self._place(context, range(self._points))

    def _move(self, context: Context) -> None:
        # Of the trail, only three pieces change or are about to: the one that grows, the one that
        # has just been finished, and the oldest, which is stamped once more because a recording
        # would else let it drift to its next place from its first moment on.
        newest = int(context.get_discrete_state(self._trail).value()[0])
        self._place(context, (newest - 1, newest, newest + 1))

    def _place(self, context: Context, pieces: range | tuple[int, ...]) -> None:
        time, tool = context.get_time(), self._tool_point(context)
        self._place_ghost(context, time)
        self._place_force(context, time, tool)
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
        meshcat.SetProperty(path, "visible", size >= FORCE_THRESHOLD, time)
        if size >= FORCE_THRESHOLD:
            shaft = min(size * _METRES_PER_NEWTON, _LONGEST_ARROW)
            X_WF = RigidTransform(RotationMatrix.MakeFromOneVector(f_W, 2), tool)
            meshcat.SetTransform(path, X_WF, time)
            middle = [0.0, 0.0, -_HEAD - shaft / 2]
            meshcat.SetProperty(f"{path}/shaft", "position", middle, time)
            meshcat.SetProperty(f"{path}/shaft", "scale", [1.0, 1.0, shaft], time)

    def _place_tube(self, path: str, start: Array, end: Array, time: float) -> None:
        along = end - start
        length = float(np.linalg.norm(along))
        R = RotationMatrix.MakeFromOneVector(along, 2) if length > 1e-6 else RotationMatrix()
        self._meshcat.SetTransform(path, RigidTransform(R, (start + end) / 2), time)
        scale = [1.0, 1.0, max(length, 1e-6)]
        self._meshcat.SetProperty(f"{path}/tube", "scale", scale, time)


def _draw_ghost(meshcat: Meshcat, path: str) -> None:
    """The tool as a translucent rod ending in a ball at the tool point, with the frame's axes."""
    meshcat.SetObject(f"{path}/rod", Cylinder(0.075, 0.62), GHOST_COLOR)
    meshcat.SetTransform(f"{path}/rod", RigidTransform(np.array([0.0, 0.0, -0.36])))
    meshcat.SetObject(f"{path}/tip", Sphere(0.05), GHOST_COLOR)
    length = 0.25
    for axis, color in enumerate([Rgba(0.9, 0.1, 0.1), Rgba(0.1, 0.75, 0.1), Rgba(0.1, 0.3, 0.95)]):
        direction = np.eye(3)[axis]
        X = RigidTransform(RotationMatrix.MakeFromOneVector(direction, 2), direction * length / 2)
        meshcat.SetObject(f"{path}/axis_{axis}", Cylinder(0.009, length), color)
        meshcat.SetTransform(f"{path}/axis_{axis}", X)


def _draw_arrow(meshcat: Meshcat, path: str) -> None:
    """An arrow along z that ends at the origin: it pushes on the tool, whose body hides no part.

    The shaft is one metre long, to be scaled.
    """
    meshcat.SetObject(f"{path}/shaft", Cylinder(0.028, 1.0), FORCE_COLOR)
    meshcat.SetObject(f"{path}/head", MeshcatCone(_HEAD, 0.07, 0.07), FORCE_COLOR)
    meshcat.SetTransform(f"{path}/head", RigidTransform(RotationMatrix.MakeXRotation(np.pi)))
    for part in ("shaft", "head"):  # the wall, though translucent, would wash them out
        meshcat.SetProperty(f"{path}/{part}/<object>", "renderOrder", 1.0)
        meshcat.SetProperty(f"{path}/{part}/<object>", "material.depthTest", False)


def add_visualization(
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    scene_graph: SceneGraph,
    meshcat: Meshcat,
    environment: Environment,
    collision_shapes: bool = False,
) -> SceneAnnotations:
    """Draw a finalized plant and return the annotations, named and in the builder, to be connected.

    Args:
        builder: of the Diagram that holds the plant and the scene graph.
        plant: with the robot and the surfaces.
        scene_graph: of the plant.
        meshcat: where to draw; its camera is set.
        environment: the surfaces, for the camera and for those that move.
        collision_shapes: also offers Drake's collision shapes and contact forces, for debugging.
    """
    config = VisualizationConfig(
        publish_period=PERIOD,
        publish_proximity=collision_shapes,
        publish_contacts=collision_shapes,
        publish_inertia=False,
    )
    ApplyVisualizationConfig(
        config,
        builder,
        plant=plant,
        scene_graph=scene_graph,
        meshcat=meshcat,
        lcm=DrakeLcm("memq://null"),  # nothing goes on the network
    )
    set_camera(meshcat, environment)
    return builder.AddNamedSystem(
        "annotations", SceneAnnotations(meshcat, surfaces=environment.surfaces)
    )


class StopButton:
    """A Stop button in Meshcat while the context lasts; the Escape key presses it too.

    Without a meshcat it does nothing, so a caller needs no second path.
    """

    def __init__(self, meshcat: Meshcat | None, name: str = "Stop"):
        self._meshcat, self._name = meshcat, name

    def __enter__(self) -> "StopButton":
        if self._meshcat is not None:
            self._meshcat.DeleteButton(self._name, strict=False)  # left over from another run
            self._meshcat.AddButton(self._name, "Escape")
        return self

    def pressed(self) -> bool:
        """Tell whether it has been pressed since the context was entered."""
        return self._meshcat is not None and self._meshcat.GetButtonClicks(self._name) > 0

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if self._meshcat is not None:
            self._meshcat.DeleteButton(self._name, strict=False)


def start_recording(meshcat: Meshcat) -> None:
    """Begin a new recording of what is drawn, one frame a picture."""
    meshcat.DeleteRecording()
    meshcat.StartRecording(frames_per_second=1.0 / PERIOD, set_visualizations_while_recording=True)


def publish_recording(meshcat: Meshcat) -> None:
    """End the recording and give it to the browsers and to the page of `save_html`."""
    meshcat.StopRecording()
    meshcat.PublishRecording()


def save_html(meshcat: Meshcat, path: str | Path) -> Path:
    """Save the scene, with its published recording, as one page that needs no network.

    The file appears whole or not at all.

    Raises:
        OSError: the folder cannot be written.
    """
    path = Path(path)
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        part.write_text(meshcat.StaticHtml(), encoding="utf-8")
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)
    return path
