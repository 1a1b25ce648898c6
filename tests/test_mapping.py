from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pydrake.common.yaml import yaml_load_typed
from pydrake.math import RotationMatrix
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context

from scara_drake.joints import HOME
from scara_drake.kinematics import forward_kinematics
from scara_drake.operator.mapping import (
    STICK_MOTION,
    JoystickMapping,
    JoystickToPose,
    initial_command,
    move_command,
    remove_dead_zone,
)

AXES = arrays(float, 5, elements=st.floats(-1, 1))


def tick(system: JoystickToPose, context: Context) -> np.ndarray:
    """One update on a bare Context; returns the output after it."""
    updated = system.EvalUniquePeriodicDiscreteUpdate(context)
    context.SetDiscreteState(updated)
    return system.GetOutputPort("tool_command").Eval(context)


def make(mapping: JoystickMapping, axes: list[float]) -> tuple[JoystickToPose, Context]:
    system = JoystickToPose(mapping)
    context = system.CreateDefaultContext()
    system.GetInputPort("joystick_axes").FixValue(context, np.array(axes, dtype=float))
    return system, context


@settings(deadline=None)  # compiles at the first call
@given(zone=st.floats(0, 0.9), axis=st.floats(-1, 1), step=st.floats(0, 1e-3))
def test_dead_zone_is_odd_continuous_monotone_and_reaches_one(
    zone: float, axis: float, step: float
) -> None:
    value = remove_dead_zone(axis, zone)
    assert remove_dead_zone(-axis, zone) == -value
    assert remove_dead_zone(1.0, zone) == 1.0
    assert remove_dead_zone(zone, zone) == 0.0
    assert abs(value) <= 1.0
    if abs(axis) <= zone:
        assert value == 0.0
    rise = remove_dead_zone(min(axis + step, 1.0), zone) - value
    assert 0.0 <= rise <= step / (1 - zone) + 1e-12


def test_initial_command_is_the_default_home_of_the_robot() -> None:
    command = initial_command(JoystickMapping())
    X_WE = forward_kinematics(HOME)
    # The centre is rounded to a centimetre.
    np.testing.assert_allclose(command[:3], X_WE[:3, 3], atol=5e-3)
    assert command[7] == HOME[0]
    R = RotationMatrix(X_WE[:3, :3]).ToQuaternion().wxyz()
    assert abs(command[3:7] @ R) == pytest.approx(1.0)


@settings(deadline=None)
@given(arrays(float, 3, elements=st.floats(-3, 3)))
def test_quaternion_turns_about_x_then_the_new_y_then_the_new_z(rpy: np.ndarray) -> None:
    # Half-angle quaternions, multiplied by hand: qx qy qz.
    w, x, y, z = 1.0, 0.0, 0.0, 0.0
    for axis, angle in enumerate(rpy):
        c, v = math.cos(angle / 2), [0.0, 0.0, 0.0]
        v[axis] = math.sin(angle / 2)
        a, b, d = v
        w, x, y, z = (
            w * c - x * a - y * b - z * d,
            w * a + x * c + y * d - z * b,
            w * b - x * d + y * c + z * a,
            w * d + x * b - y * a + z * c,
        )
    quaternion = initial_command(JoystickMapping(rpy=rpy.tolist()))[3:7]
    assert abs(quaternion @ [w, x, y, z]) == pytest.approx(1.0, abs=1e-12)


def test_ports_and_initial_output() -> None:
    mapping = JoystickMapping(centre=[0.5, -0.6, 0.1], mast_height=4.0)
    system, context = make(mapping, [1, 1, 1, 1, 1])
    assert system.GetInputPort("joystick_axes").size() == 5
    output = system.GetOutputPort("tool_command")
    assert output.size() == 8
    np.testing.assert_array_equal(output.Eval(context), initial_command(mapping))
    np.testing.assert_allclose(output.Eval(context)[:3], [0.5, -0.6, 4.1])


def test_full_stick_arrives_at_centre_plus_scale_with_the_stick_s_signs() -> None:
    mapping = JoystickMapping(max_speed=5.0, dead_zone=0.1, smoothing=0.0)
    system, context = make(mapping, [1.0, -1.0, 0.55, 0.0, 0.0])
    start = initial_command(mapping)
    for _ in range(400):
        command = tick(system, context)
    np.testing.assert_allclose(command[:3] - start[:3], [0.5, -0.5, 0.25], atol=1e-12)
    np.testing.assert_array_equal(command[3:], start[3:])


def test_a_step_is_followed_in_a_straight_line_at_max_speed() -> None:
    mapping = JoystickMapping(max_speed=0.3, dead_zone=0.0)
    system, context = make(mapping, [0.6, 0.0, -0.8, 0.0, 0.0])
    path = np.array([initial_command(mapping)[:3]] + [tick(system, context)[:3] for _ in range(50)])
    steps = np.diff(path, axis=0)
    np.testing.assert_allclose(steps, np.tile([0.6 * 3e-4, 0, -0.8 * 3e-4], (50, 1)), atol=1e-12)


def test_a_small_step_is_followed_with_the_smoothing_s_time_constant() -> None:
    mapping = JoystickMapping(dead_zone=0.0, smoothing=0.05)
    system, context = make(mapping, [0.02, 0.0, 0.0, 0.0, 0.0])  # 10 mm: never at max_speed
    start = initial_command(mapping)[0]
    path = np.array([tick(system, context)[0] - start for _ in range(200)])
    t = 1e-3 * np.arange(1, 201)
    np.testing.assert_allclose(path, 0.01 * (1 - np.exp(-t / 0.05)), atol=1e-12)


def test_the_mast_carries_the_tool_and_stops_at_its_range() -> None:
    mapping = JoystickMapping(mast_height=9.9999, mast_rate=0.2)
    system, context = make(mapping, [0, 0, 0, 0, 1])
    start = initial_command(mapping)
    first = tick(system, context)
    assert first[7] - start[7] == pytest.approx(1e-4, abs=1e-12)  # clamped from 2e-4
    np.testing.assert_allclose(first[:3] - start[:3], [0, 0, 1e-4], atol=1e-12)
    assert tick(system, context)[7] == 10.0


@pytest.mark.parametrize(
    ("mast_axis", "hat", "rate"), [(0.55, 0, 0.5), (0.05, 0, 0.0), (1, 1, 1.0), (-1, 1, 0.0)]
)
def test_mast_rate_adds_axis_and_hat_up_to_full(mast_axis: float, hat: float, rate: float) -> None:
    mapping = JoystickMapping(mast_rate=0.2, dead_zone=0.1)
    system, context = make(mapping, [0, 0, 0, mast_axis, hat])
    for _ in range(10):
        command = tick(system, context)
    assert command[7] - 3.0 == pytest.approx(10 * rate * 2e-4, abs=1e-12)


@settings(max_examples=100, deadline=None)
@given(
    path=st.lists(AXES, min_size=1, max_size=30),
    height=st.floats(2.5, 10),
    share=st.floats(1e-6, 1.0),
)
def test_bounds_hold_for_any_stick(path: list[np.ndarray], height: float, share: float) -> None:
    mapping = JoystickMapping(mast_height=height)
    centre = np.array(mapping.centre)
    command = initial_command(mapping)
    motion = STICK_MOTION.pack(
        centre=centre, scale=0.5, dead_zone=0.05, share=share, max_step=0.05, mast_step=0.02
    )
    held = command[3:7].copy()
    for axes in path:
        before = command.copy()
        move_command(axes, motion, command)
        moved = command[:3] - before[:3]
        moved[2] -= command[7] - before[7]
        assert np.linalg.norm(moved) <= 0.05 + 1e-12
        assert abs(command[7] - before[7]) <= 0.02 + 1e-12
        assert 2.5 <= command[7] <= 10.0
        offset = command[:3] - centre - [0, 0, command[7]]
        assert np.abs(offset).max() <= 0.5 + 1e-12
        np.testing.assert_array_equal(command[3:7], held)


@pytest.mark.parametrize("index", range(5))
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_axes_that_are_not_finite_move_nothing(index: int, bad: float) -> None:
    axes = [0.5] * 5
    axes[index] = bad
    system, context = make(JoystickMapping(), axes)
    np.testing.assert_array_equal(tick(system, context), initial_command(JoystickMapping()))


def test_clone_and_second_run_give_equal_bits() -> None:
    system, context = make(JoystickMapping(), [0.3, -0.9, 0.7, 0.2, 1.0])
    simulator = Simulator(system, context)
    simulator.AdvanceTo(0.1005)
    fork = Simulator(system, context.Clone())
    simulator.AdvanceTo(0.2005)
    fork.AdvanceTo(0.2005)
    port = system.GetOutputPort("tool_command")
    np.testing.assert_array_equal(port.Eval(context), port.Eval(fork.get_context()))
    fresh = system.CreateDefaultContext()
    np.testing.assert_array_equal(port.Eval(fresh), initial_command(JoystickMapping()))


@pytest.mark.parametrize(
    ("field", "value", "named"),
    [
        ("centre", [0.0, 0.0], "mapping.centre: 2 entries"),
        ("centre", [0.0, 3.0, 0.0], r"mapping.centre\[1\]: 3.0"),
        ("rpy", [0.0, math.nan, 0.0], r"mapping.rpy\[1\]: nan"),
        ("scale", -0.1, "mapping.scale: -0.1"),
        ("dead_zone", 1.0, "mapping.dead_zone: 1.0, allowed 0 to 0.9"),
        ("mast_height", 2.4, "mapping.mast_height: 2.4, allowed 2.5 to 10"),
        ("mast_rate", math.inf, "mapping.mast_rate: inf"),
        ("max_speed", 0.0, "mapping.max_speed: 0.0"),
    ],
)
def test_bad_fields_are_named(field: str, value: Any, named: str) -> None:
    with pytest.raises(ValueError, match=named):
        JoystickToPose(replace(JoystickMapping(), **{field: value}))


def test_bad_period_is_named() -> None:
    with pytest.raises(ValueError, match="period: 0"):
        JoystickToPose(JoystickMapping(), 0)


def test_reads_from_yaml() -> None:
    text = "{centre: [0.7, -0.8, 0.1], dead_zone: 0.1}"
    mapping = yaml_load_typed(schema=JoystickMapping, data=text, defaults=JoystickMapping())
    assert mapping == JoystickMapping(centre=[0.7, -0.8, 0.1], dead_zone=0.1)
