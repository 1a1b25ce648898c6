import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from leaf import outputs, ports, tick

from scara_drake import joints, load_scenario, robot, simulate
from scara_drake.common.fields import check
from scara_drake.control.integral_sliding_mode import IntegralSlidingMode
from scara_drake.control.sliding_mode import GAINS, SlidingMode, SlidingModeController, smc_law

TS = 1e-3


def column(c, rho, phi, m_hat=1.0, effort=1e12):
    """Gains of one joint."""
    return GAINS.pack(c=c, rho=rho, phi=phi, m_hat=m_hat, effort=effort, period=TS)


def scalar_plant(gains, duration, e=0.0, rate=0.0, d=0.0, h=1e-5):
    """Integrate e'' = d - u; return times and (e, sigma, u)."""
    c = GAINS.unpack(gains).c[0]
    sigma, tau, limited, saturation = np.empty((4, 1))
    history = np.empty((round(duration / h), 3))
    for row in history:
        sigma[0] = rate + c * e
        smc_law(sigma, gains, tau, limited, saturation)
        row[:] = e, sigma[0], limited[0]
        rate += h * (d - limited[0])
        e += h * rate
    return h * np.arange(len(history)), history


@settings(deadline=None, max_examples=25)
@given(st.floats(2, 50), st.floats(50, 500), st.floats(0.2, 2.0), st.floats(-0.9, 0.9))
def test_a_constant_perturbation_leaves_phi_d_over_rho_c(c, rho, phi, share):
    d = share * rho
    _, history = scalar_plant(column(c, rho, phi), 12.0 / c + 20.0 * phi / rho, d=d, h=1e-4)
    expected = phi * d / (rho * c)
    assert abs(history[-1, 0] - expected) < 1e-3 * phi / c


def test_outside_the_layer_the_full_effort_reaches_it_on_the_parabola():
    c, rho, phi, e = 10.0, 100.0, 1.0, 0.5
    t, history = scalar_plant(column(c, rho, phi), 0.1, e=e, h=1e-6)
    sigma = -rho * t + c * (e - 0.5 * rho * t * t)
    outside = t < t[np.argmax(history[:, 1] < phi)]
    assert 0.1 < outside.mean() < 0.9
    np.testing.assert_allclose(history[outside, 1], sigma[outside], atol=1e-3)
    np.testing.assert_array_equal(history[outside, 2], rho)
    assert (abs(history[~outside, 1]) <= phi * (1 + 1e-3)).all()  # and it stays inside


@pytest.mark.parametrize(("number", "settles"), [(1.9, True), (2.1, False)])
def test_chatter_begins_where_a_period_overshoots_by_twice(number, settles):
    # sigma' = -u alone: a step of T_s rho / phi times sigma.
    rho, sigma = 150.0, np.array([1e-3])
    gains = column(0.0, rho, TS * rho / number)
    tau, limited, saturation = np.empty((3, 1))
    for _ in range(2000):
        smc_law(sigma, gains, tau, limited, saturation)
        sigma -= TS * limited
    assert (abs(sigma[0]) < 1e-9) == settles


@given(st.floats(-50, 50), st.floats(0.1, 5.0), st.floats(0, 500))
def test_bounds_and_what_saturation_tells(sigma, phi, rho):
    tau, limited, saturation = np.empty((3, 1))
    smc_law(np.array([sigma]), column(1.0, rho, phi, 2.0, 300.0), tau, limited, saturation)
    assert abs(tau[0]) <= 2.0 * rho
    assert abs(limited[0]) <= 300.0
    assert sigma * tau[0] >= 0.0
    assert saturation[0] == (abs(sigma) >= phi) + 2 * (abs(tau[0]) > 300.0)


def test_defaults_are_as_steep_and_so_as_quiet_as_the_integral_law():
    gains, integral = SlidingMode(), IntegralSlidingMode()
    steepness = np.add(integral.k, np.divide(integral.rho, integral.phi))
    np.testing.assert_allclose(np.divide(gains.rho, gains.phi), steepness)
    np.testing.assert_array_equal(gains.c, integral.c)
    check(gains, "controller")
    gains.check_sampling("controller", TS)


def test_a_thin_layer_is_refused_unless_asked_for():
    thin = SlidingMode(phi=[0.3] * 6)
    with pytest.raises(ValueError, match=r"^controller: chatters, .* smallest phi .* \[0\.3\d"):
        thin.check_sampling("controller", TS)
    SlidingMode(phi=[0.3] * 6, allow_chatter=True).check_sampling("controller", TS)


@pytest.mark.parametrize(("field", "value"), [("c", -1.0), ("rho", np.nan), ("phi", 0.0)])
def test_bad_gains_are_refused_by_name(field, value):
    gains = SlidingMode()
    getattr(gains, field)[4] = value
    with pytest.raises(ValueError, match=rf"^controller\.{field}\[4\]: "):
        check(gains, "controller")


def test_the_system_applies_the_law_to_the_reference_carried_one_period():
    gains = SlidingMode()
    controller = gains.make_system(TS)
    assert isinstance(controller, SlidingModeController)
    assert ports(controller) == (
        {"state": 12, "state_desired": 12, "engaged": 1},
        {"actuation": 6, "actuation_commanded": 6, "saturation": 6, "sliding_variable": 6},
    )
    context = controller.CreateDefaultContext()
    rng = np.random.default_rng(0)
    state, desired = rng.normal(0, 1e-3, (2, 12))
    controller.GetInputPort("state").FixValue(context, state)
    controller.GetInputPort("state_desired").FixValue(context, desired)
    for lead, event in (
        (0.0, controller.ExecuteInitializationEvents),
        (TS, lambda context: tick(controller, context)),
    ):
        event(context)
        rate = desired[6:] - state[6:]
        sigma = rate + np.array(gains.c) * (desired[:6] + lead * desired[6:] - state[:6])
        effort = robot.nominal_inertias() * np.array(gains.rho) * sigma
        limited = np.clip(effort, -joints.EFFORT, joints.EFFORT)
        expected = np.concatenate([limited, effort, 2.0 * (limited != effort), sigma])
        np.testing.assert_allclose(outputs(controller, context), expected, rtol=1e-12)


def test_the_mast_sags_by_its_weight_as_the_steady_error_says():
    scenario = load_scenario("joint_sine", {"operator.amplitude": 0.0})
    scenario.controller = SlidingMode()
    run = simulate(scenario, duration=0.5)
    sag = (run.q_desired - run.q_measured).sel(joint="d1")[-1]
    # d = g, as the nominal inertia of the mast is its mass.
    np.testing.assert_allclose(sag, 1.0 * 9.81 / (650.0 * 50.0), rtol=1e-3)
