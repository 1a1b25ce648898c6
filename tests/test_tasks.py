"""The training tasks as data, the scenes that have them, and their pictures."""

from __future__ import annotations

from typing import cast

import numpy as np
import pytest
from pydrake.geometry import Meshcat

from scara_drake import load_scenario, make_diagram
from scara_drake.common.shipped import training_names
from scara_drake.display.task import SEGMENTS, TaskAnnotations
from scara_drake.environment import PipeCut, surface_distance, surface_row
from scara_drake.scenario import dump_scenario
from scara_drake.tasks import CutPipe, ReachInto, TouchPoints, TraceLine

KINDS = {
    "touch_points": TouchPoints,
    "trace_line": TraceLine,
    "reach_into_box": ReachInto,
    "cut_pipe": CutPipe,
}


def test_each_task_has_its_scene():
    assert {name: type(load_scenario(name).task) for name in training_names()} == KINDS


@pytest.mark.parametrize("name", KINDS)
def test_a_scene_is_written_and_read_again(name, tmp_path):
    scenario = load_scenario(name)
    path = tmp_path / f"{name}.yaml"
    path.write_text(dump_scenario(scenario))
    assert load_scenario(path) == scenario


def distance(surface, p_W) -> float:
    X_WS = surface.pose()
    return surface_distance(surface_row(surface), X_WS.inverse() @ np.array(p_W), np.empty(3))


@pytest.mark.parametrize("name", ["touch_points", "trace_line"])
def test_the_points_are_on_the_surface_that_may_be_touched(name):
    scenario = load_scenario(name)
    (surface,) = scenario.environment.surfaces
    task = scenario.task
    assert isinstance(task, TouchPoints | TraceLine)
    assert task.touchable() == {surface.name}
    for point in task.points:
        assert distance(surface, point) == pytest.approx(0.0, abs=1e-4)


def test_the_way_into_the_box_is_free_and_beside_the_opening_is_not():
    scenario = load_scenario("reach_into_box")
    task, surfaces = scenario.task, scenario.environment.surfaces
    assert isinstance(task, ReachInto)
    goal, opening = np.array(task.goal), np.array(task.opening)
    mouth = goal + task.depth_of(goal) * np.array(task.outward)
    for share in np.linspace(0.0, 1.0, 50):
        assert min(distance(s, mouth + share * (goal - mouth)) for s in surfaces) > 0.02
    width, height = task.size
    for edge in ([width / 2, 0, 0], [-width / 2, 0, 0], [0, 0, height / 2], [0, 0, -height / 2]):
        # One centimetre beyond the edge of the opening and behind its plane is the box.
        beyond = opening + np.array(edge) * (1 + 0.01 / np.linalg.norm(edge)) - [0, 0.01, 0]
        assert min(distance(s, beyond) for s in surfaces) < 0.0
    assert task.touchable() == set()


@pytest.mark.parametrize(
    ("base", "task", "words"),
    [
        ("teleoperation", "!TouchPoints {surface: wal}", "task.surface: 'wal', allowed wall"),
        ("teleoperation", "!TouchPoints {points: []}", "task.points: 0 points, allowed 1 to 1000"),
        (
            "teleoperation",
            "!TraceLine {surface: wall, points: [[1, 0, 0], [1, 0, 0]]}",
            r"task.points\[1\]: the place of the one before, allowed another",
        ),
        ("teleoperation", "!CutPipe {}", "task: CutPipe, allowed where `environment.cut`"),
        ("teleoperation", "!ReachInto {goal: [0, 0, 0]}", "task.goal: before the opening"),
        (
            "teleoperation",
            "!ReachInto {outward: [0, 0.5, 0]}",
            "task.outward: length 0.5, allowed 1",
        ),
    ],
)
def test_a_task_that_does_not_fit_is_refused(base, task, words):
    with pytest.raises(ValueError, match=words):
        load_scenario(base, {"task": task})


def test_a_pipe_has_a_name_of_its_own():
    with pytest.raises(ValueError, match=r"cut\.name: 'wall', allowed a name that no surface has"):
        load_scenario("teleoperation", {"environment.cut": "{name: wall}"})


@pytest.mark.parametrize("name", KINDS)
def test_a_task_is_drawn(name):
    meshcat = Meshcat()
    diagram = make_diagram(load_scenario(name), meshcat)
    diagram.ForcedPublish(diagram.CreateDefaultContext())
    drawn = {"touch_points": "point_4", "trace_line": "line_11", "reach_into_box": "goal"}
    assert meshcat.HasPath(f"task/{drawn.get(name, f'mark/{SEGMENTS - 1}')}")


class Told:
    """A Meshcat that keeps what is set."""

    def __init__(self) -> None:
        self.visible: dict[str, bool] = {}

    def SetProperty(self, path: str, name: str, value: bool, time: float) -> None:
        self.visible[path] = value

    def Delete(self, path: str) -> None: ...

    def SetObject(self, path: str, shape: object, rgba: object) -> None: ...

    def SetTransform(self, path: str, X: object) -> None: ...


def test_the_mark_goes_dark_where_the_wall_is_cut():
    pipe, told = PipeCut(cells_around=SEGMENTS), Told()
    system = TaskAnnotations(cast(Meshcat, told), CutPipe(), pipe)
    context = system.CreateDefaultContext()
    cells = np.ones((pipe.cells_through, SEGMENTS))
    cells[:, 3] = 0.0
    system.GetInputPort("cells").FixValue(context, cells.ravel())
    system.ForcedPublish(context)
    assert len(told.visible) == SEGMENTS
    assert [path for path, visible in told.visible.items() if not visible] == ["task/mark/3"]
