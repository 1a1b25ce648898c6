"""Who found the first posture: the swarm, which really runs, or the fallback, and it is named."""

import numpy as np
import pytest
import strategies
from hypothesis import given
from rich.console import Console
from strategies.postures import reachable, unreachable

from scara_drake import ik, kinematics
from scara_drake.cli.summary import print_first_posture
from scara_drake.diagram import make_diagram
from scara_drake.ik import dpso
from scara_drake.ik.system import InverseKinematics, first_answer
from scara_drake.joints import HOME, LOWER, UPPER
from scara_drake.operator.mapping import JoystickMapping, initial_command
from scara_drake.recordings.recorder import metadata
from scara_drake.scenario import load_scenario

COMMAND = initial_command(JoystickMapping())
# Swarms that draw and never move: what they find is a matter of luck, and luck is not convergence.
STILL = ik.TUNED._replace(
    pso1=ik.TUNED.pso1._replace(iterations=0),
    pso2=ik.TUNED.pso2._replace(iterations=0),
    fallback=ik.TUNED.fallback._replace(iterations=0),
    polish_budget=2000,
)


def targets(count, seed, task):
    rng = np.random.default_rng(seed)
    for q in rng.uniform(LOWER, UPPER, (count, 6)):
        X = kinematics.forward_kinematics(q)
        if task == "position":
            X[:3, :3] = kinematics.rotation_from_intrinsic_xyz(rng.uniform(-np.pi, np.pi, 3))
        yield np.array([q[0], *HOME[1:]]), X


@pytest.mark.parametrize("task", ["pose", "position"])
@pytest.mark.parametrize("method", ["dpso", "dpsoij"])
def test_the_swarm_finds_it_by_itself(method, task):
    found = []
    for near, X in targets(20, 50, task):
        result = ik.solve(X, method, "arm", task, q_seed=near, nearest_to=near)
        assert result.success
        assert result.position_error < 1e-6
        found.append(result.found_by)
        if result.found_by == "dpso":
            # The particles have moved: a swarm of 19 needs an iteration for 19 evaluations.
            assert result.iterations > 20
            assert result.evaluations >= 19 * result.iterations
        again = ik.solve(X, method, "arm", task, q_seed=near, nearest_to=near)
        assert again.q.tobytes() == result.q.tobytes()
        assert again.evaluations == result.evaluations
    assert found.count("dpso") >= 19
    assert set(found) <= {"dpso", "robust"}


@pytest.mark.parametrize("task", ["pose", "position"])
def test_swarms_that_do_not_move_find_nothing(task):
    for near, X in targets(10, 51, task):
        result = ik.solve(X, "dpsoij", "arm", task, q_seed=near, parameters=STILL)
        assert result.success
        assert result.found_by == "robust"
        assert result.method == "dpsoij"
        assert result.evaluations > STILL.polish_budget


@pytest.fixture
def no_swarm(monkeypatch):
    """No swarm converges, and none but the polished search may be asked."""

    def unconverged(*arguments):
        return np.empty((0, 6)), np.empty((0, 2)), 123, 1, 0

    def refuse(*arguments):
        raise AssertionError("a swarm was asked")

    monkeypatch.setattr(dpso, "swarm_branches_kernel", unconverged)
    for name in ("dual_search_kernel", "single_search_kernel", "position_search_kernel"):
        monkeypatch.setattr(dpso, name, refuse)


@pytest.mark.usefixtures("no_swarm")
@pytest.mark.parametrize("task", ["pose", "position"])
@pytest.mark.parametrize("method", ["dpso", "dpsoij"])
def test_without_a_swarm_the_posture_is_the_fallbacks(method, task):
    for near, X in targets(3, 52, task):
        result = ik.solve(X, method, "arm", task, q_seed=near, nearest_to=near)
        assert result.success
        assert result.found_by == "robust"
        assert result.evaluations > 123
        path = ik.solve_path([X, X], "dpsoij", "arm", task, q_seed=near)
        assert path.found_by[0] == "robust"


@pytest.mark.usefixtures("no_swarm")
def test_without_a_swarm_the_recording_says_fallback():
    notes = metadata(make_diagram(load_scenario("free_motion")))["notes"]
    assert notes["first_posture_method"] == "robust"


@pytest.mark.parametrize(
    ("method", "finder"), [("dpsoij", "dpso"), ("robust", "robust"), ("dpso", "dpso")]
)
def test_the_recording_and_the_summary_say_who_found_it(method, finder):
    scenario = load_scenario("free_motion")
    scenario.inverse_kinematics.method = method
    notes = metadata(make_diagram(scenario))["notes"]
    assert notes["first_posture_method"] == finder
    assert notes["first_posture_seconds"] > 0.0
    console = Console(width=200)
    with console.capture() as shown:
        print_first_posture(console, notes)
    count = notes["first_posture_evaluations"]
    assert f"First posture: found by {finder} in {count} evaluations" in shown.get()
    scenario.q0 = list(HOME)
    given = metadata(make_diagram(scenario))["notes"]
    assert not [name for name in given if name.startswith("first_posture")]


@pytest.mark.parametrize(("joints", "task"), [("arm", "position"), ("full", "pose")])
def test_both_methods_start_the_loop_at_the_same_posture(joints, task):
    """The swarm and the closed form find the branch nearest home, each by its own way."""
    by_swarm, by_form = (
        first_answer(InverseKinematics(method, joints, task), COMMAND, 0)
        for method in ("dpsoij", "robust")
    )
    assert (by_swarm.found_by, by_form.found_by) == ("dpso", "robust")
    np.testing.assert_allclose(by_swarm.q, by_form.q, atol=1e-8)


def test_a_path_says_of_each_point_who_found_it():
    q = HOME + np.linspace(0, 0.3, 10)[:, None]
    X = kinematics.forward_kinematics(q)
    path = ik.solve_path(X, "dpsoij", q_seed=q[0])
    assert path.found_by == ("dpso", *["inverse_jacobian"] * 9)
    assert ik.solve_path(X, q_seed=q[0]).found_by == ("robust", *["inverse_jacobian"] * 9)
    assert ik.solve_path(X, "closed_form", q_seed=q[0]).found_by == ("closed_form",) * 10
    assert ik.solve_path(X, "dpso", q_seed=q[0]).found_by == ("dpso",) * 10


@strategies.examples(40)
@given(reachable())
def test_whatever_is_reachable_is_met_and_its_finder_named(target):
    q, X = target
    result = ik.solve(X, "dpsoij", "arm", q_seed=q)
    assert result.success
    assert result.found_by in ("dpso", "robust")
    assert np.all((result.q >= LOWER) & (result.q <= UPPER))


@strategies.examples(10)
@given(unreachable())
def test_what_is_out_of_reach_is_no_success_of_any_swarm(X):
    for result in (ik.solve(X), ik.solve(X, "dpsoij", budget=2000)):
        assert not result.success
        assert result.reason == "out of reach"
        assert result.found_by == "robust"
        assert np.isfinite(result.q).all()
