from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from kinds import of_kind
from pydrake import geometry
from pydrake.common.yaml import yaml_load_typed
from pydrake.geometry import Role
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, Diagram, DiagramBuilder

from scara_drake import joints, kinematics, robot
from scara_drake.common.fields import check
from scara_drake.environment import (
    Box,
    ConstantVelocity,
    Cylinder,
    Environment,
    ImpedanceContact,
    SineMotion,
    Surface,
    Wall,
    add_surfaces,
    contact_force,
    tool_contact,
)
from scara_drake.scenario import dump_scenario, load_scenario

settings.register_profile("kernels", deadline=None)  # the first call of a kernel compiles it
settings.load_profile("kernels")

NORMALS = st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda n: np.linalg.norm(n) > 0.1)
SMALL = st.tuples(*[st.floats(-0.5, 0.5)] * 3)
STATES = st.tuples(
    *[
        st.floats(float(low), float(high))
        for low, high in zip(joints.LOWER, joints.UPPER, strict=True)
    ],
    *[st.floats(-2, 2)] * 6,
)


def unit(normal: Iterable[float]) -> list[float]:
    vector = np.array(list(normal))
    return (vector / np.linalg.norm(vector)).tolist()


def force(wall: Wall, p: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, float]:
    penetration, f = np.empty(1), np.empty(3)
    contact_force(0.0, p, v, Environment([wall]).parameters(), penetration, f)
    return f, penetration[0]


def wall_through_tool(q: np.ndarray, depth: float, normal: Iterable[float] = (0, 1, 0)) -> Wall:
    """A wall whose surface is `depth` above the tool point of posture q."""
    n = unit(normal)
    p = kinematics.forward_kinematics(q)[:3, 3]
    return Wall(point=(p + depth * np.array(n)).tolist(), normal=n)


def test_one_centimetre_into_ten_kilonewton_per_metre_is_100_newton() -> None:
    f, d = force(Wall(point=[0, 0, 0]), np.array([0.3, -0.01, 0.2]), np.zeros(3))
    np.testing.assert_allclose(f, [0, 100, 0], rtol=1e-12)
    assert d == pytest.approx(0.01)


@given(normal=NORMALS, depth=st.floats(1e-3, 0.05), v=SMALL, slide=SMALL)
def test_beyond_the_blend_the_force_is_equation_52(normal, depth, v, slide) -> None:
    n, v = np.array(unit(normal)), np.array(v)
    wall = Wall(point=[0.1, 0.2, 0.3], normal=n.tolist())
    along = np.array(slide) - n * np.dot(n, slide)
    f, d = force(wall, np.array(wall.point) + along - depth * n, v)
    assert d == pytest.approx(depth, abs=1e-12)
    expected = max(0.0, 1e4 * depth - 100.0 * np.dot(n, v))
    np.testing.assert_allclose(f, expected * n, atol=1e-7)


@given(normal=NORMALS, height=st.floats(0, 1), v=SMALL)
def test_outside_there_is_no_force(normal, height, v) -> None:
    n = np.array(unit(normal))
    f, d = force(Wall(point=[0, 0, 0], normal=n.tolist()), (height + 1e-12) * n, np.array(v))
    assert not f.any()
    assert d == 0.0


@given(depth=st.floats(0, 0.02), speed=st.floats(-3, 3))
def test_the_wall_never_pulls(depth, speed) -> None:
    f, _ = force(Wall(point=[0, 0, 0]), np.array([0, -depth, 0]), np.array([0, speed, 0]))
    assert f[1] >= 0.0


def test_a_fast_retreat_has_no_force_where_the_raw_equation_pulls() -> None:
    depth, speed = 2e-3, 0.5  # K d = 20 N, B d' = -50 N
    f, _ = force(Wall(point=[0, 0, 0]), np.array([0, -depth, 0]), np.array([0, speed, 0]))
    assert not f.any()


def test_entering_at_200_mm_per_s_steps_by_less_than_8_newton_a_millisecond() -> None:
    # The raw equation steps by B v = 20 N at touch.
    for phase in np.linspace(0, 1, 11):
        depths = 0.2e-3 * (np.arange(-3, 40) + phase)
        entry = [
            force(Wall(point=[0, 0, 0]), np.array([0, -d, 0]), np.array([0, -0.2, 0]))[0][1]
            for d in depths
        ]
        assert np.abs(np.diff(entry)).max() < 8.0
        assert entry[-1] == pytest.approx(1e4 * depths[-1] + 20.0)


def test_the_forces_of_two_walls_add_up() -> None:
    corner = Environment([Wall(name="a", point=[0, 0, 0]), Wall("b", [0, 0, 0], [1.0, 0, 0])])
    penetration, f = np.empty(2), np.empty(3)
    contact_force(
        0.0, np.array([-0.02, -0.01, 5]), np.zeros(3), corner.parameters(), penetration, f
    )
    np.testing.assert_allclose(f, [200, 100, 0])
    np.testing.assert_allclose(penetration, [0.01, 0.02])


@given(state=STATES, depth=st.floats(1e-4, 0.05), normal=NORMALS)
def test_the_generalized_force_does_the_power_of_the_force(state, depth, normal) -> None:
    state = np.array(state)
    wall = wall_through_tool(state[:6], depth, normal)
    penetration, f, tau = np.empty(1), np.empty(3), np.empty(6)
    tool_contact(0.0, state, Environment([wall]).parameters(), penetration, f, tau)
    # The velocity of the tool point by central differences of its position.
    h = 1e-6
    ahead, behind = (
        kinematics.forward_kinematics(state[:6] + s * state[6:])[:3, 3] for s in (h, -h)
    )
    power = np.dot(f, ahead - behind) / (2 * h)
    assert np.dot(tau, state[6:]) == pytest.approx(power, abs=1e-5 * (1 + float(np.linalg.norm(f))))


def robot_diagram(environment: Environment) -> tuple[Diagram, MultibodyPlant, ImpedanceContact]:
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=1e-3)
    robot.add_scara(plant)
    add_surfaces(plant, scene_graph, environment)
    plant.Finalize()
    contact = builder.AddSystem(ImpedanceContact(environment))
    builder.Connect(plant.get_state_output_port(), contact.GetInputPort("state"))
    builder.Connect(
        contact.GetOutputPort("generalized_force"),
        plant.get_applied_generalized_force_input_port(),
    )
    return builder.Build(), plant, contact


@settings(max_examples=20)
@given(state=STATES, normal=NORMALS)
def test_force_and_generalized_force_agree_with_drake(plant, state, normal) -> None:
    state = np.array(state)
    context = plant.CreateDefaultContext()
    plant.SetPositionsAndVelocities(context, state)
    frame, world = plant.GetFrameByName("tool"), plant.world_frame()
    J = plant.CalcJacobianTranslationalVelocity(
        context, JacobianWrtVariable.kV, frame, np.zeros(3), world, world
    )
    wall = wall_through_tool(state[:6], 0.05, normal)
    penetration, f, tau = np.empty(1), np.empty(3), np.empty(6)
    tool_contact(0.0, state, Environment([wall]).parameters(), penetration, f, tau)
    n = np.array(wall.normal)
    expected = max(0.0, 1e4 * 0.05 - 100.0 * float(n @ J @ state[6:])) * n
    np.testing.assert_allclose(f, expected, atol=1e-6)
    np.testing.assert_allclose(tau, J.T @ f, atol=1e-6)


@pytest.fixture(scope="module")
def plant() -> MultibodyPlant:
    plant = MultibodyPlant(0.0)
    robot.add_scara(plant)
    plant.Finalize()
    return plant


# The LeafSystem on a bare Context.


@pytest.fixture
def pressed() -> tuple[ImpedanceContact, Context]:
    system = ImpedanceContact(Environment([wall_through_tool(joints.HOME, 0.01)]))
    context = system.CreateDefaultContext()
    system.GetInputPort("state").FixValue(context, np.r_[joints.HOME, np.zeros(6)])
    return system, context


def outputs(system: ImpedanceContact, context: Context) -> list[np.ndarray]:
    return [system.get_output_port(i).Eval(context) for i in range(system.num_output_ports())]


def test_ports() -> None:
    system = ImpedanceContact(Environment([Wall("a"), Wall("b")]))
    assert {port.get_name(): port.size() for port in map(system.get_output_port, range(3))} == {
        "f_env_on_tool_W": 3,
        "generalized_force": 6,
        "penetration": 2,
    }
    assert system.GetInputPort("state").size() == 12
    assert system.num_input_ports() == 1
    assert not system.HasAnyDirectFeedthrough()


def test_the_initial_output_is_the_contact_of_the_initial_state(pressed) -> None:
    system, context = pressed
    assert not outputs(system, context)[0].any()
    Simulator(system, context).Initialize()
    f, tau, penetration = outputs(system, context)
    np.testing.assert_allclose(f, [0, 100, 0], atol=1e-9)
    np.testing.assert_allclose(penetration, [0.01], atol=1e-12)
    np.testing.assert_allclose(tau, kinematics.jacobian(joints.HOME)[3:].T @ f, atol=1e-9)


def test_update_follows_the_input_every_millisecond(pressed) -> None:
    system, context = pressed
    simulator = Simulator(system, context)
    simulator.Initialize()
    q = joints.HOME + np.array([0, 0.02, 0, 0, 0, 0])
    system.GetInputPort("state").FixValue(context, np.r_[q, np.zeros(6)])
    simulator.AdvanceTo(0.0005)  # the update at t = 0 has run at Initialize or in this step
    simulator.AdvanceTo(0.0015)
    depth = (
        0.01 + (kinematics.forward_kinematics(joints.HOME) - kinematics.forward_kinematics(q))[1, 3]
    )
    np.testing.assert_allclose(outputs(system, context)[2], [max(depth, 0.0)], atol=1e-12)


def test_a_cloned_context_gives_the_same_bits_and_a_second_run_starts_clean(pressed) -> None:
    system, context = pressed
    clone, fresh = context.Clone(), context.Clone()
    runs = []
    for one in (context, clone, fresh):
        simulator = Simulator(system, one)
        simulator.AdvanceTo(0.0055)
        runs.append(outputs(system, one))
    for run in runs[1:]:
        for a, b in zip(runs[0], run, strict=True):
            assert a.tobytes() == b.tobytes()


def test_free_space_has_an_empty_penetration_and_no_force() -> None:
    system = ImpedanceContact(Environment())
    context = system.CreateDefaultContext()
    system.GetInputPort("state").FixValue(context, np.r_[joints.HOME, np.ones(6)])
    Simulator(system, context).AdvanceTo(0.0015)
    f, tau, penetration = outputs(system, context)
    assert penetration.shape == (0,)
    assert not f.any()
    assert not tau.any()


# In a plant.


def test_the_force_is_that_of_the_state_from_which_the_plant_steps_next() -> None:
    wall = wall_through_tool(joints.HOME, 0.005)
    diagram, plant, contact = robot_diagram(Environment([wall]))
    simulator = Simulator(diagram)
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    plant.SetPositions(context, joints.HOME)
    simulator.AdvanceTo(0.0205)
    state = plant.get_state_output_port().Eval(context)
    assert np.linalg.norm(state[6:]) > 1e-2  # it moves, so that a tick of delay would show
    penetration, f, tau = np.empty(1), np.empty(3), np.empty(6)
    tool_contact(0.0, state, Environment([wall]).parameters(), penetration, f, tau)
    own = contact.GetMyContextFromRoot(simulator.get_context())
    assert contact.GetOutputPort("f_env_on_tool_W").Eval(own).tobytes() == f.tobytes()
    assert f[1] > 0.0


@pytest.mark.parametrize(("link", "expected"), [("link_6", 0), ("link_4", 1)])
def test_drakes_contact_stops_every_link_but_the_tool(link: str, expected: int) -> None:
    plain = MultibodyPlant(0.0)
    robot.add_scara(plain)
    plain.Finalize()
    probe = plain.CreateDefaultContext()
    plain.SetPositions(probe, joints.HOME)
    body = plain.GetBodyByName(link)
    middle = plain.EvalBodyPoseInWorld(probe, body) @ (
        [0.0, 0.0, 0.5] if link == "link_6" else [0.3, 0.0, 0.0]
    )
    # A small block through the middle of that link alone.
    wall = Wall(point=middle.tolist(), size=[0.1, 0.1], thickness=0.05)
    diagram, plant, _ = robot_diagram(Environment([wall]))
    root = diagram.CreateDefaultContext()
    context = plant.GetMyMutableContextFromRoot(root)
    plant.SetPositions(context, joints.HOME)
    query = plant.get_geometry_query_input_port().Eval(context)
    pairs = query.ComputePointPairPenetration()
    assert len(pairs) == expected
    inspector = query.inspector()
    for pair in pairs:
        names = {inspector.GetName(pair.id_A), inspector.GetName(pair.id_B)}
        assert names == {"scara6::link_4_shape", "wall_shape"}


def test_a_wall_is_drawn_with_its_front_on_the_surface() -> None:
    wall = Wall(point=[1, 2, 3], normal=unit([1, 1, 0.2]), size=[1.5, 1.0], thickness=0.2)
    diagram, plant, _ = robot_diagram(Environment([wall]))
    inspector = plant.EvalSceneGraphInspector(
        plant.GetMyContextFromRoot(diagram.CreateDefaultContext())
    )
    (shape,) = plant.GetCollisionGeometriesForBody(plant.world_body())
    visuals = plant.GetVisualGeometriesForBody(plant.world_body())
    assert len(visuals) == 5
    box, X_WB = of_kind(geometry.Box, inspector.GetShape(shape)), inspector.GetPoseInFrame(shape)
    assert (box.width(), box.depth(), box.height()) == (1.5, 1.0, 0.2)
    np.testing.assert_allclose(X_WB @ np.array([0, 0, 0.1]), wall.point, atol=1e-12)
    np.testing.assert_allclose(X_WB.rotation().col(2), wall.normal, atol=1e-12)
    assert X_WB.rotation().col(0)[2] == pytest.approx(0)  # the width is level
    assert inspector.GetIllustrationProperties(visuals[0]) is not None
    assert inspector.GetProperties(shape, Role.kIllustration) is None


@pytest.mark.parametrize("normal", [[0.0, 0, 1], [0.0, 0, -1], [1.0, 0, 0], [0.0, -1, 0]])
def test_the_pose_of_a_wall_is_right_handed_for_any_normal(normal: list[float]) -> None:
    R = Wall(normal=normal).pose().rotation().matrix()
    assert np.linalg.det(R) == pytest.approx(1.0)
    np.testing.assert_allclose(R[:, 2], normal)


# Configuration.


def test_yaml() -> None:
    text = "surfaces:\n- {name: panel, point: [1, 0, 3], stiffness: 5000}\n"
    environment = yaml_load_typed(schema=Environment, data=text, defaults=Environment())
    check(environment, "environment")
    assert environment.names() == ["panel"]
    assert environment.surfaces[0].stiffness == 5000
    assert environment.surfaces[0].damping == 100


@pytest.mark.parametrize(
    ("wall", "field"),
    [
        (Wall(point=[0, 0]), "point: 2 entries"),
        (Wall(normal=[0, 2, 0]), "normal"),
        (Wall(normal=[0.0, 0.5, 0]), "normal: length 0.5"),
        (Wall(size=[1.0, 0.0]), "size"),
        (Wall(stiffness=float("nan")), "stiffness: nan"),
        (Wall(damping=-1.0), "damping: -1"),
        (Wall(blend=0.0), "blend: 0"),
        (Wall(thickness=0.0), "thickness: 0"),
        (Wall(name=""), "name"),
    ],
)
def test_invalid_walls_name_the_field(wall: Wall, field: str) -> None:
    with pytest.raises(ValueError, match=rf"environment\.surfaces\[0\]\.{field}.*allowed"):
        check(Environment([wall]), "environment")


SURFACES = """
- {name: panel, point: [1, 0, 3]}
- !Wall {name: door, motion: {velocity: [0, 0.1, 0]}}
- !Box {name: table, law: hunt_crossley, exponent: 1.5, motion: !SineMotion {amplitude: 0.01}}
- !Cylinder {law: drake, stiffness: 5000}
"""


def test_surfaces_of_all_kinds_in_a_scenario() -> None:
    scenario = load_scenario("teleoperation", {"environment.surfaces": SURFACES})
    surfaces = scenario.environment.surfaces
    assert [type(surface) for surface in surfaces] == [Wall, Wall, Box, Cylinder]
    assert scenario.environment.names() == ["panel", "door", "table", "pipe"]
    assert surfaces[0] == Wall(name="panel", point=[1.0, 0.0, 3.0])
    assert surfaces[1].motion == ConstantVelocity([0.0, 0.1, 0.0])
    assert surfaces[2] == Box(
        "table", law="hunt_crossley", exponent=1.5, motion=SineMotion(amplitude=0.01)
    )
    assert surfaces[3] == Cylinder(law="drake", stiffness=5000.0)


def test_a_scenario_with_all_kinds_of_surface_survives_being_written(tmp_path: Path) -> None:
    scenario = load_scenario("teleoperation", {"environment.surfaces": SURFACES})
    path = tmp_path / "written.yaml"
    path.write_text(dump_scenario(scenario))
    assert load_scenario(path).environment == scenario.environment


@pytest.mark.parametrize(
    ("surfaces", "message"),
    [
        ("[!Pipe {}]", r"environment\.surfaces\[0\]: 'Pipe', allowed Wall, Box, Cylinder"),
        ("[{}, !Box {radius: 1}]", r"environment\.surfaces\[1\]\.radius: unknown field"),
        ("[!Cylinder {size: [1, 1]}]", r"environment\.surfaces\[0\]\.size: unknown field"),
        ("[3]", r"environment\.surfaces\[0\]: 3, allowed the fields of Wall or Box or Cylinder"),
        ("[!Wall {motion: !Jump {}}]", r"surfaces\[0\]\.motion: 'Jump', allowed ConstantVelocity"),
        ("[!Wall {motion: 3}]", r"surfaces\[0\]\.motion: 3, allowed the fields of"),
    ],
)
def test_wrong_surfaces_of_a_scenario_are_named(surfaces: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        load_scenario("teleoperation", {"environment.surfaces": surfaces})


@pytest.mark.parametrize(
    ("surface", "field"),
    [
        (Box(centre=[0, 0]), "centre: 2 entries"),
        (Box(rpy=[0, 0, 9.0]), r"rpy\[2\]: 9"),
        (Box(size=[1.0, 0.0, 1.0]), r"size\[1\]: 0"),
        (Box(size=[1.0, 0.1, 1.0], edge_radius=0.06), "edge_radius: 0.06"),
        (Box(name="a/b"), "name: 'a/b'"),
        (Cylinder(point=[0]), "point: 1 entries"),
        (Cylinder(direction=[0, 1.0, 1.0]), "direction: length 1.414"),
        (Cylinder(radius=0.0), "radius: 0"),
        (Cylinder(length=-1.0), "length: -1"),
        (Cylinder(edge_radius=0.2), "edge_radius: 0.2"),
        (Wall(law="spring"), "law: 'spring'"),
        (Wall(exponent=2.0), "exponent: 2"),
        (Wall(alpha=-0.1), "alpha: -0.1"),
        (Wall(law="drake", stiffness=0.0), "stiffness: 0"),
        (Wall(law="drake", motion=SineMotion()), "motion: set"),
        (Wall(motion=SineMotion(direction=[0, 2.0, 0])), r"motion\.direction"),
        (Wall(motion=SineMotion(frequency=-1.0)), r"motion\.frequency: -1"),
        (Wall(motion=SineMotion(amplitude=float("inf"))), r"motion\.amplitude: inf"),
        (Wall(motion=SineMotion(phase=20.0)), r"motion\.phase: 20"),
        (Wall(motion=ConstantVelocity([0, 3.0, 0])), r"motion\.velocity\[1\]: 3"),
    ],
)
def test_invalid_surfaces_name_the_field(surface: Surface, field: str) -> None:
    with pytest.raises(ValueError, match=rf"environment\.surfaces\[0\]\.{field}.*allowed"):
        check(Environment([surface]), "environment")


def test_two_walls_of_one_name_are_refused() -> None:
    with pytest.raises(ValueError, match=r"surfaces\[1\]\.name: 'wall'"):
        check(Environment([Wall(), Wall()]), "environment")
