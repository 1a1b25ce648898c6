import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from leaf import outputs, ports, tick

from scara_drake import load_scenario, robot, simulate
from scara_drake.common.fields import check
from scara_drake.control.integral_sliding_mode import (
    IntegralSlidingMode,
    IntegralSlidingModeController,
)
from scara_drake.control.pid import GAINS as PID_GAINS
from scara_drake.control.pid import Pid, PidController, pid_law, pid_start

TS = 1e-3
GAINS = ("kp", "ki", "kd")


def column(kp, ki, kd, effort=1e12, period=TS):
    """Gains of one joint of unit inertia."""
    return PID_GAINS.pack(kp=kp, ki=ki, kd=kd, m_hat=1.0, effort=effort, period=period)


def triple(w, effort=1e12, period=TS):
    """Gains with three poles at -w."""
    return column(3 * w * w, w**3, 3 * w, effort, period)


def scalar_plant(gains, n, d=lambda t: 0.0, e=0.0):
    """Integrate e'' = d - u from rest; return e (n,) and the effort before its limit."""
    rate, h = 0.0, PID_GAINS.unpack(gains).period[0]
    integral = np.zeros(1)
    tau, limited, saturation = np.empty((3, 1))
    history = np.empty((n, 2))
    for i in range(n):
        error, error_rate = np.array([e]), np.array([rate])
        pid_law(error, error_rate, gains, integral, tau, limited, saturation)
        history[i] = e, tau[0]
        rate += h * (d(i * h) - limited[0])
        e += h * rate
    return history.T


def test_defaults_are_integral_sliding_mode_control_inside_its_layer():
    derived = Pid.from_sliding_mode(IntegralSlidingMode())
    for gain in GAINS:
        np.testing.assert_allclose(getattr(Pid(), gain), getattr(derived, gain), rtol=1e-12)


def test_a_joint_in_millimetres_and_newtons_has_its_pid_in_metres_too():
    gains = IntegralSlidingMode(mode=["paper"] + ["normalised"] * 5)
    derived = Pid.from_sliding_mode(gains)
    # u [N] = (k + rho / phi) [N s/mm] e' [mm/s], and m_hat of the mast is 735.5 kg.
    np.testing.assert_allclose(derived.kd[0], 1e3 * (150.0 + 500.0) / 735.5, rtol=1e-9)
    np.testing.assert_allclose(derived.ki[0], 1e3 * 150.0 * 50.0 * 500.0 / 735.5, rtol=1e-9)


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 2**32 - 1))
def test_it_has_the_torque_of_integral_sliding_mode_control(seed):
    # Random motions, with the measured rate the slope to the next sample, as the law's sum has it.
    # The integrals begin otherwise, so the torques differ by a constant: -rho/phi (sigma + k e) at
    # the start for one, and -kp e - kd e' for the other.
    rng = np.random.default_rng(seed)
    law = IntegralSlidingMode(
        c=rng.uniform(5, 50, 6).tolist(),
        k=rng.uniform(5, 150, 6).tolist(),
        rho=rng.uniform(50, 300, 6).tolist(),
        phi=rng.uniform(0.5, 2, 6).tolist(),
    )
    e = 1e-6 * np.cumsum(rng.normal(size=(101, 6)), axis=0)
    error_rate = np.diff(e, axis=0) / TS
    desired = rng.normal(0, 0.5, (100, 12))
    controllers = [
        IntegralSlidingModeController(law, TS),
        PidController(Pid.from_sliding_mode(law), TS),
    ]
    contexts = [controller.CreateDefaultContext() for controller in controllers]
    efforts = np.empty((2, 100, 6))
    for step in range(100):
        q = desired[step, :6] + (TS * desired[step, 6:] if step else 0.0) - e[step]
        state = np.concatenate([q, desired[step, 6:] - error_rate[step]])
        for i, (controller, context) in enumerate(zip(controllers, contexts, strict=True)):
            controller.GetInputPort("state").FixValue(context, state)
            controller.GetInputPort("state_desired").FixValue(context, desired[step])
            if step == 0:
                controller.ExecuteInitializationEvents(context)
            else:
                tick(controller, context)
            efforts[i, step] = controller.GetOutputPort("actuation_commanded").Eval(context)
        sliding = controllers[0].GetOutputPort("sliding_variable").Eval(contexts[0])
        assert (np.abs(sliding) < law.phi).all()
    c, k, slope = np.array(law.c), np.array(law.k), np.divide(law.rho, law.phi)
    kp, kd = (k + slope) * c + k * slope, k + slope
    sigma = error_rate[0] + c * e[0]
    constant = robot.nominal_inertias() * (
        kp * e[0] + kd * error_rate[0] - slope * (sigma + k * e[0])
    )
    difference = efforts[0] - efforts[1]
    largest = np.abs(efforts).max(axis=(0, 1))
    assert (np.abs(difference - constant).max(axis=0) < 1e-9 * largest).all()


@pytest.mark.parametrize("w", [5.0, 30.0])
def test_a_step_of_perturbation_follows_the_closed_form_and_leaves_nothing(w):
    h, d = 1e-5, 3.0
    e, _ = scalar_plant(triple(w, period=h), round(12.0 / w / h), lambda t: d)
    t = h * np.arange(e.size)
    # e = d s / (s + w)^3 in Laplace's terms, divided by s for the step.
    np.testing.assert_allclose(e, 0.5 * d * t * t * np.exp(-w * t), atol=2e-3 * d / w**2)
    assert abs(e[-1]) < 2e-3 * d / w**2


def test_the_integral_holds_at_the_limit_and_the_joint_comes_back_without_overshoot():
    # A perturbation of twice the effort limit for 2 s pushes the joint away.
    w, effort, pushed = 10.0, 10.0, 2.0
    e, tau = scalar_plant(triple(w, effort), 20000, lambda t: 1.5 * effort * (t < pushed))
    assert e.max() > 0.5 * 0.5 * effort * pushed**2  # the limit really was too low
    gain = triple(w, effort)
    g = PID_GAINS.unpack(gain)
    bound = effort + g.kp[0] * e.max()
    assert np.abs(tau).max() < bound + g.kd[0] * 50.0  # no integral of a second's error in it
    assert abs(e[-1]) < 1e-6
    integral = np.zeros(1)
    tau, limited, saturation = np.empty((3, 1))
    for _ in range(1000):  # held at the limit
        pid_law(np.ones(1), np.zeros(1), gain, integral, tau, limited, saturation)
    assert integral[0] == 0.0
    pid_law(-np.ones(1), np.full(1, 50.0), gain, integral, tau, limited, saturation)
    assert saturation[0] == 2.0
    assert integral[0] < 0.0  # the error that leads away from the limit counts


@given(st.floats(-1, 1), st.floats(-1, 1), st.floats(0, 1e5), st.floats(0, 1e6), st.floats(0, 1e3))
def test_it_takes_over_without_a_jump_where_it_has_an_integral(e, rate, kp, ki, kd):
    integral, tau, limited, saturation = np.full((4, 1), np.nan)
    gains = column(kp, ki, kd)
    pid_start(np.array([e]), np.array([rate]), gains, integral)
    pid_law(np.array([e]), np.array([rate]), gains, integral, tau, limited, saturation)
    expected = 0.0 if ki > 0.0 else kp * e + kd * rate
    np.testing.assert_allclose(tau[0], expected, atol=1e-9 * (1.0 + kp + kd))


@pytest.mark.parametrize(("number", "stable"), [(1.95, True), (2.05, False)])
def test_the_rule_of_sampling_is_where_a_double_integrator_loses_its_stability(number, stable):
    kd = 0.8 * number / TS
    kp = 0.2 * number / TS * 2.0 / TS
    e, _ = scalar_plant(column(kp, 0.0, kd), 3000, e=1e-6)
    assert (abs(e[-1]) < 1e-7) == stable


def test_gains_that_chatter_are_refused_unless_asked_for():
    Pid().check_sampling("controller", TS)
    loud = Pid(kd=[2000.0] * 6)
    with pytest.raises(ValueError, match=r"^controller: chatters, .* allowed below 2: lower kd"):
        loud.check_sampling("controller", TS)
    loud.allow_chatter = True
    loud.check_sampling("controller", TS)


@pytest.mark.parametrize("field", GAINS)
@pytest.mark.parametrize("value", [-1.0, np.inf])
def test_bad_gains_are_refused_by_name(field, value):
    gains = Pid()
    getattr(gains, field)[1] = value
    with pytest.raises(ValueError, match=rf"^controller\.{field}\[1\]: "):
        check(gains, "controller")


def test_ports_and_memory_in_the_context():
    controller = Pid().make_system(TS)
    assert ports(controller) == (
        {"state": 12, "state_desired": 12, "engaged": 1},
        {"actuation": 6, "actuation_commanded": 6, "saturation": 6},
    )
    context = controller.CreateDefaultContext()
    controller.GetInputPort("state").FixValue(context, np.zeros(12))
    controller.GetInputPort("state_desired").FixValue(context, np.full(12, 1e-4))
    controller.ExecuteInitializationEvents(context)
    clone = context.Clone()
    for _ in range(5):
        tick(controller, context)
    for _ in range(5):
        tick(controller, clone)
    np.testing.assert_array_equal(outputs(controller, context), outputs(controller, clone))


def test_it_tracks_the_sines_as_integral_sliding_mode_control_does():
    runs = []
    for controller in (IntegralSlidingMode(), Pid()):
        scenario = load_scenario("joint_sine")
        scenario.controller = controller
        run = simulate(scenario, duration=2.0).sel(time=slice(1.0, None))
        runs.append(abs(run.q_desired - run.q_measured).max("time"))
    assert float(runs[1].max()) < 1e-4
    # The sum of the sampled e' is e but for T_s / 2 times the reference's rate, so the sliding
    # mode keeps an error of T_s a / (2 c) beside the PID's.
    acceleration = np.array([0.12, 1.23, 0.0, 1.23, 0.0, 0.0])  # of the mast's move and the sines
    apart = 0.5 * TS * acceleration / IntegralSlidingMode().c
    assert (np.abs(runs[1] - runs[0]) < 1.1 * apart + 2e-7).all()
