import re

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from kinds import of_kind
from pydrake.multibody.plant import MultibodyPlant
from strategies import examples

from scara_drake import joints, load_scenario, metrics, robot, simulate
from scara_drake.control.chatter import Slopes, check_chatter, smallest_layer
from scara_drake.control.integral_sliding_mode import IntegralSlidingMode
from scara_drake.robot import chatter_number, inverse_mass_matrices

TS = 1e-3
M_HAT = robot.nominal_inertias()
NONE = np.zeros(6)


def spectral_radius(gain, inverse_mass):
    """Of sigma -> (1 - T_s M^-1 diag(gain)) sigma: above 1 the sampled loop grows."""
    return np.abs(np.linalg.eigvals(np.eye(6) - TS * inverse_mass * gain)).max()


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 2**32 - 1))
def test_the_number_is_two_where_the_sampled_loop_begins_to_grow(seed):
    gain = M_HAT * np.random.default_rng(seed).uniform(10.0, 500.0, 6)
    scaled = gain * 2.0 / chatter_number(gain, TS)
    inverses = inverse_mass_matrices()
    assert max(spectral_radius(0.99 * scaled, m) for m in inverses) < 1.0
    assert max(spectral_radius(1.01 * scaled, m) for m in inverses) > 1.0


def test_no_posture_of_the_workspace_is_worse_than_the_grid():
    plant = MultibodyPlant(time_step=0.0)
    robot.add_scara(plant)
    plant.Finalize()
    context = plant.CreateDefaultContext()
    gain = M_HAT * np.array([450.0, 200.0, 185.0, 145.0, 120.0, 120.0])
    worst = 0.0
    for q in np.random.default_rng(1).uniform(joints.LOWER, joints.UPPER, (2000, 6)):
        plant.SetPositions(context, q)
        matrix = np.linalg.solve(plant.CalcMassMatrix(context), np.diag(gain))
        worst = max(worst, TS * np.linalg.eigvals(matrix).real.max())
    number = chatter_number(gain, TS)
    assert worst <= 1.01 * number
    assert worst >= 0.95 * number


def test_smallest_layer_meets_the_rule_and_no_less_does():
    k, rho, phi = np.full(6, 50.0), np.full(6, 150.0), np.full(6, 1e-3)
    factor = smallest_layer(Slopes(M_HAT, NONE, k, rho, phi), TS)
    check_chatter("controller", Slopes(M_HAT, NONE, k, rho, factor * phi), TS)
    with pytest.raises(ValueError, match="chatters"):
        check_chatter("controller", Slopes(M_HAT, NONE, k, rho, 0.999 * factor * phi), TS)


def test_where_no_layer_would_do_the_error_says_so():
    k, rho, phi = np.full(6, 5e3), np.full(6, 150.0), np.ones(6)
    with pytest.raises(ValueError, match=r"^controller: chatters, .* no phi would do"):
        check_chatter("controller", Slopes(M_HAT, NONE, k, rho, phi), TS)


def test_a_scenario_that_chatters_is_refused_with_a_layer_that_would_do():
    with pytest.raises(ValueError, match="chatters") as refused:
        load_scenario("joint_sine", {"controller.phi": 0.02})
    message = str(refused.value)
    assert "\n" not in message
    phi = [float(v) for v in re.findall(r"would do is \[(.*?)\]", message)[0].split(",")]
    load_scenario("joint_sine", {"controller.phi": phi})
    with pytest.raises(ValueError, match="chatters"):
        load_scenario("joint_sine", {"controller.phi": [0.98 * value for value in phi]})


def test_a_sampling_time_that_breaks_the_rule_is_refused():
    load_scenario("joint_sine", {"time_step": 1e-3, "controller.phi": 0.22})
    with pytest.raises(ValueError, match=r"chatters.*T_s = 0\.002 s"):
        load_scenario("joint_sine", {"time_step": 2e-3, "controller.phi": 0.22})


def test_the_switch_lets_it_chatter_and_chatter_it_does():
    quiet = load_scenario("joint_sine")
    loud = load_scenario("joint_sine", {"controller.phi": 0.02, "controller.allow_chatter": True})
    changes = [
        metrics.chatter(simulate(scenario, duration=0.5).tau_applied).values[1:]
        for scenario in (quiet, loud)
    ]
    assert changes[1].max() > 100.0 * changes[0].max()


def test_paper_mode_is_told_in_millimetres():
    settings_ = {"controller.mode": "paper", "controller.allow_chatter": True}
    gains = of_kind(IntegralSlidingMode, load_scenario("mast_step", settings_).controller)
    gains.allow_chatter, gains.phi = False, [1e-3] * 6
    with pytest.raises(ValueError, match="chatters") as refused:
        gains.check_sampling("controller", TS)
    text = re.findall(r"\[(.*?)\]", str(refused.value))[0]
    gains.phi = [float(value) for value in text.split(",")]
    gains.check_sampling("controller", TS)


def sampled_arm(inverse_mass, c, k, r):
    """Matrix of one period of the law in its layer on a plant that steps as the simulated one does.

    v <- v + T_s M^-1 tau, q <- q + T_s v, z <- z - T_s k sigma with sigma = -(v + c q) and
    tau = m_hat ((k + r) sigma - r z).
    """
    eye, zero, diag = np.eye(6), np.zeros((6, 6)), np.diag
    sigma = np.hstack([-diag(c), -eye, zero])
    tau = diag(M_HAT * (k + r)) @ sigma - np.hstack([zero, zero, diag(M_HAT * r)])
    v = np.hstack([zero, eye, zero]) + TS * inverse_mass @ tau
    q = np.hstack([eye, zero, zero]) + TS * v
    return np.vstack([q, v, np.hstack([zero, zero, eye]) - TS * diag(k) @ sigma])


@st.composite
def robots(draw):
    """Robots over the whole range of their fields."""
    scale = st.floats(0.1, 10.0)
    return robot.RobotModel(
        [draw(scale) for _ in range(6)],
        draw(st.floats(0.0, 500.0)),
        [0.0, 0.0, draw(st.floats(-2.0, 2.0))],
    )


exponents = st.lists(st.floats(-1.0, 4.0), min_size=6, max_size=6)
log_gains = exponents.map(lambda x: 10.0 ** np.array(x))


HEAVY = robot.RobotModel(mass_scale=[10.0] * 6)
FAST = [np.full(6, gain) for gain in (6000.0, 1300.0, 600.0)]  # c, k, r


@example(*FAST, 1.46, HEAVY)  # its integral is too fast: what grows has four samples a period
@examples(8)
@given(log_gains, log_gains, log_gains, st.floats(0.05, 1.9), robots())
def test_within_the_rule_no_effort_flips_on_the_robot_that_is_simulated(c, k, r, number, model):
    # Over five decades of each gain, then scaled to a number within the rule.
    slopes = Slopes(M_HAT, c, k, r, np.ones(6))
    share = number / chatter_number(slopes.gain(TS), TS, model)
    k, r = share * k, share * r
    check_chatter("controller", Slopes(M_HAT, c, k, r, np.ones(6)), TS, model)
    for inverse in inverse_mass_matrices(model)[::211]:
        modes = np.linalg.eigvals(sampled_arm(inverse, c, k, r))
        # Where the integral is too fast for a heavy robot modes may grow, with three samples a
        # period or more (2 pi / 3 for a joint alone with c T_s without bounds); none that flips.
        assert (np.abs(modes[np.abs(np.angle(modes)) > 2.5]) < 1.0).all()


@examples(4)
@given(log_gains, log_gains, robots())
def test_beyond_the_rule_some_posture_is_not(c, slope, model):
    drawn = Slopes(M_HAT, c, slope, NONE, np.ones(6)).gain(TS)
    slope = slope * 2.02 / chatter_number(drawn, TS, model)
    with pytest.raises(ValueError, match="chatters"):
        check_chatter("controller", Slopes(M_HAT, c, slope, NONE, np.ones(6)), TS, model)
    growth = [
        np.abs(np.linalg.eigvals(sampled_arm(inverse, c, NONE, slope)[:12, :12])).max()
        for inverse in inverse_mass_matrices(model)
    ]
    assert max(growth) > 1.0


@pytest.mark.parametrize("tag", ["IntegralSlidingMode", "SlidingMode", "ObserverSlidingMode"])
def test_a_steep_surface_is_refused(tag):
    with pytest.raises(ValueError, match=r"^controller: chatters, .* (smallest|no) phi"):
        load_scenario("joint_sine", {"controller": f"!{tag} {{}}", "controller.c": 1e4})


@pytest.mark.parametrize(
    "tag", ["IntegralSlidingMode", "SlidingMode", "ObserverSlidingMode", "Pid", "InverseDynamics"]
)
def test_a_lighter_robot_bears_less(tag):
    # Slopes just within the rule of the nominal robot, which a robot of a third breaks.
    steep = {
        "IntegralSlidingMode": {"phi": 0.35},
        "SlidingMode": {"phi": 0.42},
        "ObserverSlidingMode": {"phi": 0.06, "eps": 0.01},
        "Pid": {"kd": 600.0},
        "InverseDynamics": {"kd": 1500.0},
    }[tag]
    overrides = {"controller": f"!{tag} {{}}", **{f"controller.{n}": v for n, v in steep.items()}}
    load_scenario("joint_sine", overrides)
    with pytest.raises(ValueError, match=r"^controller: chatters"):
        load_scenario("joint_sine", {**overrides, "robot.mass_scale": 0.1})


def test_a_payload_of_next_to_nothing_is_none():
    nothing = inverse_mass_matrices(robot.RobotModel(payload_mass=5e-324))
    np.testing.assert_array_equal(nothing, inverse_mass_matrices())
