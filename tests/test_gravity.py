import numpy as np
import pytest
from pydrake.multibody.plant import MultibodyPlant

from scara_drake import joints, robot
from scara_drake.control.gravity import gravity_effort, gravity_parameters


@pytest.fixture(scope="module")
def plant():
    plant = MultibodyPlant(time_step=0.0)
    robot.add_scara(plant)
    plant.Finalize()
    return plant


def effort_at(q):
    effort = np.full(6, np.nan)
    gravity_effort(np.asarray(q, float), gravity_parameters(), effort)
    return effort


def test_it_is_minus_the_generalized_force_of_gravity_that_drake_finds(plant):
    context = plant.CreateDefaultContext()
    for q in np.random.default_rng(0).uniform(joints.LOWER, joints.UPPER, (300, 6)):
        plant.SetPositions(context, q)
        expected = -plant.CalcGravityGeneralizedForces(context)
        np.testing.assert_allclose(effort_at(q), expected, rtol=0, atol=1e-9)


def test_the_mast_carries_the_moving_mass_and_the_scara_posture_little_else():
    effort = effort_at(joints.HOME)  # theta3 = 0: the axes of joints 2, 4 and 5 are vertical
    masses = [345.9, 88.0, 139.7, 129.4, 20.8, 11.7]  # Table 3
    np.testing.assert_allclose(effort[0], 9.81 * sum(masses), rtol=1e-12)
    np.testing.assert_allclose(effort[[1, 3, 4]], 0.0, atol=1e-9)
    assert abs(effort[2]) > 500.0


def test_static_maxima_are_those_of_the_uniform_chain():
    # models/README.md: 7215 N, 0, 824, 824, 42 and 0 N m.
    q = np.random.default_rng(1).uniform(joints.LOWER, joints.UPPER, (20000, 6))
    largest = np.abs([effort_at(row) for row in q]).max(axis=0)
    np.testing.assert_allclose(largest, [7215.0, 0.0, 824.0, 824.0, 42.0, 0.0], rtol=0.02, atol=0.1)


def test_parameters_cannot_be_changed_by_accident():
    with pytest.raises(ValueError, match="read-only"):
        gravity_parameters()[0, 0] = 0.0
