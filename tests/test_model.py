"""models/scara6.urdf against the paper's tables, an independent chain, and rigid-body physics."""

import xml.etree.ElementTree as ET
from itertools import pairwise

import numpy as np
import pytest
from pydrake.geometry import Role, SceneGraph, Sphere
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable, PrismaticJoint, RevoluteJoint
from pydrake.systems.framework import DiagramBuilder

from scara_drake import joints, kinematics, robot
from scara_drake.common.resources import resource

# Tables 1 to 3 of the paper: d [m] (None: the mast's joint), a [m], alpha, mass [kg].
TABLE_1 = [
    (None, 0.0, 0.0),
    (0.0, 0.0, -np.pi / 2),
    (0.750, 0.0, np.pi / 2),
    (0.0, 0.820, 0.0),
    (0.0, 0.0, np.pi / 2),
    (0.730, 0.0, 0.0),
]
MASSES = [345.9, 88.0, 139.7, 129.4, 20.8, 11.7]
FRICTION = CoulombFriction(0.5, 0.5)
REFLECTED_INERTIAS = [0.0, 40.0, 25.0, 20.0, 4.0, 1.0]
G = 9.81
LINKS = [f"link_{i}" for i in range(1, 7)]
# Mass of each drawn solid [kg], as the table of models/README.md states; the rest is trim.
SOLIDS = {
    "link_1": {"tube_1": 60.0, "tube_2": 75.0, "tube_3": 95.0, "tube_4": 115.9},
    "link_2": {"turret": 30.0, "shoulder": 48.0, "roll_drive": 10.0},
    "link_3": {
        "beam_flange": 15.7,
        "beam": 64.0,
        "fork_bridge": 20.0,
        "fork_upper": 10.0,
        "fork_lower": 10.0,
        "elbow_drive_upper": 10.0,
        "elbow_drive_lower": 10.0,
    },
    "link_4": {
        "elbow_hub": 24.0,
        "forearm": 81.4,
        "wrist_cheek_upper": 12.0,
        "wrist_cheek_lower": 12.0,
    },
    "link_5": {"wrist_hub": 8.8, "wrist_body": 12.0},
    "link_6": {"spindle_motor": 9.0, "saw_gearbox": 1.2, "saw_disc": 1.5},
}


@pytest.fixture(scope="module")
def plant() -> MultibodyPlant:
    plant = MultibodyPlant(time_step=0.0)
    robot.add_scara(plant)
    plant.Finalize()
    return plant


@pytest.fixture
def context(plant):
    return plant.CreateDefaultContext()


@pytest.fixture(scope="module")
def urdf() -> ET.Element:
    return ET.parse(resource("models", "scara6.urdf")).getroot()


def configurations(count: int, seed: int = 1) -> np.ndarray:
    return np.random.default_rng(seed).uniform(joints.LOWER, joints.UPPER, (count, 6))


def dh_poses(q: np.ndarray) -> list[np.ndarray]:
    """Poses of the links' frames L_i in W, and of E, as the product of the rows of Table 1."""

    def rotation(axis: int, angle: float) -> np.ndarray:
        i, j = [(1, 2), (2, 0), (0, 1)][axis]
        T = np.eye(4)
        T[i, i] = T[j, j] = np.cos(angle)
        T[i, j], T[j, i] = -np.sin(angle), np.sin(angle)
        return T

    def translation(x: float, z: float) -> np.ndarray:
        T = np.eye(4)
        T[0, 3], T[2, 3] = x, z
        return T

    poses, T = [], np.eye(4)
    for value, (d, a, alpha) in zip(q, TABLE_1, strict=True):
        if d is None:
            T = T @ translation(0.0, value)
            poses.append(T)
        else:
            T = T @ rotation(2, value)
            poses.append(T)
            T = T @ translation(0.0, d)
        T = T @ translation(a, 0.0) @ rotation(0, alpha)
    return [*poses, T]


def numbers(text: str) -> np.ndarray:
    return np.array(text.split(), dtype=float)


def gravity(plant, context, q: np.ndarray) -> np.ndarray:
    plant.SetPositions(context, q)
    return plant.CalcGravityGeneralizedForces(context)


def test_it_has_exactly_the_six_joints_of_the_paper(plant):
    assert plant.num_positions() == plant.num_velocities() == plant.num_actuated_dofs() == 6
    assert plant.num_actuators() == 6
    for i, (name, lower, upper) in enumerate(
        zip(joints.JOINT_NAMES, joints.LOWER, joints.UPPER, strict=True)
    ):
        joint = plant.GetJointByName(name)
        assert isinstance(joint, PrismaticJoint if i == 0 else RevoluteJoint)
        assert joint.position_start() == joint.velocity_start() == i
        assert joint.position_lower_limits()[0] == lower
        assert joint.position_upper_limits()[0] == upper
        assert joint.velocity_upper_limits()[0] == joints.MAX_SPEED[i]
        assert joint.velocity_lower_limits()[0] == -joints.MAX_SPEED[i]
        assert joint.child_body().name() == f"link_{i + 1}"


def test_two_robots_fit_in_one_plant_under_their_names():
    plant = MultibodyPlant(time_step=1e-3)
    first = robot.add_scara(plant)
    second = robot.add_scara(plant, robot.RobotModel(mass_scale=[2.0] * 6), name="left")
    with pytest.raises(ValueError, match=r"^name: 'left', allowed one that no model instance"):
        robot.add_scara(plant, name="left")
    plant.Finalize()
    assert plant.num_positions(first) == plant.num_positions(second) == 6
    context = plant.CreateDefaultContext()
    masses = [plant.CalcTotalMass(context, [each]) for each in (first, second)]
    np.testing.assert_allclose(masses, [735.5, 1471.0])
    assert plant.GetModelInstanceName(second) == "left"


def test_the_ranges_are_those_of_table_2(urdf):
    table = [(2.5, 10.0), (-360, 360), (-360, 360), (-135, 135), (-135, 135), (-360, 360)]
    limits = [
        joint.find("limit") for joint in urdf.iter("joint") if joint.find("limit") is not None
    ]
    assert len(limits) == 6
    for i, (limit, expected) in enumerate(zip(limits, table, strict=True)):
        scale = 1.0 if i == 0 else np.pi / 180
        values = [float(limit.get(side)) for side in ("lower", "upper")]
        np.testing.assert_allclose(values, np.multiply(expected, scale), rtol=1e-15)


def test_the_drives_have_the_stated_limits_and_reflected_inertias(plant, context):
    plant.SetPositions(context, joints.HOME)
    for i, name in enumerate(joints.JOINT_NAMES):
        actuator = plant.GetJointActuatorByName(name)
        assert actuator.joint().name() == name
        assert actuator.input_start() == i
        assert actuator.effort_limit() == joints.EFFORT[i]
        reflected = actuator.calc_reflected_inertia(context)
        assert reflected == pytest.approx(REFLECTED_INERTIAS[i], abs=1e-9)


def test_friction_is_light(plant):
    damping = np.array(
        [plant.GetJointByName(name).default_damping_vector()[0] for name in joints.JOINT_NAMES]
    )
    assert np.all(damping > 0)
    assert np.all(damping * joints.MAX_SPEED < 0.005 * joints.EFFORT)


def test_masses_are_those_of_table_3(plant, context):
    masses = [plant.GetBodyByName(link).default_mass() for link in LINKS]
    assert masses == MASSES
    assert plant.GetBodyByName("tool").default_mass() == 0.0
    assert plant.CalcTotalMass(context) == pytest.approx(735.5, abs=1e-9)


def test_the_mast_carries_the_weight_of_the_machine(plant, context):
    np.testing.assert_allclose(plant.gravity_field().gravity_vector(), [0, 0, -G])
    for q in configurations(20):
        assert gravity(plant, context, q)[0] == pytest.approx(-735.5 * G, abs=1e-6)
    assert abs(gravity(plant, context, joints.HOME)[0] + 7215) < 0.5


@pytest.mark.parametrize("link", LINKS)
def test_inertias_belong_to_a_possible_body(plant, context, link):
    body = plant.GetBodyByName(link)
    inertia = body.CalcSpatialInertiaInBodyFrame(context)
    assert inertia.IsPhysicallyValid()
    central = inertia.Shift(inertia.get_com()).CalcRotationalInertia().CopyToFullMatrix3()
    small, middle, large = np.linalg.eigvalsh(central)
    assert small > 0
    assert small + middle >= large


@pytest.mark.parametrize("link", LINKS)
def test_inertias_are_those_of_the_drawn_solids(plant, context, urdf, link):
    visuals = {v.get("name"): v for v in urdf.find(f"link[@name='{link}']").iter("visual")}
    mass, moment, about_origin = 0.0, np.zeros(3), np.zeros((3, 3))
    for name, m in SOLIDS[link].items():
        origin, shape = visuals[name].find("origin"), visuals[name].find("geometry")[0]
        if shape.tag == "box":
            squares = numbers(shape.get("size")) ** 2
        else:  # a cylinder's second moments are those of a box of sides sqrt(3) r, sqrt(3) r, l
            radius, length = float(shape.get("radius")), float(shape.get("length"))
            squares = np.array([3 * radius**2, 3 * radius**2, length**2])
        R = RollPitchYaw(numbers(origin.get("rpy", "0 0 0"))).ToRotationMatrix().matrix()
        p = numbers(origin.get("xyz"))
        covariance = R @ np.diag(squares / 12) @ R.T + np.outer(p, p)
        mass += m
        moment += m * p
        about_origin += m * (np.trace(covariance) * np.eye(3) - covariance)
    inertia = plant.GetBodyByName(link).CalcSpatialInertiaInBodyFrame(context)
    assert inertia.get_mass() == pytest.approx(mass, abs=1e-9)
    np.testing.assert_allclose(inertia.get_com(), moment / mass, atol=1e-10)
    rotational = inertia.CalcRotationalInertia().CopyToFullMatrix3()
    np.testing.assert_allclose(rotational, about_origin, rtol=1e-8, atol=1e-8)


def test_forward_kinematics_is_the_dh_chain(plant, context):
    frames = [plant.GetFrameByName(name) for name in (*LINKS, robot.TOOL_FRAME)]
    for q in configurations(100):
        plant.SetPositions(context, q)
        for frame, expected in zip(frames, dh_poses(q), strict=True):
            X = frame.CalcPoseInWorld(context).GetAsMatrix4()
            np.testing.assert_allclose(X, expected, rtol=0, atol=1e-12)
        np.testing.assert_allclose(X, kinematics.forward_kinematics(q), rtol=0, atol=1e-12)


def test_jacobian_is_drakes(plant, context):
    world, tool = plant.world_frame(), plant.GetFrameByName(robot.TOOL_FRAME)
    for q in configurations(100):
        plant.SetPositions(context, q)
        J = plant.CalcJacobianSpatialVelocity(
            context, JacobianWrtVariable.kV, tool, np.zeros(3), world, world
        )
        np.testing.assert_allclose(kinematics.jacobian(q), J, rtol=0, atol=1e-12)


def test_drives_hold_the_arm_anywhere_with_margin(plant, context):
    sampled = np.max([np.abs(gravity(plant, context, q)) for q in configurations(3000)], axis=0)
    # Levers at the worst: the forearm and the tool horizontal in one line, links at mid-length.
    elbow = G * (129.4 * 0.41 + 20.8 * 0.82 + 11.7 * (0.82 + 0.365))
    wrist = G * 11.7 * 0.365
    worst = np.array([735.5 * G, 0.0, elbow, elbow, wrist, 0.0])
    np.testing.assert_allclose(worst, [7215, 0, 824, 824, 42, 0], atol=1.0)
    assert np.all(sampled <= worst + 1e-9)
    assert np.all(sampled >= 0.9 * worst - 1e-9)
    straight = np.array([3.0, 0.0, 0.0, 0.0, np.pi / 2, 0.0])  # the tool continues the forearm
    np.testing.assert_allclose(abs(gravity(plant, context, straight)[2]), elbow, rtol=1e-9)
    upright = np.array([3.0, 0.0, np.pi / 2, -np.pi / 2, np.pi / 2, 0.0])  # joint 4's axis level
    np.testing.assert_allclose(abs(gravity(plant, context, upright)[[3, 4]]), [elbow, wrist])
    assert np.all(1.8 * worst <= joints.EFFORT)


def test_the_scara_configuration_loads_only_joints_1_and_3(plant, context):
    for q in configurations(50):
        q[2] = 0.0
        np.testing.assert_allclose(gravity(plant, context, q)[[1, 3, 4, 5]], 0.0, atol=1e-9)


def test_the_mass_matrix_is_well_behaved_with_the_drives(plant, context):
    for q in configurations(200):
        plant.SetPositions(context, q)
        M = plant.CalcMassMatrix(context)
        assert np.all(np.linalg.eigvalsh(M) > 0)
        assert np.all(np.diag(M) >= REFLECTED_INERTIAS)


def scene(sphere: np.ndarray | None = None):
    """Plant, scene graph and context of the robot, beside a fixed 5 cm sphere at a point of W."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 1e-3)
    robot.add_scara(plant)
    if sphere is not None:
        plant.RegisterCollisionGeometry(
            plant.world_body(), RigidTransform(sphere), Sphere(0.05), "foreign", FRICTION
        )
    plant.Finalize()
    context = builder.Build().CreateDefaultContext()
    return plant, scene_graph, context


def contacts(plant, scene_graph: SceneGraph, context, q: np.ndarray) -> list:
    plant.SetPositions(plant.GetMyMutableContextFromRoot(context), q)
    query = scene_graph.get_query_output_port().Eval(scene_graph.GetMyContextFromRoot(context))
    return query.ComputePointPairPenetration()


def test_the_links_never_touch_one_another():
    plant, scene_graph, context = scene()
    for q in [*configurations(300), np.array([3.0, 0.0, 0.0, -np.pi / 2, 0.0, 0.0])]:
        assert contacts(plant, scene_graph, context, q) == []


@pytest.mark.parametrize(
    ("frame", "point", "struck"),
    [(3, [0.4, 0.12, 0.0], "link_4_shape"), (6, [0.0, 0.0, 0.02], "link_6_far")],
    ids=["forearm", "tool"],
)
def test_a_foreign_body_on_the_arm_is_felt(frame, point, struck):
    X_WF = dh_poses(joints.HOME)[frame]
    plant, scene_graph, context = scene(X_WF[:3, :3] @ point + X_WF[:3, 3])
    pairs = contacts(plant, scene_graph, context, joints.HOME)
    inspector = scene_graph.model_inspector()
    names = {inspector.GetName(g).split("::")[-1] for p in pairs for g in (p.id_A, p.id_B)}
    assert struck in names
    assert max(pair.depth for pair in pairs) > 0.01
    higher = joints.HOME + np.array([1.0, 0, 0, 0, 0, 0])
    assert contacts(plant, scene_graph, context, higher) == []


def test_few_collision_shapes_and_none_on_the_gantry():
    plant, scene_graph, _ = scene()
    inspector = scene_graph.model_inspector()
    assert inspector.NumGeometriesWithRole(Role.kProximity) == 12
    for link, count in zip(LINKS, (1, 1, 3, 3, 1, 3), strict=True):
        assert len(plant.GetCollisionGeometriesForBody(plant.GetBodyByName(link))) == count
    assert not plant.GetCollisionGeometriesForBody(plant.GetBodyByName("base"))


def test_every_link_is_drawn_in_the_stated_colours():
    plant, scene_graph, _ = scene()
    inspector = scene_graph.model_inspector()

    def colours(link: str) -> set[tuple[float, ...]]:
        ids = plant.GetVisualGeometriesForBody(plant.GetBodyByName(link))
        properties = [inspector.GetIllustrationProperties(i) for i in ids]
        rgba = [p.GetProperty("phong", "diffuse") for p in properties]
        return {(c.r(), c.g(), c.b(), c.a()) for c in rgba}

    orange, grey, steel = (1.0, 0.42, 0.05, 1.0), (0.24, 0.25, 0.27, 1.0), (0.72, 0.75, 0.78, 1.0)
    for link in LINKS[:5]:
        assert {orange, grey} <= colours(link)
    assert {grey, steel} == colours("link_6")
    assert orange not in colours("base")


def test_the_mast_reaches_its_housing_at_the_lowest_height(urdf):
    def top_and_bottom(link: str, name: str) -> tuple[float, float]:
        visual = urdf.find(f"link[@name='{link}']/visual[@name='{name}']")
        z = float(visual.find("origin").get("xyz").split()[2])
        half = float(visual.find("geometry")[0].get("size").split()[2]) / 2
        return z + half, z - half

    tubes = [top_and_bottom("link_1", f"tube_{i}") for i in range(1, 5)]
    for (top, _), (_, bottom) in pairwise(tubes):
        assert bottom < top  # no gap between two sections
    assert all(bottom > 0 for _, bottom in tubes)
    assert joints.LOWER[0] + tubes[-1][0] > top_and_bottom("base", "mast_guide")[1]


def test_the_gantry_stands_outside_the_reach(urdf):
    for leg in urdf.findall("link[@name='base']/visual"):
        if leg.get("name").startswith(("leg", "sill", "tie", "brace")):
            x = float(leg.find("origin").get("xyz").split()[0])
            assert abs(x) - 0.25 > 1.5 * kinematics.REACH


# What other readers of URDF ask for: MuJoCo, Pinocchio, PyBullet, yourdfpy, urchin, rerun and
# check_urdf refuse a file, or take 1 kg for a link, where one of these does not hold.


def test_every_link_of_a_joint_is_declared_and_the_tree_has_one_root(urdf):
    links = [link.get("name") for link in urdf.findall("link")]
    assert len(set(links)) == len(links)
    parents = [joint.find("parent").get("link") for joint in urdf.findall("joint")]
    children = [joint.find("child").get("link") for joint in urdf.findall("joint")]
    assert set(parents) | set(children) == set(links)
    assert len(set(children)) == len(children)
    assert set(links) - set(children) == {"world"}


def test_all_shapes_are_those_of_the_urdf_standard(urdf):
    sizes = {"box": {"size"}, "cylinder": {"radius", "length"}, "sphere": {"radius"}}
    for geometry in urdf.iter("geometry"):
        (shape,) = geometry
        assert shape.tag in sizes
        assert set(shape.attrib) == sizes[shape.tag]


def test_every_link_but_the_world_states_its_inertia(urdf):
    masses = {}
    for link in urdf.findall("link"):
        if link.get("name") == "world":
            assert len(link) == 0
            continue
        masses[link.get("name")] = float(link.find("inertial/mass").get("value"))
        assert set(link.find("inertial/inertia").attrib) == {
            f"i{pair}" for pair in ("xx", "xy", "xz", "yy", "yz", "zz")
        }
    assert masses == {"base": 0.0, **dict(zip(LINKS, MASSES, strict=True)), "tool": 0.0}


def test_elements_of_drake_stand_only_where_others_skip_them(urdf):
    """In a transmission's actuator, and at the top level."""
    parents = {child: parent for parent in urdf.iter() for child in parent}
    for element in urdf.iter():
        if "drake.mit.edu" in element.tag:
            above = parents[element]
            while "drake.mit.edu" in above.tag:
                above = parents[above]
            assert above.tag in ("robot", "actuator")


def test_a_cylinder_with_spheres_at_its_ends_is_a_capsule(urdf):
    for link, ends in {"link_3": 2, "link_4": 2, "link_6": 2}.items():
        shapes = urdf.findall(f"link[@name='{link}']/collision")
        cylinder, *spheres = shapes
        origin, size = cylinder.find("origin"), cylinder.find("geometry/cylinder")
        R = RollPitchYaw(numbers(origin.get("rpy", "0 0 0"))).ToRotationMatrix().matrix()
        half = float(size.get("length")) / 2 * R[:, 2]
        centres = [numbers(sphere.find("origin").get("xyz")) for sphere in spheres]
        expected = [numbers(origin.get("xyz")) + sign * half for sign in (-1, 1)]
        np.testing.assert_allclose(centres, expected, atol=1e-12)
        assert len(spheres) == ends
        for sphere in spheres:
            assert sphere.find("geometry/sphere").get("radius") == size.get("radius")
