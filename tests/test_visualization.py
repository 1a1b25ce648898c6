from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import browser
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from kinds import of_kind
from pydrake import geometry
from pydrake.geometry import Meshcat
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, MultibodyPlant
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, DiagramBuilder

import scara_drake as sd
from scara_drake import joints, kinematics, robot
from scara_drake.display.annotations import SceneAnnotations
from scara_drake.display.camera import set_camera
from scara_drake.display.controls import OverviewButton, StopButton
from scara_drake.display.page import publish_recording, save_html, start_recording
from scara_drake.display.scene import add_visualization
from scara_drake.environment import (
    Box,
    Cylinder,
    Environment,
    SineMotion,
    Surface,
    Wall,
    add_surfaces,
)

HOME_STATE = np.r_[joints.HOME, np.zeros(6)]


@pytest.fixture(scope="module")
def meshcat() -> Meshcat:
    return Meshcat()


def desired_pose(offset: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> np.ndarray:
    X_WE = kinematics.forward_kinematics(joints.HOME)
    quaternion = RotationMatrix(X_WE[:3, :3]).ToQuaternion().wxyz()
    return np.r_[X_WE[:3, 3] + offset, quaternion]


def annotations_of(meshcat: Meshcat, points: int = 4) -> tuple[SceneAnnotations, Context]:
    system = SceneAnnotations(meshcat, points)
    context = system.CreateDefaultContext()
    system.GetInputPort("state").FixValue(context, HOME_STATE)
    return system, context


def trail(context: Context) -> tuple[int, np.ndarray]:
    state = context.get_discrete_state(0).value()
    return int(state[0]), state[1:].reshape(-1, 3).copy()


# The LeafSystem on a bare Context.


def test_ports(meshcat: Meshcat) -> None:
    system = SceneAnnotations(meshcat)
    sizes = {
        system.get_input_port(i).get_name(): system.get_input_port(i).size()
        for i in range(system.num_input_ports())
    }
    assert sizes == {
        "state": 12,
        "X_WE_desired": 7,
        "f_env_on_tool_W": 3,
        "device_connected": 1,
        "motion_master": 6,
        "hand_target": 3,
        "query_object": 0,
    }
    assert system.num_output_ports() == 0


def test_the_trail_starts_at_the_tool(meshcat: Meshcat) -> None:
    system, context = annotations_of(meshcat)
    Simulator(system, context).Initialize()
    p = kinematics.forward_kinematics(joints.HOME)[:3, 3]
    np.testing.assert_allclose(trail(context)[1], np.tile(p, (4, 1)), atol=1e-12)


def test_the_trail_keeps_the_last_points_at_16_hertz(meshcat: Meshcat) -> None:
    system, context = annotations_of(meshcat)
    simulator = Simulator(system, context)
    simulator.Initialize()
    expected = []
    for tick in range(1, 8):
        q = joints.HOME + np.array([0.1 * tick, 0, 0, 0, 0, 0])
        system.GetInputPort("state").FixValue(context, np.r_[q, np.zeros(6)])
        simulator.AdvanceTo((tick + 0.5) / 16)
        expected.append(kinematics.forward_kinematics(q)[:3, 3])
    newest, points = trail(context)
    ordered = np.roll(points, -newest - 1, axis=0)
    np.testing.assert_allclose(ordered, expected[-4:], atol=1e-12)


def test_a_cloned_context_and_a_second_run_give_the_same_bits(meshcat: Meshcat) -> None:
    system, context = annotations_of(meshcat)
    fresh = context.Clone()
    Simulator(system, context).AdvanceTo(0.3)
    clone = context.Clone()
    moved = np.r_[joints.HOME + 0.1, np.zeros(6)]
    for one in (context, clone):
        system.GetInputPort("state").FixValue(one, moved)
        simulator = Simulator(system, one)
        simulator.Initialize()
        simulator.AdvanceTo(0.5)
    assert trail(context)[1].tobytes() == trail(clone)[1].tobytes()
    Simulator(system, fresh).AdvanceTo(0.3)
    home = kinematics.forward_kinematics(joints.HOME)[:3, 3]
    np.testing.assert_allclose(trail(fresh)[1], np.tile(home, (4, 1)), atol=1e-12)


def test_everything_is_drawn_again_by_a_second_run(meshcat: Meshcat) -> None:
    system, context = annotations_of(meshcat)
    paths = ["ghost/rod", "force/shaft", "force/head", "trail/0/tube", "trail/3/tube"]
    for _ in range(2):
        meshcat.Delete()
        Simulator(system, context.Clone()).Initialize()
        assert all(meshcat.HasPath(f"annotations/{path}") for path in paths)


def test_a_forced_publish_draws_without_a_run(meshcat: Meshcat) -> None:
    system, context = annotations_of(meshcat)
    meshcat.Delete()
    system.ForcedPublish(context)
    assert meshcat.HasPath("annotations/ghost/rod")


class MeshcatStub:
    """Stands in for a Meshcat and keeps the objects and the last transforms."""

    def __init__(self) -> None:
        self.shapes: dict[str, object] = {}
        self.poses: dict[str, np.ndarray] = {}

    def Delete(self, path: str) -> None:
        assert path == "annotations"

    def SetObject(self, path: str, shape: object, *color: object) -> None:
        self.shapes[path] = shape

    def SetTransform(self, path: str, X: RigidTransform, *time: float) -> None:
        self.poses[path] = X.GetAsMatrix4()

    def SetProperty(self, *arguments: object) -> None:
        pass


@pytest.mark.parametrize("kind", [Wall, Box, Cylinder])
def test_a_surface_that_moves_is_drawn_where_it_is(kind: type[Surface]) -> None:
    moving = kind(name="lid", motion=SineMotion([0, 0, 1.0], amplitude=0.1, frequency=0.7))
    stub = MeshcatStub()
    system = SceneAnnotations(cast(Meshcat, stub), 4, [kind(name="table"), moving])
    context = system.CreateDefaultContext()
    system.GetInputPort("state").FixValue(context, HOME_STATE)
    simulator = Simulator(system, context)
    simulator.AdvanceTo(0.5001)  # a picture was drawn at 0.5 s
    expected = moving.pose().GetAsMatrix4()
    expected[2, 3] += 0.1 * np.sin(2 * np.pi * 0.7 * 0.5)
    np.testing.assert_allclose(stub.poses["annotations/surfaces/lid"], expected, atol=1e-12)
    shape, X_SG = moving.shape()
    assert type(stub.shapes["annotations/surfaces/lid/lid"]) is type(shape)
    np.testing.assert_allclose(stub.poses["annotations/surfaces/lid/lid"], X_SG.GetAsMatrix4())
    assert not any("table" in path for path in stub.shapes)


# The Stop button and the saved page.


def test_the_stop_button_lives_as_long_as_its_context(meshcat: Meshcat) -> None:
    for _ in range(2):
        with StopButton(meshcat) as stop:
            assert "Stop" in meshcat.GetButtonNames()
            assert not stop.pressed()
        assert "Stop" not in meshcat.GetButtonNames()


def test_the_stop_button_takes_over_one_left_behind_and_goes_after_an_error(
    meshcat: Meshcat,
) -> None:
    meshcat.AddButton("Stop")
    with pytest.raises(KeyboardInterrupt), StopButton(meshcat):
        raise KeyboardInterrupt
    assert "Stop" not in meshcat.GetButtonNames()


def test_the_stop_button_without_a_meshcat_is_never_pressed() -> None:
    with StopButton(None) as stop:
        assert not stop.pressed()


class ClickedMeshcat:
    """Stands in for a Meshcat with a button that has been pressed some times."""

    clicks = 0

    def GetButtonClicks(self, name: str) -> int:
        return self.clicks


def test_the_overview_goes_there_and_back() -> None:
    meshcat, shown = ClickedMeshcat(), list[str]()
    button = OverviewButton(
        cast(Meshcat, meshcat), lambda _: shown.append("whole"), lambda _: shown.append("near")
    )
    for clicks in (0, 1, 1, 2, 2, 5):
        meshcat.clicks = clicks
        button.follow()
    assert shown == ["whole", "near", "whole"]
    with OverviewButton(None, lambda _: shown.append("whole"), lambda _: None) as idle:
        idle.follow()
    assert len(shown) == 3


def test_save_html_leaves_only_the_page(meshcat: Meshcat, tmp_path: Path) -> None:
    path = tmp_path / "run.html"
    path.write_text("old")
    assert save_html(meshcat, path) == path
    assert list(tmp_path.iterdir()) == [path]
    assert "<html" in path.read_text()[:2000].lower()


def test_save_html_into_a_missing_folder_says_so(meshcat: Meshcat, tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        save_html(meshcat, tmp_path / "missing" / "run.html")


# Pictures.


@dataclass
class Scene:
    """Half a second in free space, half a second pressed with 200 N, recorded."""

    meshcat: Meshcat
    simulator: Simulator
    system: SceneAnnotations

    def press(self, force: float) -> None:
        context = self.system.GetMyMutableContextFromRoot(self.simulator.get_mutable_context())
        self.system.GetInputPort("f_env_on_tool_W").FixValue(context, [0, force, 0])


@pytest.fixture(scope="module")
def scene() -> Scene:
    environment = Environment([Wall()])
    meshcat = Meshcat()
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 1e-3)
    plant.set_name("plant")
    robot.add_scara(plant)
    add_surfaces(plant, scene_graph, environment)
    plant.Finalize()
    plant.SetDefaultPositions(joints.HOME)
    plant.mutable_gravity_field().set_gravity_vector([0, 0, 0])
    system = add_visualization(builder, plant, scene_graph, meshcat, environment)
    builder.Connect(plant.get_state_output_port(), system.GetInputPort("state"))
    simulator = Simulator(builder.Build())
    scene = Scene(meshcat, simulator, system)
    context = system.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    system.GetInputPort("X_WE_desired").FixValue(context, desired_pose((0.1, 0.0, 0.25)))
    start_recording(meshcat)
    scene.press(0.0)
    simulator.AdvanceTo(0.5)
    scene.press(200.0)
    simulator.AdvanceTo(1.0)
    publish_recording(meshcat)
    return scene


def colors(picture: browser.Picture) -> dict[str, int]:
    return {
        "robot": browser.count_hue(picture, 12, 40),
        "ghost": browser.count_hue(picture, 290, 330),
        "wall": browser.count_hue(picture, 195, 225, saturation=0.18),
        "arrow": browser.count_hue(picture, 355, 5, saturation=0.8),
    }


def assert_shows_all_but_the_arrow(seen: dict[str, int]) -> None:
    assert seen["robot"] > 2000
    assert seen["ghost"] > 500
    assert seen["wall"] > 10000


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    with browser.chromium() as opened:
        yield opened


@pytest.fixture
def saved_page(chromium: Any, scene: Scene, tmp_path: Path) -> Iterator[browser.Page]:
    path = save_html(scene.meshcat, tmp_path / "run.html")
    with browser.open_page(chromium, path.as_uri(), offline=True) as page:
        yield page


@pytest.mark.browser
@browser.needs_chromium
def test_the_saved_page_plays_offline_with_the_arrow_in_contact_only(
    saved_page: browser.Page,
) -> None:
    seen = []
    for time in (0.3, 0.8):
        saved_page.seek(time)
        saved_page.wait(0.3)
        seen.append(colors(saved_page.picture()))
        assert_shows_all_but_the_arrow(seen[-1])
    assert seen[1]["arrow"] > seen[0]["arrow"] + 200
    assert saved_page.failed == []
    assert saved_page.messages == []
    assert len(saved_page.requested) == 1  # the file itself


@pytest.mark.browser
@browser.needs_chromium
def test_the_recorded_trail_stays_behind_the_tool(chromium: Any, tmp_path: Path) -> None:
    # The mast rises at 1 m/s; a piece that drifts to its next place would run ahead of the tool.
    meshcat, period, points = Meshcat(), 1.0 / 32.0, 4
    system, context = annotations_of(meshcat, points)
    start_recording(meshcat)
    simulator = Simulator(system, context)
    simulator.Initialize()
    for tick in range(1, 33):
        q = joints.HOME + np.array([(tick - 0.5) * period, 0, 0, 0, 0, 0])
        system.GetInputPort("state").FixValue(context, np.r_[q, np.zeros(6)])
        simulator.AdvanceTo((tick + 0.5) * period)
    publish_recording(meshcat)
    path = save_html(meshcat, tmp_path / "trail.html")
    with browser.open_page(chromium, path.as_uri(), offline=True) as page:
        for time in (0.25, 0.5, 0.8125):
            page.seek(time)
            z = [page.position(f"drake/annotations/trail/{i}")[2] for i in range(points)]
            height = joints.HOME[0] + time
            assert max(z) <= height + 1e-6
            assert min(z) >= height - (points + 1) / 16
            assert max(z) - min(z) > 2 / 16


@pytest.mark.browser
@browser.needs_chromium
def test_the_live_page_shows_the_robot_the_wall_the_ghost_and_the_force(
    chromium: Any, scene: Scene
) -> None:
    scene.meshcat.DeleteRecording()
    seen = {}
    with browser.open_page(chromium, scene.meshcat.web_url()) as page:
        page.wait(0.5)  # the recording plays once
        for force in (0.0, 0.5, 200.0):
            scene.press(force)
            scene.simulator.AdvanceTo(scene.simulator.get_context().get_time() + 0.1)
            scene.meshcat.Flush()
            page.wait(0.5)
            seen[force] = colors(page.picture())
            assert_shows_all_but_the_arrow(seen[force])
        with StopButton(scene.meshcat) as stop:
            scene.meshcat.Flush()
            page.wait(0.5)
            page.press("Escape")
            page.wait(0.5)
            assert stop.pressed()
    assert seen[200.0]["arrow"] > seen[0.0]["arrow"] + 200
    assert seen[0.5] == seen[0.0]  # below one newton there is no arrow
    assert page.messages == []


class CameraStub:
    """Stands in for a Meshcat and keeps what the camera is told."""

    def SetCameraPose(self, camera: np.ndarray, target: np.ndarray) -> None:
        self.camera, self.target = camera, target

    def SetProperty(self, path: str, name: str, value: object) -> None:
        if name == "zoom":
            self.zoom = value


@settings(deadline=None)
@given(
    point=st.tuples(*[st.floats(-5, 5)] * 3),
    normal=st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda n: np.linalg.norm(n) > 0.1),
    size=st.tuples(*[st.floats(0.1, 5)] * 2),
)
def test_the_camera_shows_the_tool_and_a_wall_wherever_it_stands(point, normal, size) -> None:
    unit = np.array(normal) / np.linalg.norm(normal)
    wall = Wall(point=list(point), normal=unit.tolist(), size=list(size))
    stub = CameraStub()
    set_camera(cast(Meshcat, stub), Environment([wall]))
    back = (stub.camera - stub.target) / np.linalg.norm(stub.camera - stub.target)
    right = np.cross([0, 0, 1], back) / np.linalg.norm(np.cross([0, 0, 1], back))
    up = np.cross(back, right)
    tool = kinematics.forward_kinematics(joints.HOME)[:3, 3]
    half = np.array([*size, 0]) / 2
    corners = [wall.pose() @ (half * [x, y, 0]) for x in (-1, 1) for y in (-1, 1)]
    for p in [tool, *corners]:
        depth = np.dot(stub.camera - p, back)
        assert depth > 0
        edge = depth * np.tan(np.deg2rad(37.5)) / stub.zoom
        assert abs(np.dot(p - stub.camera, up)) < edge
        assert abs(np.dot(p - stub.camera, right)) < 1.5 * edge


@pytest.mark.parametrize("surface", [Box(rpy=[0.3, 0.2, 0.5]), Cylinder(direction=[0.6, 0.0, 0.8])])
def test_the_camera_looks_at_all_corners_of_a_surface(surface: Surface) -> None:
    corners = surface.corners()
    assert corners.shape == (8, 3)
    local = surface.pose().inverse() @ corners.T
    shape, _ = surface.shape()
    if isinstance(surface, Box):
        sides = of_kind(geometry.Box, shape).size().tolist()
    else:
        pipe = of_kind(geometry.Cylinder, shape)
        sides = [2 * pipe.radius(), 2 * pipe.radius(), pipe.length()]
    np.testing.assert_allclose(np.ptp(local, axis=1), sides)
    np.testing.assert_allclose(local.mean(axis=1), 0.0, atol=1e-12)
    stub = CameraStub()
    set_camera(cast(Meshcat, stub), Environment([surface]))
    assert np.isfinite(stub.camera).all()


def test_pictures_wait_while_the_run_is_late_and_then_all_is_in_its_place() -> None:
    stub = MeshcatStub()
    system = SceneAnnotations(cast(Meshcat, stub), points=4)
    context = system.CreateDefaultContext()
    system.GetInputPort("state").FixValue(context, np.zeros(12))
    system.ForcedPublish(context)
    stub.poses.clear()
    system.pace.lateness = 0.1
    system._move(context)
    system._move(context)
    assert not stub.poses
    assert system.pace.pictures_dropped == 2
    system.pace.lateness = 0.0
    system._move(context)
    assert {f"annotations/trail/{index}" for index in range(4)} <= stub.poses.keys()
    stub.poses.clear()
    system._move(context)
    assert system.pace.pictures_dropped == 2
    assert stub.poses


def test_the_annotations_move_the_robot_where_drakes_visualizer_has_put_it() -> None:
    meshcat = Meshcat()
    scenario = sd.load_scenario("joint_sine")
    diagram = sd.make_diagram(scenario, meshcat)
    simulator = Simulator(diagram)
    simulator.Initialize()
    annotations = cast(SceneAnnotations, diagram.GetSubsystemByName("annotations"))
    stub = MeshcatStub()
    annotations._meshcat = cast(Meshcat, stub)
    simulator.AdvanceTo(0.3)
    root = simulator.get_context()
    annotations.ForcedPublish(annotations.GetMyContextFromRoot(root))
    plant = cast(MultibodyPlant, diagram.GetSubsystemByName("plant"))
    in_plant = plant.GetMyContextFromRoot(root)
    names = ("base", *(f"link_{index}" for index in range(1, 7)))
    for name in names:
        path = f"illustration/scara6/{name}"
        assert meshcat.HasPath(f"/drake/{path}")
        body = plant.GetBodyByName(name)
        X_WB = plant.EvalBodyPoseInWorld(in_plant, body).GetAsMatrix4()
        np.testing.assert_array_equal(stub.poses[path], X_WB)
