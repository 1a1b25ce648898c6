import importlib
import pkgutil

import numpy as np
import pytest
from kinds import of_kind
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import LeafSystem

import scara_drake
from scara_drake import kinematics, load_scenario, make_diagram, simulate, systems
from scara_drake.diagram import start_posture
from scara_drake.environment import Cylinder
from scara_drake.operator.joint_motion import JointMotion
from scara_drake.scenario import scenario_names

LOOP = ["joystick", "mapping", "uplink", "inverse_kinematics", "controller", "plant"]


@pytest.mark.parametrize("name", scenario_names())
def test_every_system_and_exported_port_is_named(name):
    diagram = make_diagram(load_scenario(name))
    assert diagram.get_name() == name
    names = [system.get_name() for system in diagram.GetSystems()]
    assert len(set(names)) == len(names)
    for system in names:
        assert system
        assert "/" not in system
        assert "0x" not in system
    assert diagram.num_output_ports() > 5
    for index in range(diagram.num_output_ports()):
        assert not diagram.get_output_port(index).get_name().startswith("y")


def test_teleoperation_has_the_whole_loop():
    diagram = make_diagram(load_scenario("teleoperation"))
    for name in [*LOOP, "contact", "downlink", "haptics", "scene_graph"]:
        assert diagram.HasSubsystemNamed(name)


def test_a_scenario_without_walls_has_no_contact():
    diagram = make_diagram(load_scenario("free_motion"))
    assert not diagram.HasSubsystemNamed("contact")
    assert not diagram.HasSubsystemNamed("haptics")


def test_effort_within_limits_is_what_the_plant_applies():
    scenario = load_scenario("joint_sine")  # its start asks for more than joint 2 has
    diagram = make_diagram(scenario)
    simulator = Simulator(diagram)
    simulator.AdvanceTo(0.0025)
    context = simulator.get_context()
    plant = of_kind(MultibodyPlant, diagram.GetSubsystemByName("plant"))
    applied = plant.get_net_actuation_output_port().Eval(plant.GetMyContextFromRoot(context))
    controller = diagram.GetSubsystemByName("controller")
    history = controller.GetMyContextFromRoot(context)
    commanded = controller.GetOutputPort("actuation_commanded").Eval(history)
    assert np.abs(commanded[1]) > 8e3
    assert applied[1] == 8e3
    np.testing.assert_allclose(controller.GetOutputPort("actuation").Eval(history)[1], applied[1])


@pytest.mark.parametrize("law", ["impedance", "hunt_crossley", "drake"])
def test_a_press_on_a_pipe_with_any_law(law):
    pipe = f"[!Cylinder {{point: [0.8, -0.8, 3.3], direction: [0, 0, 1], law: {law}}}]"
    scenario = load_scenario("pipe_press", {"environment.surfaces": pipe, "duration": 0.5})
    tool = kinematics.forward_kinematics(start_posture(scenario))[:3, 3]
    touched = of_kind(Cylinder, scenario.environment.surfaces[0])
    touched.point[1] = float(tool[1]) - 0.095  # 5 mm inside
    force = simulate(scenario).isel(time=-1).f_env_on_tool_W.values
    assert force[1] == pytest.approx(50.0, rel=0.1)


def test_the_contact_force_acts_on_the_plant():
    """Pressing shifts the drives' effort by the transpose of the Jacobian times the force."""
    recording = simulate(load_scenario("teleoperation"))
    # The sustained hold of the shipped trace: nearly at rest.
    hold = recording.sel(time=slice(24.0, 25.0)).mean("time")
    free = simulate(
        load_scenario(
            "joint_sine",
            {
                "operator": {"_tag": "!JointMotion", "base": hold.q_measured.values.tolist()},
                "duration": 1.0,
            },
        )
    ).isel(time=-1)
    force = hold.f_env_on_tool_W.values
    assert np.linalg.norm(force) > 100.0
    torque = kinematics.jacobian(hold.q_measured.values)[3:].T @ force
    np.testing.assert_allclose(
        (free.tau_applied - hold.tau_applied).values[1:],
        torque[1:],
        atol=0.06 * np.abs(torque).max(),
    )


def test_start_posture_is_given_or_found():
    scenario = load_scenario("teleoperation", {"q0": [4.0, 0.1, 0.0, 0.2, 0.3, 0.0]})
    np.testing.assert_array_equal(start_posture(scenario), [4.0, 0.1, 0.0, 0.2, 0.3, 0.0])
    motion = load_scenario("joint_sine")
    base = of_kind(JointMotion, motion.operator).base
    np.testing.assert_array_equal(start_posture(motion), base)


# What others are made of.
BASES = {"Block", "JointController"}


def leaf_systems():
    """Names of the LeafSystems that the package declares by `class` in a module of its own."""
    for module in pkgutil.walk_packages(scara_drake.__path__, "scara_drake."):
        # The other imports what an extra installs.
        if not module.name.endswith(("__main__", "exports.rerun_file")):
            for name, one in vars(importlib.import_module(module.name)).items():
                ours = isinstance(one, type) and one.__module__ == module.name
                if ours and issubclass(one, LeafSystem):
                    yield name.partition("_")[0]  # of a template, its name


def test_systems_gathers_every_leaf_system():
    for name in systems.__all__:
        assert issubclass(getattr(systems, name), LeafSystem)
    assert {*leaf_systems()} - BASES == {*systems.__all__}
    assert {
        "JoystickSource",
        "JoystickToPose",
        "InverseKinematicsSystem",
        "IntegralSlidingModeController",
        "SignalDelay",
        "ImpedanceContact",
        "HapticOutput",
    } <= set(systems.__all__)


@pytest.mark.parametrize("name", scenario_names())
def test_a_cloned_context_in_a_new_simulator_goes_on_to_the_bit(name):
    """Its initialization leaves alone what is running, without being told to."""
    diagram = make_diagram(load_scenario(name))
    simulator = Simulator(diagram)
    simulator.AdvanceTo(0.1005)
    fork = Simulator(diagram, simulator.get_context().Clone())
    ends = []
    for each in (simulator, fork):
        each.AdvanceTo(0.1305)
        found = each.get_context().get_discrete_state()
        ends.append([found.value(i).copy() for i in range(found.num_groups())])
    for one, two in zip(*ends, strict=True):
        assert one.tobytes() == two.tobytes()
