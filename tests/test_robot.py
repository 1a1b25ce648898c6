"""scara_drake.robot: constants, checks of a configuration, nominal inertias, the model."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.common.yaml import yaml_load_typed
from pydrake.geometry import Role
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, MultibodyPlant
from pydrake.systems.framework import DiagramBuilder

from scara_drake import joints, kinematics, robot
from scara_drake.common.fields import check

CONSTANTS = [joints.LOWER, joints.UPPER, joints.MAX_SPEED, joints.EFFORT, joints.HOME]


@pytest.mark.parametrize("constant", CONSTANTS)
def test_constants_cannot_be_changed(constant):
    assert constant.shape == (6,)
    with pytest.raises(ValueError, match="read-only"):
        constant[0] = 0.0


def test_home_is_away_from_limits_and_singularities():
    assert np.all(joints.HOME > joints.LOWER)
    assert np.all(joints.HOME < joints.UPPER)
    angles = slice(1, 6)
    margin = np.minimum(joints.HOME - joints.LOWER, joints.UPPER - joints.HOME)
    assert np.all(margin[angles] > 0.5)
    singular_values = np.linalg.svd(kinematics.jacobian(joints.HOME), compute_uv=False)
    assert singular_values[-1] > 0.05


def test_home_holds_the_tool_along_minus_y():
    X = kinematics.forward_kinematics(joints.HOME)
    np.testing.assert_allclose(X[:3, 2], [0, -1, 0], atol=1e-15)


def test_a_configuration_within_the_ranges_is_returned_as_a_copy():
    q = joints.check_configuration("q0", list(joints.HOME))
    np.testing.assert_array_equal(q, joints.HOME)
    q[0] = 4.0
    assert joints.HOME[0] == 3.0
    for bound in (joints.LOWER, joints.UPPER):
        np.testing.assert_array_equal(joints.check_configuration("q0", bound), bound)


@given(
    joint=st.integers(0, 5),
    beyond=st.floats(1e-9, 1e9) | st.sampled_from([math.inf, math.nan]),
    upper=st.booleans(),
)
def test_a_joint_out_of_range_is_named_with_its_range(joint, beyond, upper):
    q = joints.HOME.copy()
    q[joint] = joints.UPPER[joint] + beyond if upper else joints.LOWER[joint] - beyond
    with pytest.raises(ValueError, match="start: ") as error:
        joints.check_configuration("start", q)
    message = str(error.value)
    assert message.startswith(f"start: {joints.JOINT_NAMES[joint]} = ")
    allowed = f"allowed {joints.LOWER[joint]:.4g} to {joints.UPPER[joint]:.4g}"
    assert message.endswith(f"{allowed} {joints.JOINT_UNITS[joint]}")
    assert "\n" not in message


@pytest.mark.parametrize("q", [[], 3.0, [3.0] * 5, [[3.0] * 6], [0.0] * 7])
def test_a_wrong_shape_is_refused(q):
    with pytest.raises(ValueError, match=r"^q0: shape .*, allowed \(6,\)"):
        joints.check_configuration("q0", q)


@pytest.mark.parametrize("q", [["a"] * 6, [3.0, [1.0], 0, 0, 0, 0], {"d1": 3.0}])
def test_what_is_not_numbers_is_refused(q):
    with pytest.raises(ValueError, match=r"^q0: .*, allowed \(6,\)"):
        joints.check_configuration("q0", q)


def test_add_scara_returns_the_instance_of_six_joints():
    plant = MultibodyPlant(time_step=1e-3)
    instance = robot.add_scara(plant)
    plant.Finalize()
    assert plant.num_positions(instance) == plant.num_actuated_dofs(instance) == 6
    names = plant.GetPositionNames(instance, add_model_instance_prefix=False)
    assert [n.rsplit("_", 1)[0] for n in names] == list(joints.JOINT_NAMES)
    assert plant.HasFrameNamed(robot.TOOL_FRAME, instance)


def test_nominal_inertias_are_the_mean_over_the_workspace():
    plant = MultibodyPlant(time_step=0.0)
    robot.add_scara(plant)
    plant.Finalize()
    context = plant.CreateDefaultContext()
    diagonals = []
    for q in np.random.default_rng(2024).uniform(joints.LOWER, joints.UPPER, (2000, 6)):
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


# The model: what differs from the nominal robot.

SCALES = [1.3, 0.8, 1.1, 0.7, 2.0, 1.5]
MODELS = [robot.RobotModel(SCALES), robot.RobotModel(SCALES, 20.0, [0.1, -0.05, 0.2])]


def plant_of(model=None):
    """A finalized plant with the robot, and its context."""
    plant = MultibodyPlant(time_step=0.0)
    robot.add_scara(plant, model)
    plant.Finalize()
    return plant, plant.CreateDefaultContext()


def postures(count, seed=5):
    return np.random.default_rng(seed).uniform(joints.LOWER, joints.UPPER, (count, 6))


def gravity(plant, context, q):
    plant.SetPositions(context, q)
    return plant.CalcGravityGeneralizedForces(context)


def point_mass(q, offset):
    """Position (3,) in W and Jacobian (3, 6) of a point of the tool frame."""
    X, J = kinematics.forward_kinematics(q), kinematics.jacobian(q)
    arm = X[:3, :3] @ offset
    return X[:3, 3] + arm, J[3:] - np.cross(arm, J[:3].T).T


def test_the_nominal_model_is_the_robot_itself():
    (plain, context), (modelled, other) = plant_of(), plant_of(robot.RobotModel())
    for q in postures(5):
        for p, c in ((plain, context), (modelled, other)):
            p.SetPositions(c, q)
        np.testing.assert_array_equal(plain.CalcMassMatrix(context), modelled.CalcMassMatrix(other))
    assert not modelled.HasBodyNamed("payload")


def test_a_scaled_link_has_its_mass_and_inertia_scaled_and_its_centre_kept():
    (plain, context), (scaled, other) = plant_of(), plant_of(robot.RobotModel(SCALES))
    for index, scale in enumerate(SCALES, start=1):
        before, after = (
            p.GetBodyByName(f"link_{index}").CalcSpatialInertiaInBodyFrame(c)
            for p, c in ((plain, context), (scaled, other))
        )
        assert after.get_mass() == pytest.approx(scale * before.get_mass())
        np.testing.assert_allclose(after.get_com(), before.get_com(), atol=1e-15)
        np.testing.assert_allclose(
            after.CalcRotationalInertia().CopyToFullMatrix3(),
            scale * before.CalcRotationalInertia().CopyToFullMatrix3(),
            atol=1e-12,
        )


def test_the_mass_matrix_is_that_of_the_links_scaled_and_the_drives_as_they_were():
    factor = 1.7
    (plain, context), (scaled, other) = plant_of(), plant_of(robot.RobotModel([factor] * 6))
    drives = np.diag([0.0, 40.0, 25.0, 20.0, 4.0, 1.0])  # reflected, models/README.md
    for q in postures(10):
        plain.SetPositions(context, q)
        scaled.SetPositions(other, q)
        links = plain.CalcMassMatrix(context) - drives
        np.testing.assert_allclose(
            scaled.CalcMassMatrix(other), factor * links + drives, rtol=1e-12, atol=1e-10
        )


@pytest.mark.parametrize("model", MODELS)
def test_the_mast_carries_the_weight_of_the_model(model):
    plant, context = plant_of(model)
    masses = [345.9, 88.0, 139.7, 129.4, 20.8, 11.7]  # Table 3 of the paper
    weight = 9.81 * (np.dot(model.mass_scale, masses) + model.payload_mass)
    for q in postures(5):
        assert gravity(plant, context, q)[0] == pytest.approx(-weight)


@given(
    mass=st.floats(0.1, 100),
    offset=st.lists(st.floats(-0.5, 0.5), min_size=3, max_size=3),
    seed=st.integers(0, 1000),
)
@settings(deadline=None, max_examples=20)
def test_a_payload_is_a_point_mass_in_the_hand(mass, offset, seed):
    (plain, context), (loaded, other) = (
        plant_of(),
        plant_of(robot.RobotModel(payload_mass=mass, payload_offset=offset)),
    )
    (q,) = postures(1, seed)
    p, J = point_mass(q, np.array(offset))
    weight = J.T @ [0.0, 0.0, -9.81 * mass]
    np.testing.assert_allclose(
        gravity(loaded, other, q) - gravity(plain, context, q), weight, rtol=1e-9, atol=1e-8
    )
    added = loaded.CalcMassMatrix(other) - plain.CalcMassMatrix(context)
    np.testing.assert_allclose(added, mass * J.T @ J, rtol=1e-9, atol=1e-8)
    # The parallel axis theorem at joint 2, whose axis is the mast's.
    assert added[1, 1] == pytest.approx(mass * (p[0] ** 2 + p[1] ** 2), rel=1e-9, abs=1e-8)


def test_a_model_keeps_the_looks_the_shapes_and_the_drives_of_the_robot():
    def described(model):
        builder = DiagramBuilder()
        plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.0)
        robot.add_scara(plant, model)
        plant.Finalize()
        inspector = scene_graph.model_inspector()
        shapes = {}
        for role in (Role.kIllustration, Role.kProximity):
            for geometry in inspector.GetAllGeometryIds(role):
                properties = inspector.GetProperties(geometry, role)
                color = (
                    str(properties.GetProperty("phong", "diffuse"))
                    if properties.HasProperty("phong", "diffuse")
                    else ""
                )
                pose = inspector.GetPoseInFrame(geometry).GetAsMatrix4().tolist()
                shapes[role, inspector.GetName(geometry)] = (color, str(pose))
        pairs = len(inspector.GetCollisionCandidates())
        efforts = [
            plant.get_joint_actuator(i).effort_limit() for i in plant.GetJointActuatorIndices()
        ]
        return shapes, pairs, efforts

    shapes, pairs, efforts = described(None)
    assert len(shapes) > 30
    assert described(robot.RobotModel([1.2] * 6, 5.0)) == (shapes, pairs, efforts)


def test_nominal_inertias_do_not_know_the_model():
    before = robot.nominal_inertias().copy()
    plant_of(MODELS[1])
    np.testing.assert_array_equal(robot.nominal_inertias.__wrapped__(), before)


def test_a_model_reads_from_yaml():
    text = "{mass_scale: [1.1, 1, 1, 1, 1, 1], payload_mass: 10}"
    model = yaml_load_typed(schema=robot.RobotModel, data=text, defaults=robot.RobotModel())
    assert model == robot.RobotModel([1.1, 1, 1, 1, 1, 1], 10.0)
    check(model, "robot")


@pytest.mark.parametrize(
    ("model", "named"),
    [
        (robot.RobotModel([1.0] * 5), r"robot\.mass_scale: 5 entries, allowed 6"),
        (robot.RobotModel([0.0] + [1.0] * 5), r"robot\.mass_scale\[0\]: 0\.0, allowed 0\.1 to 10"),
        (robot.RobotModel(payload_mass=-1.0), r"robot\.payload_mass: -1\.0, allowed 0 to 500"),
        (robot.RobotModel(payload_offset=[0.0]), r"robot\.payload_offset: 1 entries, allowed 3"),
        (robot.RobotModel(payload_offset=[0, 0, math.nan]), r"robot\.payload_offset\[2\]: nan"),
    ],
)
def test_a_bad_model_is_named(model, named):
    with pytest.raises(ValueError, match=named):
        check(model, "robot")
