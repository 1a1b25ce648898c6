"""The swarms under each reading: by hand in numpy, and the package's own under its reading."""

from itertools import pairwise

import numpy as np
import pytest

from scara_drake import ik, kinematics
from scara_drake.experiments.inverse_kinematics import postures, swarm_readings, swarm_statements
from scara_drake.experiments.inverse_kinematics.swarm_law import Coefficients, Law
from scara_drake.experiments.inverse_kinematics.swarm_reported import STATEMENTS
from scara_drake.ik.kernels.postures import goal_kernel
from scara_drake.ik.kernels.search import search_box_kernel
from scara_drake.ik.kernels.swarm import draw_kernel, draws
from scara_drake.joints import LOWER, UPPER

OWN = Law(False, False, False, False, False, 48)
SET = Coefficients(0.9, 0.99, 1.3, 1.7, 0.1, 0, 40)


def goal(k):
    X = postures.targets()[k]
    return goal_kernel(X[:3, 3].copy(), X[:3, :3].copy(), 0)


@pytest.mark.parametrize("k", range(4))
def test_under_the_packages_reading_pso_is_the_packages_to_the_bit(k):
    X, most = postures.targets()[k], swarm_readings.MOST_ITERATIONS
    single = ik.Swarm(48, most, *SET[:5], 0, 1.0, 1.0)
    answer = ik.solve(
        X, "pso", q_seed=postures.home(), seed=5, parameters=ik.PAPER._replace(single=single)
    )
    q = postures.home()
    run = swarm_readings.pso_kernel(OWN, SET, goal(k), draws(5), q)
    assert (run.stage == 1) == answer.success
    assert run.first == answer.iterations
    assert run.evaluations == answer.evaluations
    if answer.success:
        expected = kinematics.pose_error(X, kinematics.forward_kinematics(q))
        assert (run.position, run.rotation) == pytest.approx(expected, abs=1e-9)
        assert np.allclose(np.cos(q - answer.q)[1:], 1.0, atol=1e-12)


def by_hand(law, c, k, seed, most):
    """PSO in numpy: the postures, the leader and its objective after some iterations."""
    state, target = draws(seed), postures.targets()[k]
    box = search_box_kernel(target[:3, 3].copy())
    low, high = box.low.copy(), box.high.copy()
    if law.one_turn:
        low[1:], high[1:] = np.maximum(low[1:], -np.pi), np.minimum(high[1:], np.pi)

    def rand():
        r = draw_kernel(state)
        return c.speed * (2.0 * r - 1.0) if law.literal else r

    def cost(q):
        X = kinematics.forward_kinematics(q)
        away, angle = kinematics.pose_error(target, X)
        if law.angles:
            angle = postures.angle_difference(target, X)
        return (1e3 if law.millimetres else 1.0) * away + angle

    x = np.array(
        [[low[j] + draw_kernel(state) * (high[j] - low[j]) for j in range(6)] for _ in range(7)]
    )
    v, best, costs = np.zeros_like(x), x.copy(), [cost(q) for q in x]
    leader, leading = x[np.argmin(costs)].copy(), min(costs)
    w = c.inertia
    for _ in range(most):
        waiting = []
        for i in range(7):
            for j in range(6):
                v[i, j] = w * v[i, j] + c.personal * rand() * (best[i, j] - x[i, j])
                v[i, j] += c.social * rand() * (leader[j] - x[i, j])
                if not law.literal:
                    v[i, j] = np.clip(v[i, j], *(c.speed * (UPPER - LOWER)[j] * np.array([-1, 1])))
            x[i] = np.clip(x[i] + v[i], LOWER, UPPER)
            now = cost(x[i])
            if now < costs[i]:
                costs[i], best[i] = now, x[i]
            waiting.append((now, x[i].copy()))
            if law.at_once and now < leading:
                leading, leader = now, x[i].copy()
        for now, q in waiting:
            if now < leading:
                leading, leader = now, q
        w *= c.damping
    return x, leader, leading


@pytest.mark.parametrize(
    "law",
    [
        OWN,
        OWN._replace(literal=True),
        OWN._replace(millimetres=True),
        OWN._replace(angles=True),
        OWN._replace(one_turn=True),
        OWN._replace(at_once=True),
    ],
    ids=["own", "literal", "millimetres", "angles", "one_turn", "at_once"],
)
@pytest.mark.parametrize("k", [0, 3])
def test_each_reading_is_the_swarm_by_hand(law, k):
    law, most = law._replace(particles=7), 4
    x, leader, leading = by_hand(law, SET, k, 3, most)
    unit = 1e3 if law.millimetres else 1.0
    stage = swarm_readings.Stage(SET.personal, unit, 1.0, 0.0175, most, 0, False)
    g, state = goal(k), draws(3)
    box = swarm_readings._first_box(law, g)
    crowd = swarm_readings._crowd(box, stage, g, state, 7, postures.home())
    converged, last = swarm_readings.stage_kernel(law, SET, stage, g, box, state, crowd)
    assert (converged, last) == (-1, most)  # seven particles do not get there
    assert np.allclose(crowd.x, x, atol=1e-9)
    assert np.allclose(crowd.leader, leader, atol=1e-9)
    assert crowd.leading[()] == pytest.approx(leading, rel=1e-9)


def test_a_swarm_that_runs_on_gets_nearer_and_keeps_its_answer():
    def run(after, seed):
        return swarm_readings.pso_kernel(
            OWN, SET._replace(after=after), goal(3), draws(seed), postures.home()
        )

    seed = next(seed for seed in range(20) if run(0, seed).stage == 1)
    ends = []
    for after in (0, 5, 20, 60):
        one = run(after, seed)
        assert (one.stage, one.after) == (1, after)
        assert one.position <= 5e-3
        assert one.rotation <= 0.0175
        ends.append((one.first, one.position + one.rotation))
    assert len({first for first, _ in ends}) == 1
    # The sum is what it minimises, but the first inside may have led with a larger one.
    assert all(b <= a for (_, a), (_, b) in pairwise(ends))
    assert ends[-1][1] < 0.5 * ends[0][1]


def test_m_is_equation_23_with_the_papers_own_time():
    # 0.2455 s, the mean of Table 8, for 66 iterations: it (it t) / (0.0175 * 10)
    for iterations in (10, 39, 47, 48):
        expected = iterations * (iterations * 0.2455 / 66) / 0.175
        assert swarm_readings.second_population_kernel(iterations) == round(expected)
    # M < N = 48 asks PSO-1 to end within 47 iterations; N + M = 80 asks for 39.
    assert swarm_readings.second_population_kernel(47) < 48
    assert swarm_readings.second_population_kernel(48) > 48
    assert swarm_readings.second_population_kernel(39) == 32


def test_dpso_spends_n_on_pso_1_and_the_fallback_and_m_on_pso_2():
    assert swarm_readings.RADIUS == 0.174
    q = postures.home()
    run = swarm_readings.dpso_kernel(OWN, SET, goal(2), draws(0), q)
    assert run.particles == swarm_readings.second_population_kernel(run.first)
    spent = 48 * (run.first + 1) + run.particles * (run.second + 1)
    if run.stage != 2:
        assert run.second == SET.patience
        spent += 48 * (run.third + 1)
    assert run.evaluations == spent


def test_statistics_of_a_toy_by_hand():
    field = {name: k for k, name in enumerate(swarm_readings.Run._fields)}
    runs = np.zeros((4, 2, len(field)))
    runs[..., field["stage"]] = 1
    runs[..., field["position"]], runs[..., field["rotation"]] = 1e-4, 0.002
    single = runs.copy()
    single[..., field["first"]] = [[60, 70], [64, 66], [66, 66], [67, 67]]  # means 65, 65, 66, 67
    single[..., field["evaluations"]] = 1000
    dual = runs.copy()
    dual[..., field["first"]], dual[..., field["second"]] = 39, 13
    dual[:2, :, field["third"]] = 60
    dual[..., field["stage"]] = [[3, 3], [3, 3], [2, 2], [2, 3]]
    dual[..., field["particles"]] = 32
    dual[..., field["evaluations"]] = [[1343] * 2, [1381] * 2, [760] * 2, [786] * 2]
    undamped = single.copy()
    undamped[..., field["position"]] = 1.0
    path = dual[:1].copy()
    path[..., field["evaluations"]] = 240
    s = swarm_statements.Sample(48, single, undamped, dual, path, np.zeros((1, 2, 6)))

    def found(stages, at_stop=False, added=True):
        return swarm_statements.statistics(s, swarm_statements.Count(stages, at_stop, added))

    everything = found("all")
    assert everything["pso_iterations"] == pytest.approx([65.75])
    assert everything["dpso_iterations"] == pytest.approx([(112 + 112 + 52 + 52) / 4])
    assert found("PSO-1 and PSO-2")["dpso_iterations"] == pytest.approx([52])
    assert found("those that answered")["dpso_iterations"] == pytest.approx(
        [(60 + 60 + 52 + (52 + 0) / 2) / 4]
    )
    assert everything["solved"] == pytest.approx([100 * (2.5 / 3) ** 8])
    assert everything["pso_errors"] == pytest.approx([0.1, 0.002])
    assert everything["times"] == pytest.approx([1.343, 1.381, 0.76, 0.786])
    assert everything["second"] == pytest.approx([0, 0, 100, 50])
    assert everything["damping"] == pytest.approx([0])
    assert everything["fewer"] == pytest.approx([100])
    assert everything["population"] == pytest.approx([80])
    rounds = 39 + 13 + 60 + 3
    assert found("all", added=False)["population"] == pytest.approx([240 / rounds])
    assert everything["path_work"] == pytest.approx([240 / np.mean([1343, 1381, 760, 786])])
    names = list(STATEMENTS)
    met = {n for n, m in zip(names, swarm_statements.misfits(everything), strict=True) if m == 0.0}
    assert met == {
        "pso_iterations", "solved", "pso_errors", "times", "second", "damping", "fewer",
        "population", "path_work",
    }  # fmt: skip
