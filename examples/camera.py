"""A camera that looks at the tool, beside the Diagram in a builder of one's own.

The Diagram exports `query_object`, from which Drake's RgbdSensor renders colours, depths and
labels, without a display; on Debian it needs libegl1 and libgl1.

    python examples/camera.py [FOLDER]   # keeps the pictures of start and end there
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from pydrake.geometry import (
    ClippingRange,
    ColorRenderCamera,
    DepthRange,
    DepthRenderCamera,
    MakeRenderEngineVtk,
    RenderCameraCore,
    RenderEngineVtkParams,
    SceneGraph,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.sensors import CameraInfo, RgbdSensor

import scara_drake as sd

WIDTH, HEIGHT, VIEW = 480, 360, np.deg2rad(50.0)
EYE, TARGET = np.array([2.4, 1.6, 4.0]), np.array([0.5, -0.5, 3.1])  # [m]
UP = np.array([0.0, 0.0, 1.0])


def looking(eye: np.ndarray, target: np.ndarray) -> RigidTransform:
    """Pose of a camera: its z towards the target, its y down in the picture."""
    z = (target - eye) / np.linalg.norm(target - eye)
    x = np.cross(z, UP) / np.linalg.norm(np.cross(z, UP))
    return RigidTransform(RotationMatrix(np.column_stack([x, np.cross(z, x), z])), eye)


def camera(scene_graph: SceneGraph) -> RgbdSensor:
    """The sensor, still in the world, and what renders for it."""
    scene_graph.AddRenderer("vtk", MakeRenderEngineVtk(RenderEngineVtkParams()))
    lens = CameraInfo(WIDTH, HEIGHT, VIEW)
    core = RenderCameraCore("vtk", lens, ClippingRange(0.05, 30.0), RigidTransform())
    return RgbdSensor(
        SceneGraph.world_frame_id(),
        looking(EYE, TARGET),
        ColorRenderCamera(core),
        DepthRenderCamera(core, DepthRange(0.1, 20.0)),
    )


builder = DiagramBuilder()
robot = builder.AddNamedSystem("robot", sd.make_diagram(sd.load_scenario("teleoperation")))
scene_graph, plant = (robot.GetSubsystemByName(name) for name in ("scene_graph", "plant"))
assert isinstance(scene_graph, SceneGraph)
assert isinstance(plant, MultibodyPlant)
sensor = builder.AddNamedSystem("camera", camera(scene_graph))
builder.Connect(robot.GetOutputPort("query_object"), sensor.query_object_input_port())
diagram = builder.Build()

simulator = Simulator(diagram)
seen = sensor.GetMyContextFromRoot(simulator.get_context())
pictures, labels, postures = [], [], []
for time in (0.0, 5.0):
    simulator.AdvanceTo(time)
    inside = plant.GetMyContextFromRoot(simulator.get_context())
    postures.append(plant.GetPositions(inside)[:6].copy())
    pictures.append(sensor.color_image_output_port().Eval(seen).data.copy())
    labels.append(sensor.label_image_output_port().Eval(seen).data[..., 0].copy())
    depths = sensor.depth_image_32F_output_port().Eval(seen).data[..., 0]
    tool = int(plant.GetBodyByName("link_6").index())
    rows, columns = np.nonzero(labels[-1] == tool)
    distance = float(np.median(depths[rows, columns]))
    print(f"t = {time} s: the last link has {rows.size} pixels, {distance:.3f} m away")
links = [int(plant.GetBodyByName(f"link_{i}").index()) for i in range(1, 7)]
moved = np.isin(labels[0], links) != np.isin(labels[1], links)
print(f"pixels that the arm has left or come to: {np.count_nonzero(moved)}")
if len(sys.argv) > 1:
    for name, picture in zip(("start", "end"), pictures, strict=True):
        plt.imsave(Path(sys.argv[1]) / f"camera_{name}.png", picture)
