import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from kinds import of_kind
from leaf import outputs, ports, tick
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator

from scara_drake import joints, load_scenario, robot, simulate
from scara_drake.common.fields import check
from scara_drake.control.integral_sliding_mode import (
    IntegralSlidingMode,
    IntegralSlidingModeController,
)
from scara_drake.control.ismc_law import GAINS, ismc_law, sliding_surface
from scara_drake.operator.joint_motion import JointMotion

TS = 1e-3
ONES = np.ones(6)
NO_LIMIT = np.full(6, 1e12)
NONE = np.zeros(6)


def rows(k, rho, phi, m_hat=ONES, effort=NO_LIMIT, period=TS):
    """Gains as the law takes them; each is a number or (6,); the clamp is 2 phi."""
    return GAINS.pack(
        c=0.0, k=k, rho=rho, phi=phi, m_hat=m_hat, effort=effort,
        clamp=2.0 * np.asarray(phi), period=period,
    )  # fmt: skip


def results():
    """Room for s, tau, tau_limited and saturation."""
    return np.empty((4, 6))


def run_law(sigmas, z, gains):
    """Apply the law to sigma samples (n, 6); return u (n, 6), s (n, 6) and the last z."""
    z = z.copy()
    s, tau, limited, saturation = results()
    efforts, surfaces = [], []
    for sigma in sigmas:
        ismc_law(sigma, gains, NONE, z, s, tau, limited, saturation)
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
    s, tau, limited, saturation = results()
    history = np.empty((n, 2))
    gains = rows(k, rho, phi, period=h)
    for i in range(n):
        ismc_law(sigma, gains, NONE, z, s, tau, limited, saturation)
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
    z = np.zeros(6)
    s, tau, limited, saturation = results()
    gains = rows(k, rho, phi)
    largest = 0.0
    for i in range(700):
        ismc_law(sigma, gains, NONE, z, s, tau, limited, saturation)
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
        check(gains, "controller")


def controller_and_context():
    controller = IntegralSlidingModeController(IntegralSlidingMode())
    context = controller.CreateDefaultContext()
    rng = np.random.default_rng(1)
    state = np.concatenate([joints.HOME, np.zeros(6)])
    controller.GetInputPort("state").FixValue(context, state)
    offset = rng.normal(0, 1e-3, 12)
    controller.GetInputPort("state_desired").FixValue(context, state + offset)
    return controller, context, offset


def test_ports():
    controller, _, _ = controller_and_context()
    assert ports(controller) == (
        {"state": 12, "state_desired": 12, "engaged": 1, "gain_scale": 1},
        {"actuation": 6, "actuation_commanded": 6, "saturation": 6, "sliding_variable": 6},
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


def test_paper_mode_is_the_raw_law_in_millimetres_and_newtons():
    gains = IntegralSlidingMode(mode=["paper"] + ["normalised"] * 5)
    k, rho, phi = gains.k[0], gains.rho[0], gains.phi[0]
    rng = np.random.default_rng(3)
    z = rng.normal(0.0, 2e-3, 6)
    for sigma in rng.normal(0.0, 3e-3, (50, 6)):
        s_mm = 1e3 * (sigma[0] - z[0])
        newtons = rho * np.clip(s_mm / phi, -1.0, 1.0) + k * 1e3 * sigma[0]
        s, tau, limited, saturation = results()
        ismc_law(sigma, gains.array(TS), NONE, z, s, tau, limited, saturation)
        np.testing.assert_allclose(tau[0], newtons, rtol=1e-12)


def test_paper_mode_does_not_clamp_the_integral():
    gains = IntegralSlidingMode(mode=["paper"] + ["normalised"] * 5).array(TS)
    _, surfaces, _ = run_law(np.full((500, 6), 0.5), np.zeros(6), gains)
    assert surfaces[-1, 0] > 30.0  # sigma + k sum(sigma) T_s = 0.5 + 150 * 0.25
    np.testing.assert_allclose(surfaces[-1, 1:], 2.0)


def test_saturation_tells_the_layer_and_the_effort_apart():
    gains = rows(1.0, 10.0, 1.0, effort=[20.0, 20.0, 5.0, 5.0, 20.0, 20.0])
    sigma = np.array([0.5, 1.5, 0.9, 1.5, -0.5, -1.5])
    s, tau, limited, saturation = results()
    ismc_law(sigma, gains, NONE, np.zeros(6), s, tau, limited, saturation)
    np.testing.assert_array_equal(saturation, [0, 1, 2, 3, 0, 1])


def held_arm(**options):
    """The arm held at HOME for a second, and its recording."""
    scenario = load_scenario("joint_sine", {"operator.amplitude": 0.0})
    of_kind(JointMotion, scenario.operator).displacement = [0.0] * 6
    scenario.controller = IntegralSlidingMode(**options)
    return simulate(scenario, duration=0.3)


def test_gravity_compensation_takes_the_weight_from_the_first_sample():
    without, compensated = held_arm(), held_arm(gravity_compensation=True)
    error, small = (
        abs(run.q_desired - run.q_measured).max("time") for run in (without, compensated)
    )
    assert float(error[0]) > 1e-5
    assert float(small.max()) < 1e-8


def test_acceleration_feedforward_adds_the_inertia_times_the_acceleration():
    # One period of a reference with a known acceleration, at zero error.
    controller = IntegralSlidingModeController(IntegralSlidingMode(acceleration_feedforward=True))
    context = controller.CreateDefaultContext()
    a, v = np.array([0.3, -1.0, 2.0, 0.5, -4.0, 1.0]), np.full(6, 0.2)
    before = np.concatenate([joints.HOME, v])
    controller.GetInputPort("state").FixValue(context, before)
    controller.GetInputPort("state_desired").FixValue(context, before)
    controller.ExecuteInitializationEvents(context)
    after = np.concatenate([joints.HOME + TS * v, v + TS * a])
    controller.GetInputPort("state_desired").FixValue(context, after)
    controller.GetInputPort("state").FixValue(
        context, np.concatenate([after[:6] + TS * after[6:], after[6:]])
    )
    tick(controller, context)
    np.testing.assert_allclose(
        controller.GetOutputPort("actuation_commanded").Eval(context),
        robot.nominal_inertias() * a,
        atol=1e-6,
    )


def test_disengaged_drives_give_no_effort_and_take_over_without_a_jump():
    controller, context, offset = controller_and_context()
    engaged = controller.GetInputPort("engaged")
    engaged.FixValue(context, [0.0])
    controller.ExecuteInitializationEvents(context)
    jump = offset.copy()
    for _ in range(3):
        jump += 0.05  # the reference runs away while the drives are off
        state = controller.GetInputPort("state").Eval(context)
        controller.GetInputPort("state_desired").FixValue(context, state + jump)
        tick(controller, context)
        np.testing.assert_array_equal(outputs(controller, context), 0.0)
    engaged.FixValue(context, [1.0])
    tick(controller, context)
    gains = IntegralSlidingMode()
    sigma = np.empty(6)
    state = controller.GetInputPort("state").Eval(context)
    sliding_surface(state + jump, state, np.array(gains.c), TS, sigma)
    # s = 0, so there is no part of rho: only k sigma.
    np.testing.assert_allclose(
        controller.GetOutputPort("sliding_variable").Eval(context), 0.0, atol=1e-12
    )
    np.testing.assert_allclose(
        controller.GetOutputPort("actuation_commanded").Eval(context),
        robot.nominal_inertias() * np.array(gains.k) * sigma,
        rtol=1e-9,
    )


@pytest.mark.parametrize("port", ["state", "state_desired"])
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_what_is_not_a_number_stops_the_run_and_names_port_and_time(port, bad):
    controller, context, _ = controller_and_context()
    controller.set_name("controller")
    controller.ExecuteInitializationEvents(context)
    context.SetTime(0.25)
    values = controller.GetInputPort(port).Eval(context).copy()
    values[7] = bad
    controller.GetInputPort(port).FixValue(context, values)
    with pytest.raises(
        RuntimeError, match=rf"controller: port '{port}' at t = 0.25 s: {port}\[7\]"
    ):
        tick(controller, context)


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
    gains = of_kind(IntegralSlidingMode, scenario.controller)
    sigma = np.empty(6)
    desired = np.concatenate([run.q_desired[k - 1], run.v_desired[k - 1]])
    sliding_surface(desired, state, np.array(gains.c), scenario.time_step, sigma)
    u1 = np.array(gains.rho) * np.clip(run.sliding_variable[k] / np.array(gains.phi), -1, 1)
    expected = robot.nominal_inertias() * (u1 + np.array(gains.k) * sigma)
    np.testing.assert_allclose(run.tau_commanded[k], expected, rtol=1e-9, atol=1e-9)
