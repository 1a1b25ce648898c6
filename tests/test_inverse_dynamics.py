import gc

import numpy as np
import pytest
from kinds import of_kind
from leaf import ports
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import MultibodyForces
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from scara_drake import kinematics, load_scenario, robot, simulate
from scara_drake.common.fields import check
from scara_drake.control.inverse_dynamics import InverseDynamics, integrate_error
from scara_drake.diagram import make_diagram
from scara_drake.joints import EFFORT, HOME, LOWER, UPPER
from scara_drake.operator.joint_motion import JointMotion

TS = 1e-3


@pytest.fixture(scope="module")
def plant():
    plant = MultibodyPlant(time_step=0.0)
    robot.add_scara(plant)
    plant.Finalize()
    return plant


def inverse_dynamics(plant, state, acceleration):
    """Drake's own answer: the drives' effort of an acceleration (6,) in a state (12,)."""
    context = plant.CreateDefaultContext()
    plant.SetPositionsAndVelocities(context, state)
    forces = MultibodyForces(plant)
    plant.CalcForceElementsContribution(context, forces)
    return plant.CalcInverseDynamics(context, acceleration, forces)


def held(controller, q0=None, **model):
    """A scenario with the arm held at rest by a controller."""
    scenario = load_scenario("joint_sine", {"operator.amplitude": 0.0})
    motion = of_kind(JointMotion, scenario.operator)
    motion.displacement, motion.base = [0.0] * 6, HOME.tolist()
    scenario.controller = controller
    scenario.q0 = None if q0 is None else list(q0)
    for name, value in model.items():
        setattr(scenario.robot, name, value)
    return scenario


def test_ports_are_those_of_a_controller():
    system = InverseDynamics().make_system(TS)
    assert ports(system) == (
        {"state": 12, "state_desired": 12},
        {"actuation": 6, "actuation_commanded": 6},
    )


def test_the_effort_is_drakes_inverse_dynamics_of_the_commanded_acceleration(plant):
    gains = InverseDynamics()
    system = gains.make_system(TS)
    context = system.CreateDefaultContext()
    rng = np.random.default_rng(0)
    for q in rng.uniform(LOWER, UPPER, (20, 6)):
        state = np.concatenate([q, rng.normal(0, 0.5, 6)])
        error = rng.normal(0, [2e-3] * 6 + [0.1] * 6)
        system.GetInputPort("state").FixValue(context, state)
        system.GetInputPort("state_desired").FixValue(context, state + error)
        commanded = system.GetOutputPort("actuation_commanded").Eval(context)
        a = np.array(gains.kp) * error[:6] + np.array(gains.kd) * error[6:]
        np.testing.assert_allclose(
            commanded, inverse_dynamics(plant, state, a), rtol=1e-9, atol=1e-6
        )
        limited = np.clip(commanded, -EFFORT, EFFORT)
        np.testing.assert_array_equal(system.GetOutputPort("actuation").Eval(context), limited)


def test_it_tracks_the_sines_with_what_it_lacks_the_acceleration():
    scenario = load_scenario("joint_sine")
    scenario.controller = InverseDynamics()
    run = simulate(scenario, duration=3.5)
    time = run.time.values[2000:]
    error = (run.q_desired - run.q_measured).values[2000:]
    # Joints 2 and 4: e (s³ + kd s² + kp s + ki) = s a of the reference, at 1.25 rad/s.
    w, gains = 1.25, scenario.controller
    s = 1j * w
    response = s / (s**3 + gains.kd[1] * s**2 + gains.kp[1] * s + gains.ki[1])
    # The measured rate of a stepped plant is half a period old.
    response *= 1.0 - 0.5 * TS * gains.kd[1]
    acceleration = 0.7854 * w**2
    expected = np.imag(-acceleration * response * np.exp(1j * w * time))
    for joint in (1, 3):
        atol = 0.03 * np.abs(expected).max()
        np.testing.assert_allclose(error[:, joint], expected, rtol=0, atol=atol)
    assert np.abs(error[:, [2, 4, 5]]).max() < 1e-7  # the mass matrix cancels: no coupling


def test_state_and_reference_are_of_one_instant(plant):
    scenario = load_scenario("joint_sine")
    scenario.controller = gains = InverseDynamics(ki=[0.0] * 6)
    run = simulate(scenario, duration=0.4)
    k = 350
    state = np.concatenate([run.q_measured[k], run.v_measured[k]])
    desired = np.concatenate([run.q_desired[k], run.v_desired[k]])
    a = np.array(gains.kp) * (desired - state)[:6] + np.array(gains.kd) * (desired - state)[6:]
    np.testing.assert_allclose(run.tau_applied[k], inverse_dynamics(plant, state, a), rtol=1e-6)


def test_the_integral_takes_away_what_an_unknown_payload_leaves(plant):
    last = {}
    for ki in (0.0, 2e5):
        run = simulate(held(InverseDynamics(ki=[ki] * 6), payload_mass=20.0), duration=1.5)
        last[ki] = np.abs(run.q_desired - run.q_measured)[-1]
    # Without it the weight, led to the joints, is held by M kp e.
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, HOME)
    weight = kinematics.jacobian(HOME)[5] * 20.0 * 9.81
    expected = np.linalg.solve(plant.CalcMassMatrix(context), weight) / 14000.0
    np.testing.assert_allclose(last[0.0], np.abs(expected), rtol=0.02, atol=1e-6)
    assert (last[2e5] < 0.01 * np.abs(expected).max()).all()


def test_gains_at_the_limit_of_the_rule_settle_and_beyond_it_chatter(monkeypatch):
    speeds = {}
    for kd in (1900.0, 2100.0):
        controller = InverseDynamics(kp=[1e4] * 6, ki=[0.0] * 6, kd=[kd] * 6)
        scenario = held(controller, HOME + 1e-5)
        if kd < 2000.0:
            controller.check_sampling("controller", TS)
        else:
            with pytest.raises(ValueError, match=r"^controller: chatters, .* below 2"):
                controller.check_sampling("controller", TS)
            monkeypatch.setattr(InverseDynamics, "check_sampling", lambda *_, **__: None)
        run = simulate(scenario, duration=0.5)
        speeds[kd] = np.abs(run.v_measured[-50:, 1:]).max()
    assert speeds[1900.0] < 1e-3 < 1e-2 < speeds[2100.0]


def test_runs_repeat_to_the_bit_on_the_same_diagram():
    scenario = load_scenario("joint_sine")
    scenario.controller = InverseDynamics()
    diagram = make_diagram(scenario)
    ends = []
    for _ in range(2):
        simulator = Simulator(diagram)
        simulator.AdvanceTo(0.05)
        ends.append(diagram.GetOutputPort("state").Eval(simulator.get_context()))
    np.testing.assert_array_equal(*ends)


def test_the_nominal_robot_lives_as_long_as_the_controller():
    builder = DiagramBuilder()
    builder.AddNamedSystem("controller", InverseDynamics().make_system(TS))
    diagram = builder.Build()
    del builder
    gc.collect()
    system = diagram.GetSubsystemByName("controller")
    context = system.CreateDefaultContext()
    state = np.concatenate([HOME, np.zeros(6)])
    system.GetInputPort("state").FixValue(context, state)
    system.GetInputPort("state_desired").FixValue(context, state)
    effort = system.GetOutputPort("actuation").Eval(context)
    np.testing.assert_allclose(effort[0], 735.5 * 9.81, rtol=1e-9)


@pytest.mark.parametrize("port", ["state", "state_desired"])
def test_what_is_not_a_number_stops_the_run_and_names_port_and_time(port):
    builder = DiagramBuilder()
    system = builder.AddNamedSystem("controller", InverseDynamics().make_system(TS))
    good = np.concatenate([HOME, np.zeros(6)])
    bad = good.copy()
    bad[3] = np.nan
    for name in ("state", "state_desired"):
        values = np.transpose([good, bad if name == port else good, good])
        breaks = PiecewisePolynomial.ZeroOrderHold([0.0, 0.0195, 1.0], values)
        source = builder.AddNamedSystem(f"{name}_source", TrajectorySource(breaks))
        builder.Connect(source.get_output_port(), system.GetInputPort(name))
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(0.0192)
    message = rf"controller: port '{port}' at t = 0\.0(19|20)\d* s: {port}\[3\] is nan"
    with pytest.raises(RuntimeError, match=message):
        simulator.AdvanceTo(0.1)


def test_the_integral_sums_the_error_and_holds_at_the_limit():
    rng = np.random.default_rng(0)
    desired, state = rng.normal(size=(2, 12))
    error = desired[:6] - state[:6]
    ki, integral = np.arange(1.0, 7.0), np.zeros(6)
    effort = np.full(6, 10.0)
    tau = np.array([9.0, 11.0, 11.0, -9.0, -11.0, -11.0]) * np.sign(error)
    integrate_error(desired, state, tau, effort, ki, TS, integral)
    counted = np.array([1, 0, 0, 1, 1, 1])
    np.testing.assert_allclose(integral, TS * ki * error * counted, rtol=1e-12)


def test_an_effort_at_its_limit_does_not_wind_the_integral_up():
    # The reference steps by 0.3 rad: the drives are at their limits, and overshoot even without.
    overshoot = []
    start = HOME + np.array([0.0, 0.3, 0.0, 0.0, 0.0, 0.0])
    for ki in (0.0, 2e5):
        run = simulate(held(InverseDynamics(ki=[ki] * 6), start), duration=1.5)
        assert int((run.tau_applied != run.tau_commanded).sum()) > 100
        error = (run.q_desired - run.q_measured).sel(joint="theta2")
        overshoot.append(float(error.max()))
        assert abs(float(error[-1])) < 1e-5
    assert overshoot[1] < 1.2 * overshoot[0]


@pytest.mark.parametrize("field", ["kp", "ki", "kd"])
@pytest.mark.parametrize("value", [-1.0, np.nan])
def test_bad_gains_are_refused_by_name(field, value):
    gains = InverseDynamics()
    getattr(gains, field)[5] = value
    with pytest.raises(ValueError, match=rf"^controller\.{field}\[5\]: "):
        check(gains, "controller")
