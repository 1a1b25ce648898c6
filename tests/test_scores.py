"""Scores of synthetic recordings against closed forms: what is judged, and what it is worth."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from scara_drake import metrics
from scara_drake.common.schema import yaml_of
from scara_drake.metrics import scores
from scara_drake.metrics.task_of import task_of
from scara_drake.tasks import CutPipe, ReachInto, TouchPoints, TraceLine

PERIOD = 0.01  # [s]
WALL = -1.05  # y of the wall [m]
OUT = np.array([0.0, 1.0, 0.0])


def recording_of(task, path, force, **more) -> xr.Dataset:
    """A recording with what a score reads: a tool on a wall of normal y."""
    n = len(path)
    text = f"task: !{type(task).__name__}\n" + "\n".join(
        f"  {line}" for line in yaml_of(task).splitlines()
    )
    force = np.broadcast_to(np.asarray(force, dtype=float), (n,))
    surfaces = more.pop("surfaces", {"wall": force > 0.0})
    return xr.Dataset(
        {
            "p_WE_measured": (("time", "axis"), np.asarray(path, dtype=float)),
            "f_env_on_tool_W": (("time", "axis"), force[:, None] * OUT),
            "penetration": (
                ("time", "surface"),
                np.array([1e-3 * np.asarray(each, dtype=float) for each in surfaces.values()]).T,
            ),
            **{name: ("time", values) for name, values in more.items()},
        },
        coords={"time": PERIOD * np.arange(n), "surface": list(surfaces)},
        attrs={"scenario": text},
    )


def scored(recording: xr.Dataset) -> Any:
    return metrics.score(recording)


def value(found: Any, name: str) -> float:
    return next(each.value for each in found.criteria if each.name == name)


def line_task(**changes) -> TraceLine:
    ends: Any = [[0.7, WALL, 3.0], [0.9, WALL, 3.0]]
    given: dict[str, Any] = {"surface": "wall", "points": ends, "force": 20.0}
    return TraceLine(**(given | changes))


def along(n: int, beside: float = 0.0) -> np.ndarray:
    x = np.linspace(0.7, 0.9, n)
    return np.stack([x, np.full(n, WALL), np.full(n, 3.0 + beside)], axis=1)


@given(best=st.floats(-100, 100), apart=st.floats(0.1, 100), share=st.floats(0, 1))
def test_a_criterion_is_worth_a_straight_line_between_its_bounds(best, apart, share):
    for worst in (best - apart, best + apart):
        judged = best + share * (worst - best)
        one = metrics.Criterion("a", "m", 20.0, best, worst, judged)
        assert one.points == pytest.approx(20.0 * (1.0 - share), abs=1e-6)


@pytest.mark.parametrize(("found", "worth"), [(-5.0, 10.0), (50.0, 0.0), (math.nan, 0.0)])
def test_beyond_its_bounds_a_criterion_gives_no_more_and_no_less(found, worth):
    assert metrics.Criterion("a", "N", 10.0, 0.0, 20.0, found).points == worth


def test_the_weights_of_each_task_add_up_to_a_hundred():
    cut = {
        name: np.full(3, 0.5)
        for name in ("cut_left", "kerf_place", "blade_bend", "energy_cut", "energy_blade")
    }
    for task in (TouchPoints(), line_task(), ReachInto(), CutPipe()):
        recording = recording_of(task, along(3), 1.0, blade_stalled=np.zeros(3), **cut)
        assert sum(each.weight for each in scored(recording).criteria) == 100.0


@given(beside=st.floats(0.0, 0.009), force=st.floats(1.0, 100.0))
def test_a_line_traced_beside_itself_at_a_constant_force(beside, force):
    task, n = line_task(), 401
    found = scored(recording_of(task, along(n, beside), force))
    assert found.share == 1.0
    assert found.done
    assert value(found, "off the line, RMS") == pytest.approx(beside, abs=1e-9)
    assert value(found, "force off what is set, RMS") == pytest.approx(abs(force - 20.0), abs=1e-9)
    assert value(found, "largest force") == pytest.approx(force)


def test_the_path_error_of_a_wave_is_its_amplitude_over_root_two():
    n, amplitude = 4001, 0.006
    path = along(n)
    path[:, 2] += amplitude * np.sin(2.0 * np.pi * 40.0 * np.arange(n) / (n - 1))
    found = scored(recording_of(line_task(), path, 20.0))
    off = value(found, "off the line, RMS")
    assert off == pytest.approx(amplitude / math.sqrt(2.0), rel=0.01)


def test_what_the_tool_is_below_the_surface_is_no_error_of_the_path():
    path = along(401)
    path[:, 1] -= 0.004
    found = scored(recording_of(line_task(), path, 20.0))
    assert value(found, "off the line, RMS") == pytest.approx(0.0, abs=1e-12)


def test_half_a_line_is_half_of_the_task_give_or_take_its_width():
    task = line_task(tolerance=0.001)
    found = scored(recording_of(task, along(401)[:201], 20.0))
    assert found.share == pytest.approx(0.5, abs=0.03)
    assert not found.done
    assert math.isnan(value(found, "time"))


def test_a_line_beside_its_width_or_without_contact_is_not_traced():
    assert scored(recording_of(line_task(), along(401, 0.011), 20.0)).share == 0.0
    assert scored(recording_of(line_task(), along(401), 0.0)).total == 0.0


@given(force=st.floats(0.0, 300.0), seconds=st.integers(1, 20))
def test_the_integral_of_a_constant_squared_force(force, seconds):
    n = round(seconds / PERIOD) + 1
    recording = recording_of(TouchPoints(), np.zeros((n, 3)), force)
    assert scores.squared_force(recording) == pytest.approx(force**2 * seconds, abs=1e-9)
    assert scores.mean_force(recording) == pytest.approx(force)


def touch_path(order) -> tuple[np.ndarray, np.ndarray]:
    """Stands one second in the air and one on each mark."""
    path, force = [], []
    for point in order:
        path += [np.array(point) + 0.05 * OUT] * 100 + [np.array(point)] * 100
        force += [0.0] * 100 + [10.0] * 100
    return np.array(path), np.array(force)


def test_points_count_in_their_order_only():
    a, b, c = [0.7, WALL, 3.0], [0.9, WALL, 3.0], [0.8, WALL, 3.1]
    task = TouchPoints(points=[a, b, c])
    right = scored(recording_of(task, *touch_path([a, b, c])))
    assert right.share == 1.0
    assert right.seconds == pytest.approx(5.0)
    assert right.marks == pytest.approx((1.0, 3.0, 5.0))
    wrong = scored(recording_of(task, *touch_path([c, b, a])))
    assert wrong.share == pytest.approx(1.0 / 3.0)
    light = recording_of(task, touch_path([a, b, c])[0], 4.0)
    assert scored(light).share == 0.0


def test_a_point_touched_beside_its_mark_says_how_far():
    a = [0.7, WALL, 3.0]
    path, force = touch_path([a])
    found = scored(recording_of(TouchPoints(points=[a]), path + np.array([0.012, 0, 0]), force))
    assert value(found, "touches off their marks, RMS") == pytest.approx(0.012)


def test_what_is_not_to_be_touched_is_a_collision_and_a_bounce_is_one():
    n = 1000
    beside = np.zeros(n, dtype=bool)
    beside[100:150] = beside[152:200] = beside[500:600] = True
    surfaces = {"wall": np.ones(n, dtype=bool), "shelf": beside}
    recording = recording_of(TouchPoints(), along(n), 1.0, surfaces=surfaces)
    found = scores.collisions(recording, TouchPoints())
    assert [(each.start, each.end) for each in found] == [
        pytest.approx((1.0, 1.99)),
        pytest.approx((5.0, 5.99)),
    ]


def reach_path(stay: float) -> np.ndarray:
    """In and out on the straight way, with a stay at the goal [s]."""
    way = np.linspace([0.8, -0.9, 3.0], [0.8, -1.2, 3.0], 301)
    return np.concatenate([way, np.repeat(way[-1:], round(stay / PERIOD), 0), way[::-1]])


@pytest.mark.parametrize(("stay", "share"), [(1.5, 1.0), (0.3, 0.25)])
def test_a_goal_counts_when_the_tool_stays_and_comes_out(stay, share):
    task = ReachInto(stay=1.0)
    found = scored(recording_of(task, reach_path(stay), 0.0))
    assert found.share == share
    assert found.done is (share == 1.0)
    assert value(found, "off the straight way, RMS") == pytest.approx(0.0, abs=1e-9)


def test_inside_at_the_end_is_three_quarters():
    path = reach_path(1.5)[:-250]
    assert scored(recording_of(ReachInto(stay=1.0), path, 0.0)).share == 0.75


def cut_recording(**changes) -> xr.Dataset:
    n = 1001
    stalled = np.zeros(n)
    stalled[100:200] = stalled[300:350] = 1.0
    values = {
        "cut_left": np.linspace(1.0, 0.0, n),
        "kerf_place": np.full(n, 0.006),
        "blade_bend": np.full(n, -0.002),
        "energy_cut": np.linspace(0.0, 5000.0, n),
        "energy_blade": np.linspace(0.0, 6000.0, n),
        "blade_stalled": stalled,
    } | changes
    return recording_of(CutPipe(mark=0.005), along(n), 0.0, **values)


def test_a_cut_says_its_stalls_its_energy_and_its_place():
    found = scored(cut_recording())
    assert found.share == 1.0
    assert found.seconds == pytest.approx(9.99, abs=0.011)
    assert value(found, "stalls") == 2
    assert value(found, "time stalled") == pytest.approx(0.99 + 0.49)
    assert value(found, "kerf off the mark") == pytest.approx(0.001)
    assert value(found, "blade bent, most") == pytest.approx(0.002)
    assert value(found, "blade's energy to that of the cut") == pytest.approx(1.2)
    half = scored(cut_recording(cut_left=np.linspace(1.0, 0.5, 1001)))
    assert half.share == pytest.approx(0.5, abs=2e-3)
    assert not half.done


def test_what_comes_after_the_task_is_done_or_its_time_is_up_is_not_judged():
    path, force = touch_path([[0.7, WALL, 3.0]])
    force = np.concatenate([force, np.full(100, 500.0)])
    path = np.concatenate([path, np.repeat(path[-1:], 100, 0)])
    task = TouchPoints(points=[[0.7, WALL, 3.0]])
    assert value(scored(recording_of(task, path, force)), "largest force") == 10.0
    late = TouchPoints(points=[[0.7, WALL, 3.0]], most_time=1.0)
    moved = np.concatenate([np.repeat(path[:1], 200, 0), path])
    forces = np.concatenate([np.zeros(200), force])
    assert scored(recording_of(late, moved, forces)).total == 0.0


def test_the_recording_tells_its_score_and_one_without_a_task_has_none():
    recording = recording_of(line_task(), along(401), 20.0)
    told = scores.score_attributes(recording)
    rows = json.loads(str(told["score_table"]))
    assert told["score"] == pytest.approx(sum(row["points"] for row in rows))
    assert {"name", "unit", "weight", "best", "worst", "value", "points"} == set(rows[0])
    bare = recording.assign_attrs(scenario="name: free\ntask: null\n")
    assert task_of(bare) is None
    assert scores.score_attributes(bare) == {}


def test_a_task_that_is_none_is_refused_in_one_line():
    recording = recording_of(line_task(), along(11), 20.0)
    with pytest.raises(ValueError, match=r"^task: 'Juggle', allowed TouchPoints, TraceLine"):
        scored(recording.assign_attrs(scenario="task: !Juggle {}"))
