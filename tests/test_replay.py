from __future__ import annotations

import re
import signal
import socket
import subprocess
import sys
import time
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import browser
import meshcat
import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from meshcat.path import Path as ScenePath
from pydrake.geometry import Box, Cylinder, Role, Sphere
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from scara_drake import environment as surroundings
from scara_drake import load_scenario, robot, save_recording, simulate
from scara_drake.common.resources import resource
from scara_drake.common.urdf import link_poses, read_visuals
from scara_drake.environment import Environment, Wall
from scara_drake.joints import HOME, JOINT_NAMES, LOWER, UPPER
from scara_drake.kinematics import forward_kinematics
from scara_drake.recordings.surfaces import read_blocks
from scara_drake.replay import player as replay
from scara_drake.replay.page import animation_of
from scara_drake.replay.recording import load
from scara_drake.replay.scene import HIDDEN, draw
from scara_drake.scenario import dump_scenario

URDF = ET.parse(resource("models", "scara6.urdf")).getroot()
FORCE = np.array([0.0, 120.0, 160.0])  # 200 N


def poses(q: Any) -> dict[str, np.ndarray]:
    return link_poses(URDF, dict(zip(JOINT_NAMES, np.moveaxis(q, -1, 0), strict=True)))


@pytest.fixture(scope="module")
def dataset() -> xr.Dataset:
    """A second at 1 kHz: the joints move, the force comes at half time, the target is late."""
    recording = simulate(load_scenario("teleoperation", {"duration": 1.0}))
    along = np.linspace(0.0, 1.0, recording.time.size)[:, None]
    moved = HOME + along * np.array([0.3, -0.4, 0.3, 0.5, -0.6, 0.7])
    recording["q_measured"] = (("time", "joint"), moved)
    recording["f_env_on_tool_W"] = (("time", "axis"), np.where(along > 0.5, FORCE, 0.0))
    desired = np.where(along < 0.2, np.nan, np.array([0.8, -0.7, 3.0]) + along)
    recording["p_WE_desired"] = (("time", "axis"), desired)
    return recording


@pytest.fixture(scope="module")
def file(dataset: xr.Dataset, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("replay") / "run.nc"
    save_recording(dataset, path)
    return path


class Window:
    """Stands for meshcat's window: keeps the commands that it is sent."""

    def __init__(self) -> None:
        self.sent: dict[tuple[str, str], dict[str, Any]] = {}

    def send(self, command: Any) -> None:
        data = command.lower()
        self.sent[data["type"], data["path"]] = data


def drawn(file: Path, step: float) -> tuple[Window, dict[str, np.ndarray]]:
    window = Window()
    viewer = meshcat.Visualizer(window=window)
    return window, draw(viewer, *load(file), step)


# The URDF reader, against Drake's.


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=50, deadline=None)
def test_the_tool_is_where_the_kinematics_have_it(seed: int) -> None:
    q = np.random.default_rng(seed).uniform(LOWER, UPPER, (4, 6))
    np.testing.assert_allclose(poses(q)["tool"], forward_kinematics(q), rtol=0, atol=1e-12)


@pytest.fixture(scope="module")
def drake() -> Any:
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
    robot.add_scara(plant)
    plant.Finalize()
    return plant, scene_graph.model_inspector()


def test_every_link_is_where_drake_has_it(drake: Any) -> None:
    plant, _ = drake
    context = plant.CreateDefaultContext()
    rng = np.random.default_rng(1)
    assert len(poses(HOME)) == plant.num_bodies()
    for q in rng.uniform(LOWER, UPPER, (20, 6)):
        plant.SetPositions(context, q)
        for link, X_WL in poses(q).items():
            expected = plant.EvalBodyPoseInWorld(context, plant.GetBodyByName(link))
            np.testing.assert_allclose(X_WL, expected.GetAsMatrix4(), rtol=0, atol=1e-12)


def test_every_visual_is_what_drake_reads(drake: Any) -> None:
    plant, inspector = drake
    visuals = {(v.link, v.name): v for v in read_visuals(URDF)}
    count = 0
    for body in map(plant.get_body, plant.GetBodyIndices(robot_instance(plant))):
        for identity in plant.GetVisualGeometriesForBody(body):
            count += 1
            name = inspector.GetName(identity).split("::")[-1]
            visual, shape = visuals[body.name(), name], inspector.GetShape(identity)
            if isinstance(shape, Box):
                expected = ("box", list(shape.size()))
            elif isinstance(shape, Cylinder):
                expected = ("cylinder", [shape.radius(), shape.length()])
            else:
                assert isinstance(shape, Sphere)
                expected = ("sphere", [shape.radius()])
            assert (visual.shape, visual.size) == expected
            X = inspector.GetPoseInFrame(identity).GetAsMatrix4()
            np.testing.assert_allclose(visual.X_LV, X, rtol=0, atol=1e-12)
            color = inspector.GetProperties(identity, Role.kIllustration).GetProperty(
                "phong", "diffuse"
            )
            np.testing.assert_allclose(visual.color, color.rgba, atol=1e-12)
    assert count == len(visuals) > 50


def robot_instance(plant: Any) -> Any:
    return plant.GetModelInstanceByName("scara6")


def link(visual: str, materials: str = "") -> ET.Element:
    return ET.fromstring(
        f"<robot>{materials}<link name='l'><visual>{visual}</visual></link></robot>"
    )


BALL = "<geometry><sphere radius='0.2'/></geometry>"
RED = "<material name='red'><color rgba='1 0 0 0.5'/></material>"


def test_a_colour_may_be_given_in_place_or_by_name() -> None:
    for urdf in (link(BALL + RED), link(BALL + "<material name='red'/>", RED)):
        (visual,) = read_visuals(urdf)
        assert visual[:4] == ("l", "visual_0", "sphere", [0.2])
        assert visual.color == (1.0, 0.0, 0.0, 0.5)


@pytest.mark.parametrize(
    ("visual", "message"),
    [
        (f"<geometry><mesh filename='a.obj'/></geometry>{RED}", "l/visual_0: 'mesh', allowed box"),
        (f"<geometry/>{RED}", "l/visual_0: 'nothing', allowed box"),
        (BALL, "l/visual_0: no colour"),
        (f"{BALL}<material name='blue'/>", "l/visual_0: no colour"),
    ],
)
def test_what_the_reader_does_not_know_is_named(visual: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        read_visuals(link(visual))


def test_a_joint_of_another_kind_is_named() -> None:
    urdf = ET.fromstring(
        "<robot><link name='l'/><joint name='j' type='floating'>"
        "<parent link='world'/><child link='l'/></joint></robot>"
    )
    with pytest.raises(ValueError, match="j: 'floating', allowed fixed"):
        link_poses(urdf, {"j": np.zeros(2)})


# The walls.


def test_a_wall_is_where_the_environment_has_it() -> None:
    normals = np.random.default_rng(2).normal(size=(12, 3))
    normals = np.vstack([normals, np.eye(3), -np.eye(3)])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    walls = [Wall(name=f"{i}", normal=n.tolist(), thickness=0.2) for i, n in enumerate(normals)]
    scenario = load_scenario("teleoperation")
    scenario.environment = Environment([*walls])
    read = read_blocks(dump_scenario(scenario))
    for (size, X_WB, _), wall in zip(read, walls, strict=True):
        X = wall.pose().GetAsMatrix4()
        X[:3, 3] -= wall.thickness / 2 * X[:3, 2]
        np.testing.assert_allclose(X_WB, X, rtol=0, atol=1e-12)
        assert size == [*wall.size, wall.thickness]


def test_a_box_and_a_pipe_are_where_the_environment_has_them() -> None:
    box = surroundings.Box(rpy=[0.3, -0.4, 0.5], size=[0.5, 0.6, 0.7])
    pipe = surroundings.Cylinder(direction=[0.6, 0.0, -0.8], radius=0.2, length=1.1)
    scenario = load_scenario("teleoperation")
    scenario.environment = Environment([box, pipe])
    read = read_blocks(dump_scenario(scenario))
    for (_, X_WB, _), surface in zip(read, (box, pipe), strict=True):
        np.testing.assert_allclose(X_WB, surface.pose().GetAsMatrix4(), rtol=0, atol=1e-12)
    assert [block.size for block in read] == [[0.5, 0.6, 0.7], [0.2, 1.1]]


def test_tags_of_a_scenario_are_passed_over() -> None:
    text = resource("diagrams", "teleoperation.yaml").read_text()
    assert "!Joystick" in text
    text = text.replace(
        "normal: [0.0,", "size: [2, 1e-05]\n      thickness: 1\n      normal: [0.0,"
    )
    ((size, X_WB, _),) = read_blocks(text)
    assert size == [2.0, 1e-5, 1.0]
    np.testing.assert_allclose(X_WB[:3, 3], [0.8, -1.55, 3.0], atol=1e-12)


# What is drawn.


def test_what_moves_follows_the_recording(file: Path, dataset: xr.Dataset) -> None:
    _, moving = drawn(file, 0.1)
    samples = dataset.isel(time=slice(None, None, 100))
    X_WE = forward_kinematics(samples.q_measured.values)
    np.testing.assert_allclose(moving["robot/tool"], X_WE, atol=1e-12)
    scale = {name: np.cbrt(np.linalg.det(X[:, :3, :3])) for name, X in moving.items()}

    known = np.isfinite(samples.p_WE_desired.values[:, 0])
    desired = samples.p_WE_desired.values[known]
    np.testing.assert_allclose(moving["desired"][known][:, :3, 3], desired, atol=1e-12)
    np.testing.assert_allclose(scale["desired"], np.where(known, 1.0, HIDDEN))

    pushed = samples.f_env_on_tool_W.values.any(axis=1)
    np.testing.assert_allclose(scale["force"], np.where(pushed, 1.0, HIDDEN))
    np.testing.assert_allclose(moving["force"][:, :3, 3], X_WE[:, :3, 3], atol=1e-12)
    np.testing.assert_allclose(moving["force"][pushed][0, :3, 2], FORCE / 200.0, atol=1e-12)
    np.testing.assert_allclose(moving["force/shaft"][pushed][:, 2, 2], 0.5)  # [m], of 200 N

    pieces = [name for name in moving if name.startswith("trail/")]
    assert len(pieces) == 10
    for frame in range(11):  # one more each frame
        assert sum(scale[name][frame] == pytest.approx(1.0) for name in pieces) == frame


def test_the_scene_has_every_shape_in_its_colour(file: Path) -> None:
    window, moving = drawn(file, 0.5)
    objects = {path for kind, path in window.sent if kind == "set_object"}
    for visual in read_visuals(URDF):
        data = window.sent["set_object", f"/meshcat/robot/{visual.link}/{visual.name}"]["object"]
        rgb = [data["materials"][0]["color"] >> shift & 255 for shift in (16, 8, 0)]
        np.testing.assert_allclose(rgb, 255 * np.array(visual.color[:3]), atol=0.5)
    shown = ("surfaces/0/solid", "desired/tip", "force/head/solid")
    assert {f"/meshcat/{path}" for path in shown} <= objects
    for path, X in moving.items():  # all are where the recording starts
        matrix = window.sent["set_transform", f"/meshcat/{path}"]["matrix"]
        np.testing.assert_allclose(np.reshape(matrix, (4, 4)).T, X[0])


def test_a_recording_of_one_sample_is_a_still(dataset: xr.Dataset, tmp_path: Path) -> None:
    save_recording(dataset.isel(time=slice(0, 1)), tmp_path / "one.nc")
    _, moving = drawn(tmp_path / "one.nc", 0.1)
    assert {len(X) for X in moving.values()} == {1}
    assert not animation_of(meshcat.Visualizer(window=Window()), moving, 30).clips


def test_the_animation_keeps_every_frame_that_matters(file: Path) -> None:
    _, moving = drawn(file, 0.02)
    viewer = meshcat.Visualizer(window=Window())
    clips = animation_of(viewer, moving, 50).clips
    assert ScenePath(("meshcat", "robot", "base")) not in clips  # it does not move
    assert list(clips[viewer["robot/link_1"].path].tracks) == ["position"]  # it does not turn
    for path, X in moving.items():
        tracks = clips[viewer[path].path].tracks if viewer[path].path in clips else {}
        for name, values in (("position", X[:, :3, 3]), ("scale", X[:, :3, 0])):
            if name in tracks:
                whole = values if name == "position" else np.linalg.norm(values, axis=1)[:, None]
                keys = np.array(tracks[name].values)
                for axis in range(whole.shape[1]):
                    line = np.interp(np.arange(len(X)), tracks[name].frames, keys[:, axis])
                    np.testing.assert_allclose(line, whole[:, axis], atol=1e-9)


# Playing.


def test_it_plays_once_in_time_and_ends_its_server(
    file: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    opened: list[Any] = []
    start_server = replay.server.start

    def started(*address: Any) -> Any:
        process, url = start_server(*address)
        opened.append((process, time.monotonic()))
        return process, url

    monkeypatch.setattr(replay.server, "start", started)
    replay.replay(file, speed=0.5, fps=20)
    ((process, start),) = opened
    assert 2.0 <= time.monotonic() - start < 6.0  # a second, at half speed
    assert process.poll() is not None
    out = capsys.readouterr().out
    assert re.fullmatch(r"Scene: http://127\.0\.0\.1:\d+/static/\n", out)


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="this system has no /proc")
def test_a_signal_ends_the_server_too(file: Path) -> None:
    without_drake = (  # it is quicker to start
        "import runpy, sys; sys.modules['pydrake'] = None; "
        "runpy.run_module('scara_drake.replay', run_name='__main__', alter_sys=True)"
    )
    command = [sys.executable, "-c", without_drake, str(file), "--speed", "0.01"]
    pipes: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    signals = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGKILL)
    runs = {sent: subprocess.Popen(command, **pipes) for sent in signals}
    for sent, process in runs.items():
        assert process.stdout is not None
        port = int(process.stdout.readline().split(":")[-1].split("/")[0])
        with socket.create_connection(("127.0.0.1", port), timeout=5):
            pass
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
        assert children
        process.send_signal(sent)
        _, errors = process.communicate(timeout=20)
        assert process.returncode == (-sent if sent == signal.SIGKILL else 128 + sent)
        assert errors == ""
        deadline = time.monotonic() + 20
        while any(is_alive(child) for child in children):  # after a kill it sees it by itself
            assert time.monotonic() < deadline
            time.sleep(0.05)


def is_alive(process: str) -> bool:
    stat = Path(f"/proc/{process}/stat")
    try:
        return stat.read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def test_the_scene_is_on_the_port_that_was_asked_for_and_on_this_machine_alone(
    file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    process, _ = replay.server.start("127.0.0.1", port)
    try:
        with socket.create_connection(("127.0.0.1", port), timeout=5):
            pass
        with pytest.raises(OSError):  # noqa: PT011 - refused, whatever the system's words
            socket.create_connection(("127.0.0.2", port), timeout=5)
        assert replay.main([str(file), "--port", str(port)]) == 2
        assert "cannot listen on 127.0.0.1" in capsys.readouterr().err
    finally:
        process.kill()
        process.communicate()
    assert replay.main([str(file), "--port", str(port), "--speed", "10"]) == 0
    assert capsys.readouterr().out == f"Scene: http://127.0.0.1:{port}/static/\n"
    assert replay.main([str(file), "--port", "70000"]) == 2


@pytest.fixture(scope="module")
def page(file: Path) -> Path:
    path = file.with_suffix(".html")
    assert replay.main([str(file), "--html", str(path), "--speed", "0.5"]) == 0
    return path


def test_the_page_holds_the_viewer_and_the_commands(page: Path, file: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert "new MeshCat.Viewer" in text
    assert len(text) > 800_000
    assert not re.search(r"""(src|href)=["']""", text.split("new MeshCat.Viewer")[1])
    assert text.count("viewer.handle_command_bytearray") > 2 * len(read_visuals(URDF))


@browser.needs_chromium
@pytest.mark.browser
def test_the_page_plays_without_network(page: Path, dataset: xr.Dataset) -> None:
    with (
        browser.chromium() as chromium,
        browser.open_page(chromium, page.as_uri(), offline=True) as opened,
    ):
        assert opened.failed == opened.messages == []
        orange = 0
        for seconds in (0.4, 1.0, 2.0):  # at half speed
            opened.seek(seconds)
            q = dataset.q_measured.sel(time=seconds / 2, method="nearest").values
            for link, X_WL in poses(q).items():
                position = opened.position(f"meshcat/robot/{link}")
                np.testing.assert_allclose(position, X_WL[:3, 3], atol=2e-3)
            picture = opened.picture()
            orange = browser.count_hue(picture, 15, 35)
            assert orange > 1000
        assert browser.count_hue(picture, 305, 330) > 20  # the desired tool
        assert browser.count_hue(picture, 350, 5, 0.7) > 20  # the force


# Bad input.


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("none.nc", None, "allowed a file that exists"),
        ("text.nc", b"not a recording", "allowed NetCDF written by a run"),
        ("empty.nc", b"", "allowed NetCDF written by a run"),
    ],
)
def test_a_wrong_file_is_one_line(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    name: str,
    content: bytes | None,
    message: str,
) -> None:
    if content is not None:
        (tmp_path / name).write_bytes(content)
    assert replay.main([str(tmp_path / name)]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err == f"replay: recording: '{tmp_path / name}', {message}\n"


def test_another_dataset_is_no_recording(dataset: xr.Dataset, tmp_path: Path) -> None:
    dataset = dataset[["q_measured", "q_desired", "p_WE_desired", "f_env_on_tool_W"]]
    dataset = dataset.isel(time=slice(5))
    others = [
        xr.Dataset({"x": ("time", [1.0])}),
        dataset.drop_vars("q_measured"),
        dataset.drop_vars("joint"),
        dataset.isel(joint=slice(3)),
        dataset.isel(time=slice(0)),
        dataset.assign(q_measured=dataset.q_measured * np.nan),
        dataset.assign_attrs(scenario="environment: ["),
        dataset.assign_attrs(scenario="a text"),
        dataset.assign_attrs(scenario="environment: {surfaces: [{point: [1, 2]}]}"),
    ]
    for index, other in enumerate(others):
        path = tmp_path / f"{index}.nc"
        other.to_netcdf(path, engine="netcdf4")
        with pytest.raises(ValueError, match="allowed NetCDF written by a run"):
            load(path)


def test_bad_numbers_and_a_bad_page_are_refused(
    file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for speed in ("0", "-1", "nan", "inf"):
        assert replay.main([str(file), f"--speed={speed}"]) == 2
        assert capsys.readouterr().err.endswith("allowed more than 0\n")
    assert replay.main([str(file), "--html", str(file)]) == 2
    assert capsys.readouterr().err.endswith("allowed a file that ends in .html\n")
    assert replay.main([str(file), "--html", str(file / "page.html")]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1


def test_it_needs_no_drake(file: Path) -> None:
    program = f"""
import sys
sys.modules["pydrake"] = None
import numpy as np
from scara_drake.replay.recording import load
from scara_drake.replay.scene import draw
import meshcat

class Window:
    sent = 0
    def send(self, command):
        Window.sent += 1

poses = draw(meshcat.Visualizer(window=Window()), *load({str(file)!r}), 0.1)
assert len(poses["robot/tool"]) == 11 and Window.sent > 100
assert not [name for name in sys.modules if name.startswith("pydrake.")]
"""
    result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
