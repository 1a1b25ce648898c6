"""scara_drake.robot: constants, checks of a configuration, nominal inertias."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.multibody.plant import MultibodyPlant

from scara_drake import kinematics, robot

CONSTANTS = [robot.LOWER, robot.UPPER, robot.MAX_SPEED, robot.EFFORT, robot.HOME]


@pytest.mark.parametrize("constant", CONSTANTS)
def test_constants_cannot_be_changed(constant):
    assert constant.shape == (6,)
    with pytest.raises(ValueError, match="read-only"):
        constant[0] = 0.0


def test_home_is_away_from_limits_and_singularities():
    assert np.all(robot.HOME > robot.LOWER)
    assert np.all(robot.HOME < robot.UPPER)
    angles = slice(1, 6)
    margin = np.minimum(robot.HOME - robot.LOWER, robot.UPPER - robot.HOME)
    assert np.all(margin[angles] > 0.5)
    singular_values = np.linalg.svd(kinematics.jacobian(robot.HOME), compute_uv=False)
    assert singular_values[-1] > 0.05


def test_home_holds_the_tool_along_minus_y():
    X = kinematics.forward_kinematics(robot.HOME)
    np.testing.assert_allclose(X[:3, 2], [0, -1, 0], atol=1e-15)


def test_a_configuration_within_the_ranges_is_returned_as_a_copy():
    q = robot.check_configuration("q0", list(robot.HOME))
    np.testing.assert_array_equal(q, robot.HOME)
    q[0] = 4.0
    assert robot.HOME[0] == 3.0
    for bound in (robot.LOWER, robot.UPPER):
        np.testing.assert_array_equal(robot.check_configuration("q0", bound), bound)


@given(
    joint=st.integers(0, 5),
    beyond=st.floats(1e-9, 1e9) | st.sampled_from([math.inf, math.nan]),
    upper=st.booleans(),
)
def test_a_joint_out_of_range_is_named_with_its_range(joint, beyond, upper):
    q = robot.HOME.copy()
    q[joint] = robot.UPPER[joint] + beyond if upper else robot.LOWER[joint] - beyond
    with pytest.raises(ValueError, match="start: ") as error:
        robot.check_configuration("start", q)
    message = str(error.value)
    assert message.startswith(f"start: {robot.JOINT_NAMES[joint]} = ")
    allowed = f"allowed {robot.LOWER[joint]:.4g} to {robot.UPPER[joint]:.4g}"
    assert message.endswith(f"{allowed} {robot.JOINT_UNITS[joint]}")
    assert "\n" not in message


@pytest.mark.parametrize("q", [[], 3.0, [3.0] * 5, [[3.0] * 6], [0.0] * 7])
def test_a_wrong_shape_is_refused(q):
    with pytest.raises(ValueError, match=r"^q0: shape .*, allowed \(6,\)"):
        robot.check_configuration("q0", q)


@pytest.mark.parametrize("q", [["a"] * 6, [3.0, [1.0], 0, 0, 0, 0], {"d1": 3.0}])
def test_what_is_not_numbers_is_refused(q):
    with pytest.raises(ValueError, match=r"^q0: .*, allowed \(6,\)"):
        robot.check_configuration("q0", q)


def test_add_scara_returns_the_instance_of_six_joints():
    plant = MultibodyPlant(time_step=1e-3)
    instance = robot.add_scara(plant)
    plant.Finalize()
    assert plant.num_positions(instance) == plant.num_actuated_dofs(instance) == 6
    names = plant.GetPositionNames(instance, add_model_instance_prefix=False)
    assert [n.rsplit("_", 1)[0] for n in names] == list(robot.JOINT_NAMES)
    assert plant.HasFrameNamed(robot.TOOL_FRAME, instance)


def test_nominal_inertias_are_the_mean_over_the_workspace():
    plant = MultibodyPlant(time_step=0.0)
    robot.add_scara(plant)
    plant.Finalize()
    context = plant.CreateDefaultContext()
    diagonals = []
    for q in np.random.default_rng(2024).uniform(robot.LOWER, robot.UPPER, (2000, 6)):
        plant.SetPositions(context, q)
        diagonals.append(np.diag(plant.CalcMassMatrix(context)))
    geometric_mean = np.prod(np.array(diagonals) ** (1 / len(diagonals)), axis=0)
    np.testing.assert_allclose(robot.nominal_inertias(), geometric_mean, rtol=0.04)
    assert robot.nominal_inertias()[0] == pytest.approx(735.5)


def test_nominal_inertias_are_kept_and_read_only():
    inertias = robot.nominal_inertias()
    assert robot.nominal_inertias() is inertias
    with pytest.raises(ValueError, match="read-only"):
        inertias[0] = 0.0
