"""A Diagram's inputs: an operator, and forces, from outside."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from kinds import of_kind
from pydrake.geometry import QueryObject
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator

import scara_drake as sd
from scara_drake.operator.external import SPOKEN
from scara_drake.recordings.recorder import recording

SHORT = 0.0505  # [s]
UNSUPERVISED = [port for port in SPOKEN if port != "command_frame"]


def external(name: str, port: str, **overrides):
    operator = f"!External {{port: {port}}}"
    return sd.make_diagram(sd.load_scenario(name, {"operator": operator, **overrides}))


def run_with(diagram, inputs: dict[str, list[float]], until: float = SHORT):
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    for name, value in inputs.items():
        diagram.GetInputPort(name).FixValue(context, value)
    simulator.AdvanceTo(until)
    return recording(diagram, context)


@pytest.mark.parametrize("port", UNSUPERVISED)
def test_unconnected_it_is_the_centred_stick_and_no_force(port: str, tmp_path) -> None:
    still = tmp_path / "still.csv"
    still.write_text("time,x,y,z,mast_axis,mast_hat\n0,0,0,0,0,0\n")
    settings = {"operator.trace": str(still), "logging.period": 0.001}
    wanted = run_with(sd.make_diagram(sd.load_scenario("teleoperation", settings)), {})
    found = run_with(external("teleoperation", port), {})
    for name in ("q_measured", "tau_applied", "p_WE_commanded", "f_env_on_tool_W"):
        np.testing.assert_array_equal(found[name], wanted[name])


def test_a_stick_from_outside_moves_the_tool_as_the_same_stick_in_a_trace(tmp_path) -> None:
    stick = [0.3, -0.4, 0.5, 0.0, 1.0]
    held = tmp_path / "held.csv"
    held.write_text("time,x,y,z,mast_axis,mast_hat\n0," + ",".join(map(str, stick)) + "\n")
    trace = sd.make_diagram(sd.load_scenario("free_motion", {"operator.trace": str(held)}))
    found = run_with(external("free_motion", "joystick_axes"), {"joystick_axes": stick})
    wanted = run_with(trace, {})
    np.testing.assert_array_equal(found.p_WE_commanded, wanted.p_WE_commanded)
    np.testing.assert_array_equal(found.q_measured, wanted.q_measured)
    np.testing.assert_array_equal(found.joystick_axes, wanted.joystick_axes)


def test_a_command_from_outside_is_what_the_channel_carries() -> None:
    diagram = external("free_motion", "tool_command")
    command = [0.7, -0.7, 3.1, *np.sqrt([0.5, 0.5, 0.0, 0.0]), 3.1]
    found = run_with(diagram, {"tool_command": command})
    assert diagram.GetInputPort("tool_command").size() == len(command)
    np.testing.assert_array_equal(found.p_WE_commanded[-1], command[:3])
    assert "mapping" not in [system.get_name() for system in diagram.GetSystems()]


@pytest.mark.parametrize("port", UNSUPERVISED)
def test_what_is_not_finite_stops_the_run(port: str) -> None:
    diagram = external("free_motion", port)
    size = diagram.GetInputPort(port).size()
    with pytest.raises(RuntimeError, match="external"):
        run_with(diagram, {port: [np.nan] * size})


@pytest.mark.parametrize("name", ["joint_sine", "teleoperation", "bilateral"])
def test_a_force_from_outside_accelerates_the_joint(name: str) -> None:
    """M dv = F dt in the first step, whatever else acts on the joints."""
    force = np.array([500.0, 80.0, 50.0, 40.0, 8.0, 2.0])
    diagram = sd.make_diagram(sd.load_scenario(name))
    plant = of_kind(MultibodyPlant, diagram.GetSubsystemByName("plant"))
    states = []
    for inputs in ({}, {"applied_generalized_force": force}):
        simulator = Simulator(diagram)
        context = simulator.get_mutable_context()
        for port, value in inputs.items():
            diagram.GetInputPort(port).FixValue(context, value)
        simulator.AdvanceTo(0.0005)  # the step at t = 0
        inner = plant.GetMyContextFromRoot(context)
        states.append(plant.GetVelocities(inner))
    M = plant.CalcMassMatrix(inner)
    damping = np.diag([100.0, 10.0, 5.0, 5.0, 0.5, 0.1])
    expected = np.linalg.solve(M + 1e-3 * damping, force * 1e-3)
    np.testing.assert_allclose(states[1] - states[0], expected, rtol=1e-3, atol=1e-9)


def test_sensors_and_cameras_find_their_ports() -> None:
    diagram = sd.make_diagram(sd.load_scenario("teleoperation"))
    context = diagram.CreateDefaultContext()
    assert isinstance(diagram.GetOutputPort("query_object").Eval(context), QueryObject)
    plant = of_kind(MultibodyPlant, diagram.GetSubsystemByName("plant"))
    poses = diagram.GetOutputPort("body_poses").Eval(context)
    assert len(poses) == plant.num_bodies()
    for name in ("contact_results", "body_spatial_velocities", "reaction_forces", "net_actuation"):
        diagram.GetOutputPort(name).Eval(context)


def test_a_kind_of_operator_that_is_not_known_is_one_line() -> None:
    @dataclass
    class Mine:
        gain: float = 1.0

    scenario = sd.load_scenario("free_motion")
    scenario.operator = Mine()  # type: ignore[assignment]  # that is the case
    with pytest.raises(ValueError, match=r"^operator: 'Mine', allowed .*External.*$"):
        sd.make_diagram(scenario)
