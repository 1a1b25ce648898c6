"""The scripted operator: what he knows, how he moves, and that the good one is the better one."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray as xr

import scara_drake as sd
from scara_drake.operator.aiming import next_move
from scara_drake.operator.skills import FREE, LEG, SKILLS, WHOLE, Leg, Skill, plan_of
from scara_drake.operator.trainee import Trainee, TraineeSource
from scara_drake.scenario import Scenario
from scara_drake.tasks.plans import normal_at, plan_for

# One mark, so that a run is short.
ONE = {"task": "!TouchPoints {points: [[0.8, -1.05, 3.02]]}", "duration": 14.0}
SHORT: dict[str, dict[str, Any]] = {
    "touch_points": ONE,
    "trace_line": {"duration": 40.0},
    "reach_into_box": {"duration": 30.0},
    "cut_pipe": {"duration": 75.0},
}


def trained(name: str, skill: str, seed: int = 0, round_trip: float = 0.1, **changes) -> Scenario:
    half = f"!ConstantDelay {{delay: {round_trip / 2}}}"
    settings = {"seed": seed, "channel.up": half, "channel.down": half, "logging.period": 0.005}
    scenario = sd.load_scenario(name, settings | changes)
    operator: Any = scenario.operator
    scenario.operator = Trainee(skill, mapping=operator.mapping)
    return scenario


def total(recording: xr.Dataset) -> float:
    return float(recording.attrs["score"])


def move_of(leg: Leg, skill: Skill, start, seen, felt) -> np.ndarray:
    move = np.zeros(3)
    a, b, c = (np.array(each, dtype=float) for each in (start, seen, felt))
    next_move(plan_of([leg])[0], skill.parameters(np.zeros(3), 1.0, 0.0), a, b, c, move)
    return move


def test_in_free_space_he_goes_back_to_the_line_and_along_it():
    leg = Leg(np.array([1.0, 0.0, 0.0]), FREE, 0.0, 0.01, 0.2)
    move = move_of(leg, Skill(correction=1.0), [0, 0, 0], [0.3, 0.05, 0.0], [0, 0, 0])
    assert move == pytest.approx([0.2, -0.05, 0.0])
    whole = leg._replace(stride=WHOLE)
    move = move_of(whole, Skill(correction=1.0), [0, 0, 0], [0.3, 0.05, 0.0], [0, 0, 0])
    assert move == pytest.approx([0.7, -0.05, 0.0])


@pytest.mark.parametrize(("force", "ahead"), [(0.0, 0.1), (5.0, 0.05), (10.0, 0.0), (16.0, -0.1)])
def test_force_slows_the_advance_and_turns_it_back(force, ahead):
    leg = Leg(np.array([1.0, 0.0, 0.0]), FREE, 10.0, 0.01, 0.1)
    seen, felt = [0.3, 0.0, 0.0], [-force, 0.0, 0.0]
    heeds, heedless = Skill(correction=1.0), Skill(correction=1.0, heed=0.0)
    assert move_of(leg, heeds, [0, 0, 0], seen, felt)[0] == pytest.approx(ahead)
    assert move_of(leg, heedless, [0, 0, 0], seen, felt)[0] == pytest.approx(0.1)


def test_on_a_surface_the_normal_part_of_a_move_follows_the_force_alone():
    leg = Leg(np.zeros(3), np.array([0.0, 1.0, 0.0]), 20.0, 0.01, WHOLE)
    skill = Skill(force_gain=1e-4, approach=0.003)
    for felt, down in ((10.0, 0.001), (30.0, -0.001), (500.0, -0.003)):
        move = move_of(leg, skill, [0, 0.05, 0], [0.0, -0.002, 0.0], [0.0, felt, 0.0])
        assert move[1] == pytest.approx(-down)
    assert move_of(leg, skill, [0, 0.05, 0], [0, 0.008, 0], [0, 0, 0])[1] == pytest.approx(-0.003)


def test_the_plan_presses_along_the_surface_s_normal():
    scenario: Any = sd.load_scenario("trace_line")
    (vessel,) = scenario.environment.surfaces
    for point in np.array(scenario.task.points):
        out = point - np.array(vessel.point)
        out[2] = 0.0
        assert normal_at(vessel, point) == pytest.approx(out / np.linalg.norm(out), abs=1e-6)
    plan = plan_for(scenario.task, scenario.environment, [0.8, -0.95, 3.0])
    legs = [LEG.unpack(row) for row in plan]
    pressed = [leg for leg in legs if leg.normal.any()]
    assert pressed
    assert {leg.force for leg in pressed} == {scenario.task.force}


def test_a_plan_of_another_shape_is_refused():
    with pytest.raises(ValueError, match=r"^plan: shape \(3, 2\), allowed"):
        TraineeSource(Trainee(), np.zeros((3, 2)))


def test_a_trainee_needs_a_task():
    with pytest.raises(
        ValueError, match=r"^operator: !Trainee, allowed in a scenario with a task$"
    ):
        sd.load_scenario("teleoperation", {"operator": "!Trainee {}"})


def test_a_seed_gives_the_same_bits_and_drake_the_same_run():
    first = trained("touch_points", "bad", 3, duration=1.2)
    runs = [sd.simulate(first, engine=engine) for engine in ("compiled", "compiled", "drake")]
    for name in ("p_WE_measured", "joystick_axes", "p_WE_seen"):
        assert np.array_equal(runs[0][name], runs[1][name]), name
        assert runs[2][name].values == pytest.approx(runs[0][name].values, abs=1e-9), name
    another = sd.simulate(trained("touch_points", "bad", 4, duration=1.2))
    assert not np.array_equal(runs[0].joystick_axes, another.joystick_axes)


def test_he_does_not_move_before_he_can_have_seen_and_nothing_before_the_delay():
    """What he does until the picture has come back is the same whatever the robot does."""
    more_of_them: list[dict[str, Any]] = [{}, {"inverse_kinematics.max_speed": 0.05}]
    runs = [
        sd.simulate(trained("touch_points", "bad", 0, 2.0, duration=1.0, **more))
        for more in more_of_them
    ]
    assert np.array_equal(runs[0].joystick_axes, runs[1].joystick_axes)


def test_a_blind_one_makes_one_move_and_waits():
    """With the picture far away the patient one has nothing to go by."""
    recording = sd.simulate(trained("touch_points", "good", 0, 4.0, duration=3.5))
    asked = recording.p_WE_commanded
    moved = abs(asked.diff("time")).max("axis") > 1e-4
    times = recording.time.values[1:][moved.values]
    assert times.size
    assert times.max() < 2.0


@pytest.mark.parametrize(
    "name", ["touch_points", pytest.param("reach_into_box", marks=pytest.mark.slow)]
)
def test_the_good_one_is_better_than_the_bad_one(name):
    means = {
        skill: np.mean([total(sd.simulate(trained(name, skill, k, **SHORT[name]))) for k in (1, 2)])
        for skill in SKILLS
    }
    assert means["good"] > means["bad"] + 2.0


@pytest.mark.slow
@pytest.mark.parametrize("name", SHORT)
def test_the_good_one_is_better_over_thirty_seeds(name):
    changes = {"duration": 120.0}
    runs = [trained(name, skill, k, **changes) for skill in ("good", "bad") for k in range(30)]
    found = np.array([total(each) for each in sd.simulate_many(runs)]).reshape(2, 30)
    assert (found[0] > found[1]).mean() >= 0.8
    assert found[0].mean() > found[1].mean() + 5.0


@pytest.mark.slow
@pytest.mark.parametrize("name", SHORT)
def test_the_score_falls_with_delay(name):
    means = []
    for round_trip in (0.0, 0.25, 0.5, 1.0):
        runs = [trained(name, "good", k, round_trip, duration=120.0) for k in range(5)]
        means.append(np.mean([total(each) for each in sd.simulate_many(runs)]))
    assert np.all(np.diff(means) < 0.0), means
