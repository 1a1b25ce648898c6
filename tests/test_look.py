"""The live scene and the replay of the same moment look alike."""

from __future__ import annotations

from typing import Any, cast

import meshcat
import numpy as np
import pytest
import xarray as xr
from kinds import of_kind
from pydrake import geometry as drake
from pydrake.geometry import Meshcat, MeshcatCone
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator

from scara_drake import joints, kinematics, load_scenario
from scara_drake.display import look
from scara_drake.display.annotations import SceneAnnotations
from scara_drake.display.camera import set_camera
from scara_drake.environment import Box, Cylinder, Environment, Surface, Wall
from scara_drake.environment.scene import drawing
from scara_drake.operator.joint_motion import JointMotion
from scara_drake.recordings.surfaces import read_blocks
from scara_drake.replay.scene import HIDDEN, draw
from scara_drake.scenario import dump_scenario
from scara_drake.vectors import pose_vector

Q_DESIRED = joints.HOME + np.array([0.1, 0.2, -0.1, 0.3, 0.2, -0.4])
SURFACES: list[Surface] = [
    Wall(name="wall"), Box(name="table", rpy=[0.1, 0.2, 0.3]), Cylinder(name="pipe"),
]  # fmt: skip
DEVICE_AT, HAND_AT = [0.01, -0.02, 0.03], [0.0, -0.04, 0.0]  # [m], in the workspace
FORCES = [[0.0, 0.3, 0.4], [0.0, 0.0, 5.0], [0.0, 120.0, 160.0], [-3e3, 0.0, 0.0]]


class Stub:
    """Stands in for a Drake Meshcat and keeps what it is told."""

    def __init__(self) -> None:
        self.objects: dict[str, tuple[Any, Any]] = {}
        self.poses: dict[str, np.ndarray] = {}
        self.properties: dict[tuple[str, str], Any] = {}

    def Delete(self, path: str) -> None:
        pass

    def SetObject(self, path: str, shape: Any, color: Any) -> None:
        self.objects[path] = shape, color

    def SetTransform(self, path: str, X: RigidTransform, *time: float) -> None:
        self.poses[path] = X.GetAsMatrix4()

    def SetProperty(self, path: str, name: str, value: Any, *time: float) -> None:
        self.properties[path, name] = value

    def SetCameraPose(self, eye: np.ndarray, target: np.ndarray) -> None:
        self.view = np.subtract(eye, target)


class Window:
    """Stands for meshcat-python's window and keeps the commands that it is sent."""

    def __init__(self) -> None:
        self.sent: dict[tuple[str, ...], dict[str, Any]] = {}

    def send(self, command: Any) -> None:
        data = command.lower()
        key = (data["type"], data["path"], data.get("property", ""))
        self.sent[key] = data

    def pose(self, path: str) -> np.ndarray:
        return np.reshape(self.sent["set_transform", f"/meshcat/{path}", ""]["matrix"], (4, 4)).T

    def object(self, path: str) -> tuple[dict[str, Any], list[float]]:
        """The geometry and the colour, red, green, blue and opacity."""
        data = self.sent["set_object", f"/meshcat/{path}", ""]["object"]
        (geometry,), (material,) = data["geometries"], data["materials"]
        rgb = [material["color"] >> shift & 255 for shift in (16, 8, 0)]
        return geometry, [*np.divide(rgb, 255), material["opacity"]]


def live(force: list[float]) -> Stub:
    stub = Stub()
    system = SceneAnnotations(cast(Meshcat, stub), 4, SURFACES)
    context = system.CreateDefaultContext()
    system.GetInputPort("state").FixValue(context, np.r_[joints.HOME, np.zeros(6)])
    system.GetInputPort("X_WE_desired").FixValue(context, pose_vector(Q_DESIRED))
    system.GetInputPort("f_env_on_tool_W").FixValue(context, force)
    system.GetInputPort("motion_master").FixValue(context, [*DEVICE_AT, 0.0, 0.0, 0.0])
    system.GetInputPort("hand_target").FixValue(context, HAND_AT)
    Simulator(system, context).Initialize()
    return stub


def replayed(force: list[float]) -> Window:
    scenario = load_scenario("teleoperation")
    scenario.environment = Environment(list(SURFACES))
    desired = kinematics.forward_kinematics(Q_DESIRED)[:3, 3]
    data = xr.Dataset(
        {
            "q_measured": (("time", "joint"), [joints.HOME] * 2),
            "q_desired": (("time", "joint"), [Q_DESIRED] * 2),
            "p_WE_desired": (("time", "axis"), [desired] * 2),
            "f_env_on_tool_W": (("time", "axis"), [force] * 2),
            "x_master": (("time", "axis"), [DEVICE_AT] * 2),
            "hand_target": (("time", "axis"), [HAND_AT] * 2),
        },
        coords={"time": [0.0, 1.0], "joint": list(joints.JOINT_NAMES)},
    )
    window = Window()
    draw(meshcat.Visualizer(window=window), data, read_blocks(dump_scenario(scenario)), 1.0)
    return window


def live_arrow(stub: Stub) -> tuple[bool, np.ndarray, np.ndarray, np.ndarray]:
    """Whether it is seen; where its tail, the foot of its head and its tip are in W."""
    root = "annotations/force"
    if not stub.properties[root, "visible"]:
        return False, *np.zeros((3, 3))
    shaft, _ = stub.objects[f"{root}/shaft"]
    head, _ = stub.objects[f"{root}/head"]
    assert isinstance(head, MeshcatCone)
    middle = stub.properties[f"{root}/shaft", "position"]
    half = stub.properties[f"{root}/shaft", "scale"][2] * shaft.length() / 2
    X_WF, X_FH = stub.poses[root], stub.poses[f"{root}/head"]
    tail = X_WF @ [*middle[:2], middle[2] - half, 1.0]
    tip, foot = X_WF @ X_FH @ [0, 0, 0, 1.0], X_WF @ X_FH @ [0, 0, head.height(), 1.0]
    return True, tail[:3], foot[:3], tip[:3]


def replayed_arrow(window: Window) -> tuple[bool, np.ndarray, np.ndarray, np.ndarray]:
    X_WF = window.pose("force")
    if np.linalg.norm(X_WF[:3, 2]) < 2 * HIDDEN:
        return False, *np.zeros((3, 3))
    X_WS = X_WF @ window.pose("force/shaft") @ window.pose("force/shaft/solid")
    X_WH = X_WF @ window.pose("force/head/solid")
    # Meshcat's cylinders lie along y, the top of a cone is its tip.
    shaft, head = (window.object(f"force/{part}/solid")[0]["height"] for part in ("shaft", "head"))
    tail = X_WS @ [0, -shaft / 2, 0, 1.0]
    foot, tip = X_WH @ [0, -head / 2, 0, 1.0], X_WH @ [0, head / 2, 0, 1.0]
    return True, tail[:3], foot[:3], tip[:3]


@pytest.mark.parametrize("force", FORCES)
def test_the_arrow_of_a_force_is_the_same(force: list[float]) -> None:
    here, there = live_arrow(live(force)), replayed_arrow(replayed(force))
    assert here[0] == there[0] == (np.linalg.norm(force) >= 1.0)
    np.testing.assert_allclose(here[1:], there[1:], atol=1e-9)
    if here[0]:
        _, tail, _, tip = here
        tool = kinematics.forward_kinematics(joints.HOME)[:3, 3]
        np.testing.assert_allclose(tip, tool, atol=1e-9)
        along = (tip - tail) / np.linalg.norm(tip - tail)
        np.testing.assert_allclose(along, np.divide(force, np.linalg.norm(force)), atol=1e-9)


def test_two_hundred_newtons_are_an_arrow_of_64_centimetres() -> None:
    for _, tail, _, tip in (live_arrow(live(FORCES[2])), replayed_arrow(replayed(FORCES[2]))):
        assert np.linalg.norm(tip - tail) == pytest.approx(0.64)


def test_the_colours_are_the_same() -> None:
    stub, window = live(FORCES[2]), replayed(FORCES[2])
    pairs = {
        **{f"ghost/{part}": f"desired/{part}" for part in ("rod", "tip", "axis_0", "axis_1")},
        **{f"force/{part}": f"force/{part}/solid" for part in ("shaft", "head")},
        **{f"board/{part}": f"board/{part}/solid" for part in ("device", "hand")},
    }
    for here, there in pairs.items():
        _, color = stub.objects[f"annotations/{here}"]
        np.testing.assert_allclose(window.object(there)[1], color.rgba, atol=0.5 / 255)
    _, trail = stub.objects["annotations/trail/0/tube"]
    line = window.sent["set_object", "/meshcat/trail/0/line", ""]["object"]["materials"][0]
    rgb = [line["color"] >> shift & 255 for shift in (16, 8, 0)]
    np.testing.assert_allclose(np.divide(rgb, 255), trail.rgba[:3], atol=0.5 / 255)


def test_the_ghost_is_in_the_same_place() -> None:
    stub, window = live(FORCES[0]), replayed(FORCES[0])
    X_WE = kinematics.forward_kinematics(Q_DESIRED)
    np.testing.assert_allclose(stub.poses["annotations/ghost"], X_WE, atol=1e-9)
    np.testing.assert_allclose(window.pose("desired"), X_WE, atol=1e-9)
    for part in ("rod", "tip", "axis_0", "axis_1", "axis_2"):
        here, there = stub.poses[f"annotations/ghost/{part}"], window.pose(f"desired/{part}")
        np.testing.assert_allclose(here[:3, 3], there[:3, 3], atol=1e-12)
        if part != "tip":  # z of Drake's cylinders is y of meshcat's
            np.testing.assert_allclose(here[:3, 2], there[:3, 1], atol=1e-12)


def test_the_device_and_the_hand_are_in_the_same_place() -> None:
    stub, window = live(FORCES[0]), replayed(FORCES[0])
    assert stub.properties["annotations/board", "visible"]
    for part, place in (("device", DEVICE_AT), ("hand", HAND_AT)):
        here = stub.poses["annotations/board"] @ stub.poses[f"annotations/board/{part}"]
        expected = look.BOARD_PLACE + look.BOARD_SCALE * np.array(place)
        np.testing.assert_allclose(here[:3, 3], expected, atol=1e-12)
        np.testing.assert_allclose(window.pose(f"board/{part}")[:3, 3], expected, atol=1e-12)


def test_the_real_tool_is_seen_where_the_ghost_is() -> None:
    """Of each visual of the tool's link, the ghost covers less than a third of the length."""
    along = [part for part in look.GHOST if part.shape == "cylinder" and part.size[0] > 0.045]
    covered = sum(part.size[1] for part in along)
    assert covered < 0.62 / 3


def test_the_overview_has_the_whole_crane_in_the_picture() -> None:
    eye, target = look.camera(look.WHOLE)
    back = (eye - target) / np.linalg.norm(eye - target)
    up = np.cross(back, np.cross([0.0, 0.0, 1.0], back) / np.hypot(back[0], back[1]))
    offsets = np.array([[0.0, 0.0, 2.5], [0.0, 0.0, 14.37], [4.8, 2.0, 0.14]]) - eye
    half = np.tan(np.deg2rad(75.0 / 2)) / look.ZOOM
    assert (np.abs(offsets @ up) < half * -(offsets @ back)).all()


def test_the_surfaces_are_the_same() -> None:
    window = replayed(FORCES[0])
    for index, surface in enumerate(SURFACES):
        for name, shape, X_SG, color in drawing(surface):
            part = "solid" if name == surface.name else name.removeprefix(f"{surface.name}_")
            path = f"surfaces/{index}/{part}"
            geometry, replayed_color = window.object(path)
            np.testing.assert_allclose(replayed_color, color, atol=0.5 / 255)
            X_WG = (surface.pose() @ X_SG).GetAsMatrix4()
            np.testing.assert_allclose(window.pose(path)[:3, 3], X_WG[:3, 3], atol=1e-12)
            if geometry["type"] == "BoxGeometry":
                size = [geometry[side] for side in ("width", "height", "depth")]
                np.testing.assert_allclose(size, of_kind(drake.Box, shape).size())
                np.testing.assert_allclose(window.pose(path), X_WG, atol=1e-12)
            else:
                pipe = of_kind(drake.Cylinder, shape)
                assert geometry["height"] == pipe.length()
                assert geometry["radiusTop"] == geometry["radiusBottom"] == pipe.radius()


def test_the_camera_is_the_same() -> None:
    stub, window = Stub(), replayed(FORCES[0])
    set_camera(cast(Meshcat, stub), Environment(list(SURFACES)))
    camera = "/Cameras/default/rotated/<object>"
    x, y, z = stub.view
    # y is up in the browser.
    position = window.sent["set_property", camera, "position"]["value"]
    np.testing.assert_allclose(position, [x, z, -y], atol=1e-9)
    assert (
        window.sent["set_property", camera, "zoom"]["value"]
        == stub.properties["/Cameras/default/rotated/<object>", "zoom"]
    )
    for name in ("top_color", "bottom_color"):
        seen = window.sent["set_property", "/Background", name]["value"]
        assert seen == stub.properties["/Background/<object>", name]


def test_a_motion_that_is_known_beforehand_stays_in_the_picture():
    motion = of_kind(JointMotion, load_scenario("joint_sine").operator)
    places = motion.places(30.0)
    eye, target = look.camera(places)
    back = (eye - target) / np.linalg.norm(eye - target)
    right = np.cross([0.0, 0.0, 1.0], back) / np.hypot(back[0], back[1])
    offsets = places - eye
    depth = -offsets @ back
    half = np.tan(np.deg2rad(75.0 / 2)) / look.ZOOM  # of the picture's height, at one metre
    assert (depth > 0.0).all()
    assert (np.abs(offsets @ np.cross(back, right)) < half * depth).all()
    assert (np.abs(offsets @ right) < 1.5 * half * depth).all()
