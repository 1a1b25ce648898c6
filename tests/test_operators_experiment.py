"""Operators under delay: the laws of others, with operators who are fitted to no delay."""

from functools import cache

import numpy as np
import pytest
from small_experiments import small

from scara_drake import load_scenario, simulate
from scara_drake.environment import Wall
from scara_drake.experiments import IN_KIND, NOT_REPRODUCED, REPRODUCED
from scara_drake.experiments.literature import operators_claims as judged
from scara_drake.experiments.literature import operators_under_delay as under_test
from scara_drake.experiments.literature.virtual_operator import work
from scara_drake.metrics import completion_time
from scara_drake.operator.policy import MoveAndWait, Press


@cache
def experiment():
    return small("operators_under_delay")


def verdicts(data):
    return [claim.verdict for claim in judged.claims(data)]


def test_slopes_intervals_and_lines_by_hand():
    delays = np.array([0.0, 1.0, 3.0])
    np.testing.assert_allclose(judged.slopes(delays, np.array([2.0 + 5.0 * delays])), [5.0])
    assert judged.straightness(delays, 2.0 + 5.0 * delays) == pytest.approx(1.0)
    assert judged.straightness(delays, np.array([0.0, 1.0, 0.0])) < 0.5
    assert judged.straightness(delays, np.ones(3)) == 0.0
    draws = np.random.default_rng(1).normal(3.0, 2.0, 400)
    low, high = judged.interval(draws)
    half = 1.96 * draws.std(ddof=1) / np.sqrt(draws.size)
    np.testing.assert_allclose([low, high], draws.mean() + np.array([-half, half]), atol=0.03)


def ideal():
    """Data that meet every claim: 4 moves without a delay (5 where fine), and straight lines."""
    data = experiment().data.copy(deep=True)
    data.reach_moves[:] = np.array([4.0, 5.0])[:, None, None]
    data.reach_seconds[:] = 6.0 + data.reach_delay * data.reach_moves
    slope = np.array([20.0, 15.0])[:, None, None]
    for field in ("seconds", "squared_force"):
        data[f"press_{field}"][:] = 8.0 + slope * data.press_delay.values[None, :, None]
    data.follow_seconds[:] = 4.0
    data.follow_seconds[:, -1] = np.nan
    return data


def test_it_judges_what_it_is_given():
    data = ideal()
    assert verdicts(data) == [REPRODUCED] * 8
    data.reach_seconds[:, 1:] *= 1.2
    data.reach_moves[:] = np.array([4.0, 5.0])[:, None, None]
    data.reach_moves[1, 0, 0] = 2.0  # one of the fine ones makes fewer, and the mean is the same
    data.reach_moves[1, 0, 1] = 8.1
    for field in ("seconds", "squared_force"):
        # Not straight, nor all of the slopes smaller where the robot yields.
        data[f"press_{field}"][:, 1] -= 4.0
        data[f"press_{field}"][1, -1] += np.array([6.0, -9.0])
    data.follow_seconds[0, -1, 0] = 30.0
    assert verdicts(data)[1:] == [IN_KIND] * 7
    data.reach_seconds[:, 1:] *= 2.0
    data.reach_moves[1] = 3.0
    for field in ("seconds", "squared_force"):
        data[f"press_{field}"][:] = 9.0
    data.follow_seconds[:] = 4.0
    assert verdicts(data) == [NOT_REPRODUCED] * 8


def test_verdicts():
    """Of two people and a shortened delay; the law needs no more."""
    assert verdicts(experiment().data)[:2] == [REPRODUCED] * 2


@pytest.mark.slow
def test_verdicts_of_thirty_people():
    """Some who follow without a pause are done even over the longest delay."""
    assert [claim.verdict for claim in under_test.run().claims] == [REPRODUCED] * 7 + [IN_KIND]


@pytest.mark.slow
@pytest.mark.parametrize("delay", [0.0, 0.256, 0.512])
def test_the_arm_in_the_diagram_takes_as_long(delay):
    """Its mean over six people, within a quarter: the arm has a lag, and swings a little."""
    link = f"!ConstantDelay {{delay: {delay / 2.0}}}"
    ours, arm = [], []
    for person in range(6):
        policy = MoveAndWait(work=Press(places=under_test.BEFORE))
        ours.append(work(policy, delay, person, under_test.WALL).seconds)
        scenario = load_scenario(
            "bilateral",
            {
                "coupling": "!WaveVariables {}",
                "operator.centre": [0.8, -1.0, 0.0],
                "operator.policy": "!MoveAndWait {work: !Press {places: [[0.0, -0.04, 0.0]]}}",
                "channel.up": link,
                "channel.down": link,
                "seed": person,
                "duration": 40.0,
            },
        )
        arm.append(completion_time(simulate(scenario)))
    assert np.mean(arm) == pytest.approx(np.mean(ours), rel=0.25)


def test_without_a_wall_nothing_is_felt_and_with_one_the_force_is_that_of_the_work():
    free = MoveAndWait(work=Press(places=under_test.BEFORE))
    assert work(free, 0.0, 0, longest=5.0).peak_force == 0.0
    assert work(free, 0.0, 0, Wall(stiffness=1e4, damping=100.0)).peak_force > 2.5
