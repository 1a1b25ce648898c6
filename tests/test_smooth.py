"""Smooth motions: bounds that nothing breaks, and the times and ways of the ruckig library."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from ruckig import ControlInterface, InputParameter, Ruckig, Trajectory
from strategies import examples

from scara_drake.common.smooth import (
    BOUNDS,
    approach,
    approach_distance,
    approach_speed,
    change_velocity,
    ramp_height,
    ramp_sum,
)

SPEEDS = st.floats(0.02, 5.0)
ACCELERATIONS = st.floats(0.1, 20.0)
JERKS = st.floats(1.0, 1000.0)
PERIODS = st.sampled_from([5e-4, 1e-3, 2e-3])


def norm(vector: np.ndarray) -> float:
    return float(np.linalg.norm(vector))


def ruckig_trajectory(v: float, a: float, goal: float, limits: tuple[float, float]) -> Trajectory:
    """The fastest change of a velocity."""
    asked = InputParameter(1)
    asked.control_interface = ControlInterface.Velocity
    asked.current_position, asked.current_velocity = [0.0], [v]
    asked.current_acceleration, asked.target_velocity = [a], [goal]
    asked.target_acceleration = [0.0]
    asked.max_acceleration, asked.max_jerk = [limits[0]], [limits[1]]
    trajectory = Trajectory(1)
    Ruckig(1).calculate(asked, trajectory)
    return trajectory


@examples(60)
@given(
    speed=SPEEDS,
    acceleration=ACCELERATIONS,
    jerk=JERKS,
    goal=st.floats(-1, 1),
    before=st.floats(0.0, 1.0),
)
def test_a_velocity_changes_in_the_time_and_over_the_way_of_ruckig(
    speed: float, acceleration: float, jerk: float, goal: float, before: float
) -> None:
    dt = 1e-3
    bounds = BOUNDS.pack(speed=2.0 * speed, acceleration=acceleration, jerk=jerk)
    start = before * min(acceleration, math.sqrt(jerk * speed))  # it can ramp down in time
    v, a, way, ticks = np.array([speed]), np.array([start]), 0.0, 0
    best = ruckig_trajectory(speed, start, goal * speed, (acceleration, jerk))
    while abs(v[0] - goal * speed) > 1e-9 or abs(a[0]) > 1e-9:
        change_velocity(np.array([goal * speed]), v, a, bounds, dt)
        way, ticks = way + dt * v[0], ticks + 1
        assert ticks * dt < best.duration + 0.1
    # In ticks it may take as many more as the parts of a ramp.
    assert ticks * dt == pytest.approx(best.duration, rel=0.03, abs=4 * dt)
    expected = best.at_time(best.duration)[0][0]
    assert way == pytest.approx(expected, rel=0.03, abs=4 * dt * 2 * speed)


@examples(40)
@given(
    bounds=st.tuples(SPEEDS, ACCELERATIONS, JERKS),
    dt=PERIODS,
    n=st.integers(1, 3),
    seed=st.integers(0, 2**32 - 1),
)
def test_no_bound_is_broken_whatever_is_wanted(
    bounds: tuple[float, float, float], dt: float, n: int, seed: int
) -> None:
    draws = np.random.default_rng(seed)
    speed, acceleration, jerk = bounds
    packed = BOUNDS.pack(speed=speed, acceleration=acceleration, jerk=jerk)
    v, a, wanted = np.zeros(n), np.zeros(n), np.zeros(n)
    for tick in range(400):
        if draws.random() < 0.02 or tick == 0:
            wanted = draws.normal(size=n)
            wanted *= speed * draws.choice([0.0, 1.0, draws.random()]) / norm(wanted)
        before = a.copy()
        change_velocity(wanted, v, a, packed, dt)
        assert norm(v) <= speed * (1 + 1e-9)
        assert norm(a) <= acceleration * (1 + 1e-9)
        assert norm(a - before) <= jerk * dt * (1 + 1e-9)


@examples(40)
@given(
    bounds=st.tuples(SPEEDS, ACCELERATIONS, JERKS),
    bandwidth=st.floats(1.0, 100.0),
    distance=st.floats(1e-4, 3.0),
    dt=PERIODS,
)
def test_a_point_is_approached_and_never_passed(
    bounds: tuple[float, float, float], bandwidth: float, distance: float, dt: float
) -> None:
    speed, acceleration, jerk = bounds
    packed = BOUNDS.pack(speed=speed, acceleration=acceleration, jerk=jerk)
    direction = np.array([2.0, -1.0, 2.0]) / 3.0
    p, v, a = np.zeros(3), np.zeros(3), np.zeros(3)
    for _ in range(round(2.0 / dt)):
        approach(distance * direction - p, v, a, packed, bandwidth, dt)
        p += dt * v
        assert p @ direction <= distance * (1 + 1e-3) + 1e-9
    np.testing.assert_allclose(p, (p @ direction) * direction, atol=1e-12)
    # It takes at most what a plan of its shares of the bounds takes, and the last of the way.
    slow = (
        distance / speed + speed / (0.6 * acceleration) + 3 * (distance / (0.2 * jerk)) ** (1 / 3)
    )
    if slow + 0.6 * acceleration / (0.2 * jerk) + 8.0 / bandwidth < 2.0:
        assert p @ direction == pytest.approx(distance, rel=0.01)


@examples(100)
@given(
    bounds=st.tuples(SPEEDS, ACCELERATIONS, JERKS),
    bandwidth=st.floats(1.0, 100.0),
    share=st.floats(0.01, 1.0),
)
def test_distance_and_speed_of_an_approach_undo_each_other(
    bounds: tuple[float, float, float], bandwidth: float, share: float
) -> None:
    packed = BOUNDS.pack(speed=bounds[0], acceleration=bounds[1], jerk=bounds[2])
    speed = share * bounds[0]
    distance = approach_distance(speed, packed, bandwidth)
    assert approach_speed(distance, packed, bandwidth) == pytest.approx(speed, rel=1e-9)


@examples(100)
@given(height=st.floats(0.0, 1e4))
def test_a_ramp_adds_up_tick_by_tick(height: float) -> None:
    total, level = 0.0, height
    while level > 0.0:
        total, level = total + level, level - 1.0
    assert ramp_sum(height) == pytest.approx(total, rel=1e-9)
    assert ramp_height(total) == pytest.approx(height, rel=1e-9)
