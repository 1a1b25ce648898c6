"""Abbott and Okamura's bound, by the device's own kernel."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from small_experiments import small
from strategies import examples

from scara_drake.experiments.claim import REPRODUCED, Experiment
from scara_drake.experiments.literature import quantised_wall
from scara_drake.experiments.literature.quantised_wall import FINE, PERIOD, Wall, user_work
from scara_drake.operator.master import Master, move_device


def experiment() -> Experiment:
    return small("quantised_wall")


def device_at(wall: Wall, mass: float, period: float) -> np.ndarray:
    return Master(
        mass=mass, damping=wall.viscous, friction=wall.friction, actuator_limit=np.inf,
        hand_stiffness=0.0, hand_damping=0.0,
    ).parameters(period)  # fmt: skip


def cycle(wall: Wall, stiffness: float, way: float, edge: float) -> float:
    """Work [J] of a user who goes `way` [m] to and fro from a place `edge` [counts] deep."""
    device = device_at(wall, 0.05, PERIOD / FINE)
    low = edge * wall.resolution - 0.5 * min(way, 1e-2 * wall.resolution)
    places = np.concatenate([np.linspace(0.0, low, 5), np.tile([low + way, low], 3)])
    done = user_work(device, stiffness, wall.resolution, FINE, places)
    return float(done[-1] - done[-3])


walls = st.builds(
    Wall, st.floats(0.1, 10.0), st.floats(0.02, 1.0), st.sampled_from([1e-5, 5.5e-5, 1e-4, 1e-3])
)


@examples(25)
@given(walls, st.floats(-3.0, 3.0), st.floats(0.6, 20.0))
def test_below_the_bound_nobody_gets_energy(wall: Wall, size: float, edge: float) -> None:
    way = wall.resolution * 10.0**size
    assert cycle(wall, 0.97 * wall.bound(), way, edge) >= 0.0
    assert cycle(wall, 0.97 * wall.bound(), way, float(np.floor(edge)) + 0.5) >= 0.0


@examples(15)
@given(walls)
def test_well_above_it_somebody_does(wall: Wall) -> None:
    ways = (1e-3 * wall.resolution, 1e4 * wall.resolution)
    assert min(cycle(wall, 1.3 * wall.bound(), way, 3.5) for way in ways) < 0.0


@pytest.mark.parametrize(("share", "grows"), [(0.9, False), (1.1, True)])
def test_beyond_the_viscous_bound_a_free_device_is_thrown(share: float, grows: bool) -> None:
    # The first of the two modes is an instability: nobody need push.
    wall = Wall(2.0, 0.0, 0.0)
    device = device_at(wall, 0.3, PERIOD)
    motion, target, f_hand = np.array([1e-3, 0, 0, 0, 0, 0.0]), np.zeros(3), np.zeros(3)
    swing = []
    for _ in range(5000):
        force = np.array([share * 2.0 * wall.viscous / PERIOD * motion[0], 0.0, 0.0])
        move_device(device, force, np.zeros(3), motion, target, f_hand)
        swing.append(abs(motion[0]))
    assert bool(max(swing[-200:]) > 1e-3) is grows


def test_each_of_the_two_bounds_counts() -> None:
    assert Wall(0.5, 1.0, 1e-4).bound() == pytest.approx(1000.0)
    assert Wall(5.0, 0.05, 1e-4).bound() == pytest.approx(1000.0)


def test_verdicts() -> None:
    assert [claim.verdict for claim in experiment().claims] == [REPRODUCED] * 2


def test_it_judges_what_it_is_given() -> None:
    data = experiment().data
    for figure, factor, index in (("found", 1.1, 0), ("found", 0.9, 0), ("least_work", -1.0, 1)):
        other = data.copy(deep=True)
        other[figure] = factor * other[figure]
        met = [claim.verdict == REPRODUCED for claim in quantised_wall.claims(other)]
        assert met == [at != index for at in range(2)], figure


def test_bad_input_is_told_in_one_line() -> None:
    with pytest.raises(ValueError, match=r"^walls: 'glass', allowed viscous, .*$"):
        quantised_wall.run(walls=("glass",))
    with pytest.raises(ValueError, match=r"^users: 0, allowed .*$"):
        quantised_wall.run(users=0)
