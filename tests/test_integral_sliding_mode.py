import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from leaf import outputs, ports, tick
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator

from scara_drake import load_scenario, robot, simulate
from scara_drake.control.integral_sliding_mode import (
    IntegralSlidingMode,
    IntegralSlidingModeController,
    ismc_law,
    sliding_surface,
)

TS = 1e-3
ONES = np.ones(6)
NO_LIMIT = np.full(6, 1e12)


def rows(k, rho, phi, m_hat=ONES, effort=NO_LIMIT):
    """Gains as the law takes them; each is a number or (6,)."""
    return np.array([np.broadcast_to(row, 6) for row in (0.0, k, rho, phi, m_hat, effort)], float)


def run_law(sigmas, z, gains):
    """Apply the law to sigma samples (n, 6); return u (n, 6), s (n, 6) and the last z."""
    z = z.copy()
    s, tau, limited = np.empty(6), np.empty(6), np.empty(6)
    efforts, surfaces = [], []
    for sigma in sigmas:
        ismc_law(sigma, gains, TS, z, s, tau, limited)
        efforts.append(limited.copy())
        surfaces.append(s.copy())
    return np.array(efforts), np.array(surfaces), z


@settings(deadline=None, max_examples=50)
@given(st.integers(0, 2**32 - 1))
def test_inside_the_layer_the_law_is_the_pid_of_the_audit(seed):
    # u = a e' + (a c + k rho/phi) e + (k c rho/phi) int e + const, a = k + rho/phi, with the
    # integral as the sum of samples, for which sum(e' Ts) = e - e(0) where e' is the next slope.
    rng = np.random.default_rng(seed)
    k, c, rho = rng.uniform(1, 150, 6), rng.uniform(1, 50, 6), rng.uniform(1, 500, 6)
    phi = rng.uniform(0.5, 2.0, 6)
    e = np.cumsum(rng.normal(0, 1e-6, (200, 6)), axis=0)
    e_dot = np.diff(e, axis=0) / TS
    e = e[:-1]
    sigma = e_dot + c * e
    u, s, _ = run_law(sigma, sigma[0], rows(k, rho, phi))
    assert (np.abs(s) < phi).all()
    a = k + rho / phi
    integral = TS * (np.cumsum(e, axis=0) - e)
    constant = -(rho / phi) * sigma[0] - (k * rho / phi) * e[0]
    pid = a * e_dot + (a * c + k * rho / phi) * e + (k * c * rho / phi) * integral + constant
    np.testing.assert_allclose(u, pid, rtol=0, atol=1e-9 * max(1.0, np.abs(pid).max()))


def scalar_plant(disturbance, sigma0, k, rho, phi, duration, h):
    """Integrate sigma' = d - u with the law every h; return times and (sigma, s)."""
    n = round(duration / h)
    sigma = np.full(6, sigma0)
    z = sigma.copy()
    s, tau, limited = np.empty(6), np.empty(6), np.empty(6)
    history = np.empty((n, 2))
    gains = rows(k, rho, phi)
    for i in range(n):
        ismc_law(sigma, gains, h, z, s, tau, limited)
        history[i] = sigma[0], s[0]
        sigma = sigma + h * (disturbance - limited)
    return h * np.arange(n), history


def test_without_perturbation_sigma_decays_at_k():
    k, h = 50.0, 1e-6
    t, history = scalar_plant(0.0, 0.3, k, 150.0, 1.0, 0.06, h)
    np.testing.assert_allclose(history[:, 0], 0.3 * np.exp(-k * t), atol=2e-5)
    assert np.abs(history[:, 1]).max() < 1e-9


def test_constant_perturbation_follows_the_closed_form_within_its_bound():
    k, rho, phi, d, h = 50.0, 150.0, 1.0, 30.0, 1e-6
    t, history = scalar_plant(d, 0.0, k, rho, phi, 0.06, h)
    expected = d * (np.exp(-rho * t / phi) - np.exp(-k * t)) / (k - rho / phi)
    np.testing.assert_allclose(history[:, 0], expected, atol=2e-5)
    assert np.abs(history[:, 1]).max() <= phi * d / rho + 1e-6


@given(
    st.floats(-1e3, 1e3),
    st.floats(-1e3, 1e3),
    st.floats(0, 200),
    st.floats(0, 500),
    st.floats(0.01, 5.0),
)
def test_effort_and_integral_keep_their_bounds(sigma, z, k, rho, phi):
    gains = rows(k, rho, phi, effort=25.0)
    u, _, z_next = run_law(np.full((1, 6), sigma), np.full(6, z), gains)
    assert (np.abs(u) <= 25.0).all()
    assert (np.abs(sigma - z_next) <= 2.0 * phi * (1 + 1e-9) + 1e-9 * abs(sigma)).all()


def test_windup_clamp_recovers_at_once():
    # A perturbation of twice rho for 0.5 s: without the clamp |s| would grow to 75.
    k, rho, phi = 50.0, 150.0, 1.0
    h, sigma = TS, np.zeros(6)
    z, s, tau, limited = np.zeros(6), np.empty(6), np.empty(6), np.empty(6)
    gains = rows(k, rho, phi)
    largest = 0.0
    for i in range(700):
        ismc_law(sigma, gains, h, z, s, tau, limited)
        sigma = sigma + h * ((300.0 if i < 500 else 0.0) - limited)
        largest = max(largest, abs(s[0]))
    assert largest < 3.0
    assert abs(sigma[0]) < 0.02


def test_sliding_surface_carries_the_reference_along_its_velocity():
    desired, state = np.arange(12.0), np.ones(12)
    sigma = np.empty(6)
    c = np.full(6, 3.0)
    sliding_surface(desired, state, c, 0.5, sigma)
    expected = (desired[6:] - 1.0) + 3.0 * (desired[:6] + 0.5 * desired[6:] - 1.0)
    np.testing.assert_allclose(sigma, expected)


@pytest.mark.parametrize(
    ("field", "value"),
    [("k", -1.0), ("rho", float("nan")), ("phi", 0.0), ("c", float("inf"))],
)
def test_bad_gains_are_refused_by_name(field, value):
    gains = IntegralSlidingMode()
    getattr(gains, field)[2] = value
    with pytest.raises(ValueError, match=rf"^controller\.{field}\[2\]: "):
        gains.validate("controller")


def controller_and_context():
    controller = IntegralSlidingModeController(IntegralSlidingMode())
    context = controller.CreateDefaultContext()
    rng = np.random.default_rng(1)
    state = np.concatenate([robot.HOME, np.zeros(6)])
    controller.GetInputPort("state").FixValue(context, state)
    offset = rng.normal(0, 1e-3, 12)
    controller.GetInputPort("state_desired").FixValue(context, state + offset)
    return controller, context, offset


def test_ports():
    controller, _, _ = controller_and_context()
    assert ports(controller) == (
        {"state": 12, "state_desired": 12},
        {"actuation": 6, "actuation_commanded": 6, "sliding_variable": 6},
    )


def test_starts_on_the_sliding_surface():
    controller, context, offset = controller_and_context()
    controller.ExecuteInitializationEvents(context)
    gains = IntegralSlidingMode()
    sigma = offset[6:] + np.array(gains.c) * offset[:6]
    np.testing.assert_array_equal(controller.GetOutputPort("sliding_variable").Eval(context), 0)
    np.testing.assert_allclose(
        controller.GetOutputPort("actuation_commanded").Eval(context),
        robot.nominal_inertias() * np.array(gains.k) * sigma,
    )


def test_memory_is_in_the_context():
    controller, context, _ = controller_and_context()
    controller.ExecuteInitializationEvents(context)
    tick(controller, context)
    clone = context.Clone()
    for _ in range(5):
        tick(controller, context)
        tick(controller, clone)
    np.testing.assert_array_equal(outputs(controller, context), outputs(controller, clone))
    fresh = controller.CreateDefaultContext()
    np.testing.assert_array_equal(outputs(controller, fresh), 0.0)


def test_the_loop_has_no_extra_tick():
    """The effort that acts on a step is the law of the state from which the step starts."""
    scenario = load_scenario("joint_sine")
    scenario.duration = 0.05
    run = simulate(scenario)
    k = 30  # any sample: what is logged at t_k has acted on nothing yet
    state = np.concatenate([run.q_measured[k], run.v_measured[k]])
    bare = MultibodyPlant(time_step=scenario.time_step)
    robot.add_scara(bare)
    bare.Finalize()
    bare_context = bare.CreateDefaultContext()
    bare.SetPositionsAndVelocities(bare_context, state)
    bare.get_actuation_input_port().FixValue(bare_context, run.tau_applied[k].values)
    simulator = Simulator(bare, bare_context)
    simulator.Initialize()
    simulator.AdvanceTo(0.5 * scenario.time_step)  # the tick at 0, and no other
    following = np.concatenate([run.q_measured[k + 1], run.v_measured[k + 1]])
    np.testing.assert_allclose(
        bare.GetPositionsAndVelocities(bare_context), following, rtol=0, atol=1e-9
    )
    # And the effort at t_k is the law of the state at t_k.
    gains = scenario.controller
    sigma = np.empty(6)
    desired = np.concatenate([run.q_desired[k - 1], run.v_desired[k - 1]])
    sliding_surface(desired, state, np.array(gains.c), scenario.time_step, sigma)
    u1 = np.array(gains.rho) * np.clip(run.sliding_variable[k] / np.array(gains.phi), -1, 1)
    expected = robot.nominal_inertias() * (u1 + np.array(gains.k) * sigma)
    np.testing.assert_allclose(run.tau_commanded[k], expected, rtol=1e-9, atol=1e-9)
