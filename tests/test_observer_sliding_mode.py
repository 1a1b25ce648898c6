import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from kinds import of_kind
from leaf import outputs, ports, tick
from pydrake.systems.framework import Context

from scara_drake import joints, load_scenario, metrics, robot, simulate
from scara_drake.common.fields import check
from scara_drake.control import ismc_law
from scara_drake.control.controller import JointController
from scara_drake.control.observer_law import ESTIMATES, GAINS, observer_begin, observer_law
from scara_drake.control.observer_sliding_mode import ObserverSlidingMode
from scara_drake.control.perturbation_observer import observer_gains
from scara_drake.operator.joint_motion import JointMotion
from scara_drake.robot import chatter_number, inverse_mass_matrices

TS = 1e-3
M_HAT = robot.nominal_inertias()


def controller_and_context(velocity=0.0, **gains) -> tuple[JointController, Context, np.ndarray]:
    controller = ObserverSlidingMode(**gains).make_system(TS)
    controller.set_name("controller")
    context = controller.CreateDefaultContext()
    state = np.concatenate([joints.HOME, np.full(6, velocity)])
    controller.GetInputPort("state").FixValue(context, state)
    offset = np.random.default_rng(1).normal(0, 1e-3, 12)
    offset[6:] = 0.0
    controller.GetInputPort("state_desired").FixValue(context, state + offset)
    return controller, context, offset


def value(controller, context, port):
    return controller.GetOutputPort(port).Eval(context)


def test_ports():
    controller, _, _ = controller_and_context()
    inputs, made = ports(controller)
    assert inputs == {"state": 12, "state_desired": 12, "engaged": 1}
    assert set(made) == {
        "actuation", "actuation_commanded", "saturation", "sliding_variable",
        "velocity_estimate", "perturbation_estimate", "actuation_lagged",
    }  # fmt: skip
    assert set(made.values()) == {6}


def test_starts_at_rest_on_the_sliding_surface():
    controller, context, offset = controller_and_context()
    controller.ExecuteInitializationEvents(context)
    gains = ObserverSlidingMode()
    for port in ("sliding_variable", "velocity_estimate", "perturbation_estimate"):
        np.testing.assert_array_equal(value(controller, context, port), 0.0)
    np.testing.assert_allclose(
        value(controller, context, "actuation_commanded"),
        M_HAT * np.array(gains.k) * np.array(gains.c) * offset[:6],
    )
    before = outputs(controller, context)
    controller.ExecuteInitializationEvents(context)  # once more changes nothing
    np.testing.assert_array_equal(outputs(controller, context), before)


def drive(controller, context, velocities):
    """Feed a motion of 50 samples, with these velocities (50, 6) on the port."""
    controller.ExecuteInitializationEvents(context)
    seen = []
    for k, velocity in enumerate(velocities):
        q = joints.HOME + 1e-3 * np.sin(0.1 * k)
        controller.GetInputPort("state").FixValue(context, np.concatenate([q, velocity]))
        tick(controller, context)
        seen.append(outputs(controller, context))
    return np.array(seen)


def test_the_measured_velocity_changes_nothing():
    rng = np.random.default_rng(0)
    still = drive(*controller_and_context()[:2], np.zeros((50, 6)))
    noise = drive(*controller_and_context()[:2], rng.normal(0, 10.0, (50, 6)))
    np.testing.assert_array_equal(still, noise)


def law_gains(observer, acceleration_feedforward=0.0, effort=np.inf, clamp=np.inf, **law):
    """Gains of one joint."""
    row = ismc_law.GAINS.pack(effort=effort, clamp=clamp, period=TS, **law)
    return GAINS.pack(law=row, observer=observer, acceleration_feedforward=acceleration_feedforward)


@settings(deadline=None, max_examples=50)
@given(st.integers(0, 2**32 - 1))
def test_the_law_is_the_one_stated(seed):
    rng = np.random.default_rng(seed)
    c, k, rho, phi, m_hat = rng.uniform(1.0, 50.0, 5)
    q, v_d, psi, x2, z = rng.normal(0.0, 0.1, 5)
    acceleration = rng.normal()
    # An observer with hardly any gain keeps its estimates, but for their motion over a period.
    gains = law_gains(np.zeros((4, 1)), 1.0, c=c, k=k, rho=rho, phi=phi, m_hat=m_hat)
    memory = np.zeros(ESTIMATES.size)
    m = ESTIMATES.unpack(memory)
    m.x2[:], m.psi[:], m.z[:], m.v_desired[:] = x2, psi, z, v_d - TS * acceleration
    results = np.zeros((4, 1))
    s, tau, limited, saturation = results
    limited[0] = m_hat * 0.3
    x2_after = x2 + TS * (0.3 + psi)
    x1_after = TS * x2 + 0.5 * TS**2 * (0.3 + psi)
    observer_law(np.array([q, v_d]), np.zeros(2), gains, memory, s, tau, limited, saturation)
    e, e_dot = q + TS * v_d - x1_after, v_d - x2_after
    sigma = e_dot + c * e
    u = c * e_dot + k * sigma + rho * np.clip((sigma - z) / phi, -1, 1) - psi + acceleration
    np.testing.assert_allclose(tau[0], m_hat * u, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(m.z[0], z - TS * k * sigma, rtol=1e-9, atol=1e-12)


def joint(c, k, rho, inertia, perturbation, effort=np.inf, duration=2.0):
    """One joint M x'' = u + M d(t), m_hat = 1, held at zero; its positions and its Psi^."""
    observer = observer_gains([200.0], [0.005], TS)
    gains = law_gains(observer, effort=effort, clamp=2.0, c=c, k=k, rho=rho, phi=1.0, m_hat=1.0)
    memory = np.zeros(ESTIMATES.size)
    s, tau, limited, saturation = np.zeros((4, 1))
    x = np.zeros(2)
    history = []
    for n in range(round(duration / TS)):
        law = observer_law if n else observer_begin
        law(np.zeros(2), x, gains, memory, s, tau, limited, saturation)
        history.append([x[0], ESTIMATES.unpack(memory).psi[0], limited[0]])
        a = limited[0] / inertia + perturbation(n * TS)
        x = np.array([x[0] + TS * x[1] + 0.5 * TS**2 * a, x[1] + TS * a])
    return np.array(history)


def test_without_rho_a_constant_load_leaves_no_error():
    history = joint(50.0, 100.0, 0.0, 1.0, lambda t: -9.81)
    assert abs(history[-1, 0]) < 1e-9
    assert history[-1, 1] == pytest.approx(-9.81, abs=1e-6)


@pytest.mark.parametrize("inertia", [1.0 / 3.0, 1.0, 3.0])
def test_the_perturbation_is_what_the_nominal_inertia_does_not_explain(inertia):
    history = joint(50.0, 100.0, 15.0, inertia, lambda t: 4.0, duration=6.0)
    # At rest u = -4 M, and Psi = x'' - u = 4 M.
    assert history[-1, 1] == pytest.approx(4.0 * inertia, rel=1e-6)
    assert abs(history[-1, 0]) < 1e-9


def test_a_saturated_drive_does_not_wind_the_observer_up():
    # A load of 30 that a drive of 20 cannot hold for 0.1 s: the observer knows what really acted.
    history = joint(
        50.0, 100.0, 15.0, 1.0, lambda t: 30.0 if 0.5 < t < 0.6 else 0.0, 20.0, duration=3.0
    )
    assert np.abs(history[:, 1]).max() < 1.05 * 30.0
    assert np.abs(history[:, 2]).max() == 20.0
    np.testing.assert_allclose(history[700:, 1], 0.0, atol=1e-3)
    assert abs(history[-1, 0]) < 1e-6


def held_arm(controller):
    scenario = load_scenario("joint_sine", {"operator.amplitude": 0.0})
    of_kind(JointMotion, scenario.operator).displacement = [0.0] * 6
    scenario.controller = controller
    return simulate(scenario, duration=1.0)


def test_the_observer_finds_the_weight_of_the_arm():
    run = held_arm(ObserverSlidingMode())
    error = metrics.tracking_error(run)
    assert float(abs(error.isel(time=-1)).max()) < 1e-6
    # The whole robot hangs on the mast, and at rest M drops out: Psi = -weight / m_hat.
    weight = float(run.tau_applied.isel(time=-1, joint=0))
    psi = run.perturbation_estimate.isel(time=-1)
    np.testing.assert_allclose(psi, -run.tau_applied.isel(time=-1) / M_HAT, atol=1e-4)
    assert weight > 1e3
    # It does not overshoot by much on the way, and the mast sags by less than a millimetre.
    assert float(abs(run.perturbation_estimate.isel(joint=0)).max()) < 1.5 * weight / M_HAT[0]
    assert float(abs(error.isel(joint=0)).max()) < 1e-3


def test_it_tracks_without_a_velocity():
    scenario = load_scenario("joint_sine")
    scenario.controller = ObserverSlidingMode()
    run = simulate(scenario, duration=3.0).sel(time=slice(1.0, None))
    assert (metrics.rmse(metrics.tracking_error(run)) < 3e-4).all()
    slow = abs(run.v_estimated - run.v_measured).max("time")
    assert (slow < 0.05).all()


def test_acceleration_feedforward_adds_the_inertia_times_the_acceleration():
    efforts = []
    change = np.array([0.3, -1.0, 2.0, 0.5, -4.0, 1.0]) * TS
    for feedforward in (False, True):
        controller, context, _ = controller_and_context(acceleration_feedforward=feedforward)
        controller.ExecuteInitializationEvents(context)
        port = controller.GetInputPort("state_desired")
        desired = port.Eval(context).copy()
        desired[6:] += change
        port.FixValue(context, desired)
        tick(controller, context)
        efforts.append(value(controller, context, "actuation_commanded").copy())
    np.testing.assert_allclose(efforts[1] - efforts[0], M_HAT * change / TS, rtol=1e-9)


def test_drives_take_over_an_arm_that_moves():
    """The observer runs on while the drives are off: it knows the arm when they come back."""
    controller, context, _ = controller_and_context()
    engaged = controller.GetInputPort("engaged")
    engaged.FixValue(context, [0.0])
    controller.ExecuteInitializationEvents(context)
    velocity = np.array([-0.5, 0.1, -0.1, 0.2, 0.3, -0.4])
    for k in range(1, 300):
        state = np.concatenate([joints.HOME + k * TS * velocity, np.zeros(6)])
        desired = np.concatenate([state[:6] - TS * velocity, velocity])
        controller.GetInputPort("state").FixValue(context, state)
        controller.GetInputPort("state_desired").FixValue(context, desired)
        if k == 299:
            engaged.FixValue(context, [1.0])
        tick(controller, context)
        if k < 299:
            np.testing.assert_array_equal(value(controller, context, "actuation"), 0.0)
    np.testing.assert_allclose(value(controller, context, "velocity_estimate"), velocity, rtol=1e-6)
    u = value(controller, context, "actuation_commanded") / M_HAT
    np.testing.assert_allclose(u, 0.0, atol=1e-3)


def test_memory_is_in_the_context():
    controller, context, _ = controller_and_context()
    controller.ExecuteInitializationEvents(context)
    tick(controller, context)
    clone = context.Clone()
    for _ in range(5):
        tick(controller, context)
        tick(controller, clone)
    np.testing.assert_array_equal(outputs(controller, context), outputs(controller, clone))
    np.testing.assert_array_equal(outputs(controller, controller.CreateDefaultContext()), 0.0)


def test_what_is_not_a_number_stops_the_run():
    controller, context, _ = controller_and_context()
    controller.ExecuteInitializationEvents(context)
    values = controller.GetInputPort("state").Eval(context).copy()
    values[3] = np.nan
    controller.GetInputPort("state").FixValue(context, values)
    with pytest.raises(RuntimeError, match=r"controller: port 'state' at t = 0 s: state\[3\]"):
        tick(controller, context)


@pytest.mark.parametrize(
    ("field", "bad"),
    [("k", -1.0), ("rho", float("nan")), ("phi", 0.0), ("pole", 0.0), ("eps", -1.0)],
)
def test_bad_gains_are_refused_by_name(field, bad):
    gains = ObserverSlidingMode()
    getattr(gains, field)[2] = bad
    with pytest.raises(ValueError, match=rf"^controller\.{field}\[2\]: "):
        check(gains, "controller")


def test_sampling_rules():
    ObserverSlidingMode().check_sampling("controller", TS)
    with pytest.raises(ValueError, match=r"^controller\.pole\[0\]: 501.*500"):
        ObserverSlidingMode(pole=[501.0] * 6).check_sampling("controller", TS)
    steep = ObserverSlidingMode(rho=[5000.0] * 6)
    with pytest.raises(ValueError, match="chatters"):
        steep.check_sampling("controller", TS)
    steep.allow_chatter = True
    steep.check_sampling("controller", TS)


def closed_loop(inverse_mass, c, k, slope, pole):
    """The sampled loop of arm, observer and law within the layers, as a matrix (42, 42)."""
    q, v, x1, x2, psi, z, u = np.split(np.eye(42), 7)
    gains = observer_gains(pole, np.ones(6), TS)[:3, :, None]
    v_after = v + TS * (inverse_mass * M_HAT) @ u
    q_after = q + TS * v_after
    predicted = x1 + TS * x2 + 0.5 * TS**2 * (u + psi)
    error = q_after - predicted
    x1_after = predicted + gains[0] * error
    x2_after = x2 + TS * (u + psi) + gains[1] * error
    psi_after = psi + gains[2] * error
    c, k, slope = c[:, None], k[:, None], slope[:, None]
    sigma = -x2_after - c * x1_after
    u_after = slope * (sigma - z) + k * sigma - c * x2_after - psi_after
    z_after = z - TS * k * sigma
    return np.vstack([q_after, v_after, x1_after, x2_after, psi_after, z_after, u_after])


@settings(deadline=None, max_examples=15)
@given(st.integers(0, 2**32 - 1))
def test_gains_that_meet_the_rules_are_stable_at_every_posture(seed):
    rng = np.random.default_rng(seed)
    c, k, slope = rng.uniform(5, 50, 6), rng.uniform(10, 150, 6), rng.uniform(10, 500, 6)
    pole = np.full(6, np.exp(rng.uniform(np.log(20.0), np.log(500.0))))
    number = chatter_number(M_HAT * (c + k + slope), TS)
    scale = min(1.0, 1.95 / number)
    matrices = np.array(
        [
            closed_loop(inverse, scale * c, scale * k, scale * slope, pole)
            for inverse in inverse_mass_matrices()[::23]
        ]
    )
    assert np.abs(np.linalg.eigvals(matrices)).max() < 1.0
