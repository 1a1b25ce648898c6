"""The robot presses on each kind of surface with each law, in the whole plant."""

from __future__ import annotations

import numpy as np
import pytest
from kinds import of_kind
from pydrake.geometry import GeometryId, Role
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, MultibodyPlant
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, System
from pydrake.systems.primitives import ConstantVectorSource, LogVectorOutput

from scara_drake import joints, kinematics, robot
from scara_drake.common.fields import check
from scara_drake.control.integral_sliding_mode import IntegralSlidingMode
from scara_drake.environment import (
    Box,
    Cylinder,
    Environment,
    ImpedanceContact,
    SineMotion,
    Surface,
    Wall,
    add_surfaces,
    tool_contact,
)

TOOL = kinematics.forward_kinematics(joints.HOME)[:3, 3]  # the tool looks along -y


def surface_at(kind: type, depth: float, law: str, name: str = "a") -> Surface:
    """A surface that faces the tool, with its front `depth` [m] above the tool point."""
    if kind is Wall:
        return Wall(name=name, point=(TOOL + np.array([0, depth, 0])).tolist(), law=law)
    if kind is Box:
        return Box(name=name, centre=(TOOL + np.array([0, depth - 0.1, 0])).tolist(), law=law)
    return Cylinder(name=name, point=(TOOL + np.array([0, depth - 0.1, 0])).tolist(), law=law)


class Press:
    """The robot, held at home by its controller, with its tool in the surfaces."""

    def __init__(self, *surfaces: Surface, q: np.ndarray = joints.HOME):
        environment = Environment(list(surfaces))
        check(environment, "environment")
        builder = DiagramBuilder()
        self.plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=1e-3)
        robot.add_scara(self.plant)
        self.shapes = add_surfaces(self.plant, scene_graph, environment)
        self.plant.Finalize()
        self.plant.SetDefaultPositions(q)
        self.contact = builder.AddSystem(ImpedanceContact(environment, 1e-3, self.shapes))
        control = builder.AddSystem(IntegralSlidingMode().make_system(1e-3))
        reference = builder.AddSystem(ConstantVectorSource(np.r_[joints.HOME, np.zeros(6)]))
        state = self.plant.get_state_output_port()
        builder.Connect(state, self.contact.GetInputPort("state"))
        builder.Connect(state, control.GetInputPort("state"))
        builder.Connect(reference.get_output_port(), control.GetInputPort("state_desired"))
        self.actuation = control.GetOutputPort("actuation")
        builder.Connect(self.actuation, self.plant.get_actuation_input_port())
        builder.Connect(
            self.contact.GetOutputPort("generalized_force"),
            self.plant.get_applied_generalized_force_input_port(),
        )
        if self.contact.HasInputPort("contact_results"):
            builder.Connect(
                self.plant.get_contact_results_output_port(),
                self.contact.GetInputPort("contact_results"),
            )
        self.log = LogVectorOutput(self.contact.GetOutputPort("f_env_on_tool_W"), builder, 1e-3)
        self.diagram: Diagram = builder.Build()
        self.simulator = Simulator(self.diagram)

    def context(self) -> Context:
        return self.plant.GetMyContextFromRoot(self.simulator.get_context())

    def output(self, name: str) -> np.ndarray:
        own = self.contact.GetMyContextFromRoot(self.simulator.get_context())
        return self.contact.GetOutputPort(name).Eval(own)


@pytest.mark.parametrize("law", ["impedance", "hunt_crossley", "drake"])
@pytest.mark.parametrize("kind", [Wall, Box, Cylinder])
def test_a_press_of_5_mm_is_50_newton_and_acts_on_the_plant_once(kind: type, law: str) -> None:
    press = Press(surface_at(kind, 0.005, law))
    press.simulator.AdvanceTo(0.4)
    f, penetration = press.output("f_env_on_tool_W"), press.output("penetration")
    assert f[1] == pytest.approx(50.0, rel=1e-3)
    assert penetration[0] == pytest.approx(0.005, rel=1e-3)
    # Only Drake's contact has friction.
    assert np.hypot(f[0], f[2]) < (0.6 * f[1] if law == "drake" else 1e-6)
    # At rest the drives carry the weight and the contact, at the tip of the tool.
    state = press.context()
    assert np.abs(press.plant.GetVelocities(state)).max() < 1e-3
    weight = press.plant.CalcGravityGeneralizedForces(state)
    J = kinematics.jacobian(press.plant.GetPositions(state))[3:]
    controller = of_kind(System, press.actuation.get_system())
    owner = press.diagram.GetSubsystemByName(controller.get_name())
    drives = press.actuation.Eval(owner.GetMyContextFromRoot(press.simulator.get_context()))
    np.testing.assert_allclose(drives, -weight - J.T @ f, atol=1.0)
    expected = np.zeros(6) if law == "drake" else J.T @ f
    np.testing.assert_allclose(press.output("generalized_force"), expected, atol=0.1)


def test_of_surfaces_with_different_laws_each_counts_once() -> None:
    press = Press(surface_at(Wall, 0.005, "impedance"), surface_at(Box, 0.003, "drake", "b"))
    press.simulator.AdvanceTo(0.4)
    np.testing.assert_allclose(press.output("f_env_on_tool_W")[1], 80.0, rtol=1e-3)
    np.testing.assert_allclose(press.output("penetration"), [0.005, 0.003], rtol=1e-3)
    J = kinematics.jacobian(press.plant.GetPositions(press.context()))[3:]
    expected = J.T @ np.array([0, 50.0, 0])
    np.testing.assert_allclose(press.output("generalized_force"), expected, atol=0.1)


def test_drakes_contact_has_the_stiffness_and_the_dissipation_of_the_surface() -> None:
    surface = surface_at(Cylinder, 0.005, "drake")
    surface.stiffness, surface.alpha = 4e3, 0.2
    press = Press(surface)
    inspector = press.plant.EvalSceneGraphInspector(press.context())
    (shape,) = press.shapes.compliant
    properties = inspector.GetProximityProperties(shape)
    assert properties.GetProperty("material", "hunt_crossley_dissipation") == pytest.approx(0.3)
    press.simulator.AdvanceTo(0.4)
    assert press.output("f_env_on_tool_W")[1] == pytest.approx(20.0, rel=1e-3)


def test_what_touches_with_another_link_is_no_force_on_the_tool() -> None:
    plain = MultibodyPlant(0.0)
    robot.add_scara(plain)
    plain.Finalize()
    probe = plain.CreateDefaultContext()
    plain.SetPositions(probe, joints.HOME)
    link = plain.EvalBodyPoseInWorld(probe, plain.GetBodyByName("link_4")) @ [0.3, 0.0, 0.0]
    block = Box(centre=link.tolist(), size=[0.05, 0.05, 0.1], law="drake")
    press = Press(block)
    press.simulator.AdvanceTo(0.005)
    results = press.plant.get_contact_results_output_port().Eval(press.context())
    assert results.num_point_pair_contacts() == 1
    assert not press.output("f_env_on_tool_W").any()
    assert press.output("penetration")[0] == 0.0


@pytest.mark.parametrize("law", ["impedance", "hunt_crossley"])
def test_a_moving_wall_meets_the_state_of_its_own_instant(law: str) -> None:
    wall = surface_at(Wall, 0.005, law)
    wall.motion = SineMotion(amplitude=0.004, frequency=2.0)
    press = Press(wall)
    press.simulator.AdvanceTo(0.1005)  # the plant has stepped to 0.101 s
    state = press.plant.get_state_output_port().Eval(press.context())
    penetration, f, tau = np.empty(1), np.empty(3), np.empty(6)
    tool_contact(0.101, state, Environment([wall]).parameters(), penetration, f, tau)
    assert press.output("f_env_on_tool_W").tobytes() == f.tobytes()
    assert press.output("penetration")[0] == pytest.approx(
        0.005 + 0.004 * np.sin(0.404 * np.pi), abs=5e-5
    )


def test_a_moving_surface_is_not_in_the_plants_geometry() -> None:
    surface = surface_at(Box, 0.005, "impedance")
    surface.motion = SineMotion()
    press = Press(surface)
    world = press.plant.world_body()
    assert not press.plant.GetCollisionGeometriesForBody(world)
    assert not press.plant.GetVisualGeometriesForBody(world)


@pytest.mark.parametrize("kind", [Box, Cylinder])
def test_a_surface_is_drawn_where_the_tool_feels_it(kind: type) -> None:
    surface = surface_at(kind, 0.0, "impedance")
    press = Press(surface)
    inspector = press.plant.EvalSceneGraphInspector(press.context())
    world = press.plant.world_body()
    (solid,) = press.plant.GetCollisionGeometriesForBody(world)
    (visual,) = press.plant.GetVisualGeometriesForBody(world)
    assert inspector.GetProperties(solid, Role.kIllustration) is None
    for shape in (solid, visual):
        distance = _distance(press, shape)
        assert distance == pytest.approx(0.0, abs=1e-9)


def _distance(press: Press, shape: GeometryId) -> float:
    """Distance of the tool point from a shape, from what the scene knows of it."""
    inspector = press.plant.EvalSceneGraphInspector(press.context())
    p = inspector.GetPoseInFrame(shape).inverse() @ TOOL
    found = inspector.GetShape(shape)
    if hasattr(found, "radius"):
        return float(np.hypot(p[0], p[1]) - found.radius())
    return float(np.max(np.abs(p) - np.array([found.width(), found.depth(), found.height()]) / 2))


def test_the_law_drake_needs_the_shapes() -> None:
    with pytest.raises(ValueError, match="shapes: None, allowed"):
        ImpedanceContact(Environment([surface_at(Wall, 0.0, "drake")]))
