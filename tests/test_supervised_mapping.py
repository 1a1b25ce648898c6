"""The command of a supervised operator: no jump, no bound broken, never out of reach."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from operator_rig import PERIOD, SAMPLE, OperatorRig
from strategies import examples

from scara_drake.kinematics import REACH_LIMIT, draw_into_reach
from scara_drake.operator.mapping import JoystickMapping
from scara_drake.operator.supervised_mapping import SupervisedMapping
from scara_drake.safety import State
from scara_drake.vectors import held_command

UNIT = st.floats(-1.0, 1.0)
EDGE = 1e-6  # [m]


def rig_of(**mapping: Any) -> OperatorRig:
    return OperatorRig(live=False, mapping=JoystickMapping(**mapping))


def derivatives(path: np.ndarray) -> tuple[float, float, float]:
    """The largest speed, acceleration and jerk of a path (n, k) that starts at rest."""
    rest = np.repeat(path[:1], 3, axis=0)
    levels, sizes = np.concatenate([rest, path]), []
    for _ in range(3):
        levels = np.diff(levels, axis=0) / PERIOD
        sizes.append(float(np.linalg.norm(levels, axis=1).max()))
    return sizes[0], sizes[1], sizes[2]


def check_bounds(rig: OperatorRig, start: int = 0) -> None:
    """The bounds of the mapping hold for the commanded point and the mast, from a tick on.

    Of a tick at which an engagement begins the report is the place from which it starts.
    """
    form, path = rig.form, np.array(rig.path)[start:]
    path = np.concatenate([rig.report[None, -8:], path]) if start else path
    build_up = form.max_acceleration / form.max_jerk
    slack = 1e-9 / PERIOD**3 * 1e-3  # rounding of metres, differenced three times
    for motion, speed, acceleration in (
        (path[:, :3] - path[:, 7:] * [0.0, 0.0, 1.0], form.max_speed, form.max_acceleration),
        (path[:, 7:8], form.mast_rate, form.mast_acceleration),
    ):
        v, a, j = derivatives(motion)
        assert v <= speed * (1 + 1e-6) + 1e-9
        assert a <= acceleration * (1 + 1e-6) + 1e-6
        assert j <= acceleration / build_up * (1 + 1e-6) + slack


def out_of_reach(point: np.ndarray) -> float:
    drawn = point.copy()
    draw_into_reach(drawn)
    return float(np.linalg.norm(point - drawn))


@pytest.mark.parametrize("mode", ["position", "rate"])
@examples(15)
@given(stick=st.tuples(UNIT, UNIT, UNIT), place=st.tuples(UNIT, UNIT, UNIT), height=st.floats(3, 9))
def test_an_engagement_begins_where_the_robot_is_wherever_the_stick_is(
    mode: str, stick: tuple[float, ...], place: tuple[float, ...], height: float
) -> None:
    rig = rig_of(mode=mode)
    there = held_command(
        np.array([0.6, -0.6, 0.0]) + 0.4 * np.array(place), [1.0, 0.2, 0.1], height
    )
    rig.report[-8:] = there
    rig.run(0.05, x=stick[0], y=stick[1], z=stick[2])
    before = rig.tool_command.copy()
    assert np.array_equal(rig.path, np.tile(before, (len(rig.path), 1))), "not engaged: it stands"
    rig.run(2 * PERIOD, engage=1.0)
    assert rig.state == State.ACTIVE
    start = len(rig.path) - 2
    np.testing.assert_allclose(rig.tool_command, there, atol=1e-6)
    rig.run(0.3)
    check_bounds(rig, start)
    if mode == "position":
        np.testing.assert_allclose(rig.tool_command, there, atol=EDGE)
    # From there on the tool goes as far as the stick.
    rig.run(0.7, x=stick[0] * 0.5, y=stick[1] * 0.5, z=stick[2] * 0.5)
    check_bounds(rig, start)
    assert out_of_reach(rig.point) < EDGE


def test_position_mode_is_the_half_metre_of_the_paper() -> None:
    rig = rig_of(dead_zone=0.0).run(0.05).run(0.05, engage=1.0)
    first = rig.point
    rig.run(3.0, x=-1.0)
    np.testing.assert_allclose(rig.point - first, [-0.5, 0.0, 0.0], atol=1e-4)
    rig.run(3.0, x=0.0)
    np.testing.assert_allclose(rig.point, first, atol=1e-4)
    check_bounds(rig)


def test_rate_mode_moves_as_fast_as_the_stick_says_and_stops_with_it() -> None:
    rig = rig_of(dead_zone=0.0, mode="rate").run(0.05).run(0.05, engage=1.0)
    rig.run(1.5, x=-0.8)
    rate = (rig.points()[-1] - rig.points()[-2]) / PERIOD
    np.testing.assert_allclose(rate, [-0.8 * 0.25, 0.0, 0.0], atol=1e-6)
    before = rig.point
    rig.run(0.5, x=0.0)
    # It stops within v/2 (v/a + a/j), and a filter's sample late.
    way = 0.1 * (0.2 / 2.0 + 2.0 / 40.0) + 0.2 * 2 * SAMPLE
    assert 0.0 < before[0] - rig.point[0] < way
    check_bounds(rig)


@pytest.mark.parametrize("mode", ["position", "rate"])
def test_the_mast_has_its_own_axis_and_the_height_of_the_stick_while_its_button_is_down(
    mode: str,
) -> None:
    rig = rig_of(mode=mode, dead_zone=0.0).run(0.05).run(0.05, engage=1.0)
    point, height = rig.point, rig.mast
    rig.run(1.0, mast_hat=1.0).run(0.5, mast_hat=0.0)
    assert rig.mast - height == pytest.approx(0.2, abs=0.01)
    np.testing.assert_allclose(rig.point, point, atol=1e-9, err_msg="it carries the tool along")
    height = rig.mast
    rig.run(1.0, mast=1.0, z=-1.0).run(0.5, z=0.0).run(0.5, mast=0.0)
    assert rig.mast - height == pytest.approx(-0.2, abs=0.01)
    np.testing.assert_allclose(rig.point, point, atol=EDGE)
    check_bounds(rig)


def test_the_mast_stops_before_its_limits() -> None:
    rig = rig_of(mast_height=9.9).run(0.05).run(2.0, engage=1.0, mast_axis=1.0)
    assert rig.mast == pytest.approx(10.0, abs=1e-4)
    assert max(row[7] for row in rig.path) <= 10.0
    check_bounds(rig)
    rig.run(1.0, mast_axis=-1.0)
    assert rig.mast < 9.9, "inwards always"


def test_the_tool_turns_while_its_axis_is_moved_and_is_held_otherwise() -> None:
    rig = rig_of().run(0.05).run(0.05, engage=1.0)
    first = rig.tool_command[3:7].copy()
    rig.run(1.0, yaw=1.0).run(0.5, yaw=0.0)
    angle = 2.0 * np.arccos(abs(first @ rig.tool_command[3:7]))
    assert angle == pytest.approx(0.5, abs=0.02)
    turned = rig.tool_command[3:7].copy()
    assert np.linalg.norm(turned) == pytest.approx(1.0)
    rig.run(0.5)
    np.testing.assert_allclose(rig.tool_command[3:7], turned, atol=1e-12)


def test_the_clutch_moves_the_stick_alone_and_never_ratchets_out_of_reach() -> None:
    rig = rig_of(dead_zone=0.0).run(0.05).run(0.05, engage=1.0)
    for _ in range(12):  # each cycle asks for half a metre more
        rig.run(0.6, y=-1.0)
        before = rig.point
        rig.run(0.3, clutch=1.0)
        rest = rig.point
        rig.run(0.4, y=1.0)
        assert rig.state == State.CLUTCH
        np.testing.assert_array_equal(rig.point, rest)
        assert np.linalg.norm(rest - before) < 0.15
        rig.run(0.05, clutch=0.0)
        assert out_of_reach(rig.points()[-1]) < EDGE
    check_bounds(rig)
    radius = np.hypot(np.hypot(rig.point[0], rig.point[1]) - 0.75, rig.point[2])
    assert radius == pytest.approx(REACH_LIMIT, abs=0.01), "at the edge"
    # Way back in it moves at once, by as much as the stick.
    edge = rig.point
    rig.run(0.3, clutch=1.0).run(0.3, y=0.0).run(0.05, clutch=0.0).run(1.5, y=0.4)
    assert rig.point[1] - edge[1] == pytest.approx(0.2, abs=0.02)


@pytest.mark.parametrize("scale", [0.0, 0.3, 2.0])
def test_a_change_of_scale_while_running_moves_nothing(scale: float) -> None:
    rig = rig_of(dead_zone=0.0).run(0.05).run(0.05, engage=1.0).run(2.5, x=-0.4)
    before = rig.point
    rig.run(0.5, motion_scale=scale)
    np.testing.assert_allclose(rig.point, before, atol=1e-4)
    rig.run(2.5, x=-0.6)
    assert rig.point[0] - before[0] == pytest.approx(-0.1 * scale, abs=1e-3)
    check_bounds(rig)
    rig.run(0.1, motion_scale=np.nan)
    assert np.isfinite(rig.tool_command).all()


@pytest.mark.parametrize("mode", ["position", "rate"])
@pytest.mark.parametrize(
    "stop", [{"engage": 0.0}, {"connected": 0.0}, {"estop": 1.0}, {"age": 1.0}, {"x": np.nan}]
)
def test_at_full_speed_every_stop_brakes_within_the_bounds_and_stands(
    mode: str, stop: dict[str, float]
) -> None:
    rig = rig_of(mode=mode, rate=0.5).run(0.05).run(0.05, engage=1.0)
    rig.run(0.9, x=-1.0, mast_hat=1.0, yaw=1.0)
    fast = np.linalg.norm(rig.points()[-1] - rig.points()[-2]) / PERIOD
    assert fast > 0.3
    rig.run(0.4, **stop)
    assert rig.state >= State.HOLD
    check_bounds(rig)
    rest = rig.tool_command.copy()
    rig.run(0.5, x=1.0, mast_hat=-1.0)
    np.testing.assert_allclose(rig.tool_command, rest, atol=1e-9)


def test_engaged_again_while_it_brakes_the_velocity_has_no_step() -> None:
    rig = rig_of(mode="rate", rate=0.5).run(0.05).run(0.05, engage=1.0).run(0.9, x=-1.0)
    rig.run(0.05, engage=0.0)
    rig.report[-8:] = rig.tool_command
    start = len(rig.path)
    rig.run(PERIOD, engage=1.0).run(0.5, x=0.0)
    v = np.diff(rig.points()[start:], axis=0) / PERIOD
    a = np.diff(v, axis=0) / PERIOD
    assert np.linalg.norm(a, axis=1).max() <= 2.0 * (1 + 1e-6)


def test_a_report_that_is_no_place_leaves_the_command_where_it_is() -> None:
    rig = rig_of()
    rig.report[-8:] = np.nan
    before = rig.tool_command.copy()
    rig.run(0.05).run(0.1, engage=1.0)
    np.testing.assert_allclose(rig.tool_command, before, atol=1e-9)


@pytest.mark.parametrize(
    ("field", "value"),
    [("mode", "speed"), ("max_jerk", 0.0), ("max_acceleration", np.nan), ("turn_rate", -1.0)],
)
def test_bad_fields_are_refused_by_name(field: str, value: Any) -> None:
    with pytest.raises(ValueError, match=rf"mapping\.{field}.*allowed"):
        SupervisedMapping(JoystickMapping(**{field: value}))
