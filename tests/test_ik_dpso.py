"""Swarm, PSO and DPSO: the paper's populations and laws, the budgets, the success of each set."""

import numpy as np
import pytest

from scara_drake import ik, joints, kinematics
from scara_drake.ik.kernels.postures import Bounds, Goal
from scara_drake.ik.kernels.search import population_kernel, second_population_kernel
from scara_drake.ik.kernels.swarm import Rule, draw_kernel, draws, swarm_kernel

LOWER, UPPER = np.array(joints.LOWER), np.array(joints.UPPER)


def targets(n, seed):
    q = np.random.default_rng(seed).uniform(LOWER, UPPER, (n, 6))
    return q, kinematics.forward_kinematics(q)


def test_populations_are_the_papers():
    assert population_kernel(5) == 40  # (20): 5 * 10 / (0.25 * 5)
    assert population_kernel(6) == 48
    # (23): the paper's 52 iterations give about its 40 particles; always fewer than N.
    assert 35 <= second_population_kernel(52, 52 * 40, 40) <= 39
    assert second_population_kernel(200, 8000, 40) == 39
    assert second_population_kernel(1, 40, 40) == 20


def test_draws_are_splitmix64():
    # First outputs of the reference generator for seed 1234567, shifted to 53 bits.
    reference = [6457827717110365317, 3203168211198807973, 9817491932198370423]
    state = draws(1234567)
    for word in reference:
        assert draw_kernel(state) == (word >> 11) / 2**53


def test_draws_are_uniform():
    state = draws(0)
    sample = np.array([draw_kernel(state) for _ in range(20_000)])
    assert 0.0 <= sample.min() < sample.max() < 1.0
    counts = np.histogram(sample, 20, (0, 1))[0]
    assert np.sum((counts - 1000) ** 2 / 1000) < 44  # chi-square, 19 degrees, 0.1 %


def run_swarm(swarm, q, X, state, x=None, seeded=0, box=(LOWER, UPPER), tolerance=(0.0, 0.0)):
    x = np.tile(q, (swarm.particles, 1)) if x is None else x
    costs = np.empty(swarm.particles)
    history = np.zeros((500, 2))
    goal = Goal(X[:3, 3].copy(), X[:3, :3].copy(), Bounds(1, LOWER, UPPER))
    (low, high), (position, rotation) = box, tolerance
    rule = Rule(False, low, high, position, rotation, seeded)
    out = swarm_kernel(swarm, goal, rule, state, x, costs, history)
    return out, x, costs, history


SWARM = ik.Swarm(30, 60, 1.0, 0.99, 1.5, 2.0, 0.1, 0, 1.0, 1.0)


def test_a_swarm_improves_and_returns_its_bests_in_order():
    (q,), (X,) = targets(1, 0)
    (iterations, evaluations, position, rotation), x, costs, history = run_swarm(
        SWARM, q, X, draws(3)
    )
    assert iterations == 60
    assert evaluations == 61 * 30
    assert np.all(np.diff(costs) >= 0.0)
    assert np.all((x >= LOWER) & (x <= UPPER))
    assert np.all(x[:, 0] == q[0])
    errors = kinematics.pose_error(X, kinematics.forward_kinematics(x[0]))
    np.testing.assert_allclose((position, rotation), errors, atol=1e-7)
    # (25) with weights 1 and 1, of the best so far, never rises.
    best = history[:61].sum(axis=1)
    assert np.all(np.diff(best) <= 1e-15)
    assert costs[0] == pytest.approx(best[-1])


def test_the_first_iteration_is_equation_18():
    # Two particles, no velocity yet, no damping of the inertia: the particle behind moves by
    # c2 r (leader - x) within the speed bound, the leader stays; replayed with the same draws.
    (q,), (X,) = targets(1, 1)
    swarm = SWARM._replace(particles=2, iterations=1, personal=1.5, social=2.0)
    x = np.array([q + 0.01, q + 0.3])
    x[:, 0] = q[0]
    x = np.clip(x, LOWER, UPPER)
    before = x.copy()
    state, replay = draws(5), draws(5)
    _, after, _, _ = run_swarm(swarm, q, X, state, x=x, seeded=2)
    moved = before[1].copy()
    for _ in range(5):  # the leader's draws
        draw_kernel(replay), draw_kernel(replay)
    for j in range(1, 6):
        draw_kernel(replay)  # times its distance to its own best, zero
        pull = 2.0 * draw_kernel(replay) * (before[0, j] - before[1, j])
        moved[j] += np.clip(pull, *(0.1 * (UPPER[j] - LOWER[j]) * np.array([-1, 1])))
    moved = np.clip(moved, LOWER, UPPER)
    cost = sum(kinematics.pose_error(X, kinematics.forward_kinematics(moved)))
    # The swarm returns personal bests: the moved particle where it improved.
    old = sum(kinematics.pose_error(X, kinematics.forward_kinematics(before[1])))
    expected = moved if cost < old else before[1]
    assert min(np.abs(after - expected).max(axis=1)) < 1e-12


def test_law_24_draws_no_personal_term():
    (q,), (X,) = targets(1, 2)
    swarm = SWARM._replace(particles=1, iterations=3, personal=0.0)
    state = draws(0)
    run_swarm(swarm, q, X, state)
    counted = draws(0)
    for _ in range(5 + 3 * 5):  # the first posture, then one a joint and iteration
        draw_kernel(counted)
    assert state[0] == counted[0]


def test_a_swarm_stops_inside_the_tolerance_and_where_it_stalls():
    (q,), (X,) = targets(1, 4)
    out, x, _, _ = run_swarm(
        SWARM, q, X, draws(1), x=np.tile(q, (30, 1)), seeded=30, tolerance=(5e-3, 0.0175)
    )
    assert out[0] == 0
    np.testing.assert_array_equal(x[0], q)
    stuck = SWARM._replace(particles=1, stall=7, social=0.0, personal=0.0)
    assert run_swarm(stuck, q, X, draws(1))[0][0] == 7


@pytest.mark.parametrize(
    ("method", "options", "least"),
    [
        ("pso", {}, 60),
        ("pso", {"polish": True}, 60),
        ("dpso", {}, 60),
        ("dpso", {"polish": False}, 60),
        ("dpso", {"parameters": "paper", "polish": True}, 55),
    ],
)
def test_tuned_and_polished_searches_solve_everything(method, options, least):
    solved = 0
    for k, (q, X) in enumerate(zip(*targets(60, 10), strict=True)):
        held = np.array([q[0], *joints.HOME[1:]])
        result = ik.solve(X, method, "arm", q_seed=held, seed=k, **options)
        solved += result.success
    assert solved >= least


def test_the_papers_one_pass_solves_about_half():
    # Its structure with assumed coefficients: 53 to 55 % were measured elsewhere.
    solved = 0
    for k, (q, X) in enumerate(zip(*targets(150, 11), strict=True)):
        held = np.array([q[0], *joints.HOME[1:]])
        result = ik.solve(X, "dpso", "arm", q_seed=held, seed=k, parameters="paper", polish=False)
        assert result.iterations <= 900
        solved += result.success
    assert 0.35 * 150 < solved < 0.75 * 150


def test_budget_counts_evaluations():
    X = kinematics.forward_kinematics(joints.HOME)
    X[0, 3] += 10.0  # never reached
    fallback = ik.solve(X, "robust").evaluations
    for polish in (True, False):
        small, large = (
            ik.solve(X, "dpso", budget=n, polish=polish).evaluations - polish * fallback
            for n in (1000, 50_000)
        )
        assert 1000 <= small < 15_000
        assert 50_000 <= large < 70_000


def test_a_parameter_set_of_ones_own():
    X = kinematics.forward_kinematics(joints.HOME)
    own = ik.TUNED._replace(pso1=ik.TUNED.pso1._replace(particles=25), radius=0.3)
    assert ik.solve(X, "dpso", parameters=own).success


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"parameters": "best"}, "parameters: 'best', allowed tuned, paper"),
        ({"budget": 0}, "budget: 0, allowed 1 or more"),
        ({"budget": 2.5}, "budget: 2.5, allowed a whole number"),
        ({"starts": True}, "starts: True, allowed a whole number"),
        ({"polish": 1}, "polish: 1, allowed True or False"),
        ({"history": "yes"}, "history: yes, allowed True or False"),
        ({"nearest_to": [np.nan] * 6}, r"nearest_to\[0\]: nan"),
    ],
)
def test_bad_options_are_refused(options, message):
    with pytest.raises(ValueError, match=message):
        ik.solve(np.eye(4), "dpso", **options)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"rows": "all"}, "rows: 'all', allowed full, position"),
        ({"max_iterations": 0}, "max_iterations: 0, allowed 1 or more"),
        ({"max_step": 0.0}, "max_step: 0.0, allowed"),
    ],
)
def test_bad_options_of_the_inverse_jacobian_are_refused(options, message):
    with pytest.raises(ValueError, match=message):
        ik.solve(np.eye(4), "inverse_jacobian", **options)


def test_position_alone_is_solved_by_pso_1_within_the_tolerance():
    """Unpolished, the position task is the paper's live experiment: 5 mm, any orientation."""
    rng = np.random.default_rng(21)
    for k in range(30):
        target = rng.uniform(joints.LOWER, joints.UPPER)
        X = kinematics.forward_kinematics(target)
        result = ik.solve(X, "dpso", "arm", "position", q_seed=target, seed=k, polish=False)
        distance = np.linalg.norm(kinematics.forward_kinematics(result.q)[:3, 3] - X[:3, 3])
        assert result.success
        assert 1e-6 < distance <= 5e-3
        assert result.q[0] == target[0]
        again = ik.solve(X, "dpso", "arm", "position", q_seed=target, seed=k, polish=False)
        np.testing.assert_array_equal(again.q, result.q)


@pytest.mark.slow
def test_the_tuned_swarms_alone_solve_twenty_thousand_poses():
    rng = np.random.default_rng(41)
    postures = rng.uniform(joints.LOWER, joints.UPPER, (20_000, 6))
    for k, X in enumerate(kinematics.forward_kinematics(postures)):
        result = ik.solve(X, "dpso", "arm", q_seed=postures[k], seed=k, polish=False)
        assert result.success, k
