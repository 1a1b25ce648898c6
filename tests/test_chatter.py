import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from kinds import of_kind
from pydrake.multibody.plant import MultibodyPlant

from scara_drake import joints, load_scenario, metrics, robot, simulate
from scara_drake.control.chatter import check_chatter, smallest_layer
from scara_drake.control.integral_sliding_mode import IntegralSlidingMode
from scara_drake.robot import chatter_number, inverse_mass_matrices

TS = 1e-3
M_HAT = robot.nominal_inertias()


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
    factor = smallest_layer(M_HAT, k, rho, phi, TS)
    check_chatter("controller", M_HAT, k, rho, factor * phi, TS)
    with pytest.raises(ValueError, match="chatters"):
        check_chatter("controller", M_HAT, k, rho, 0.999 * factor * phi, TS)


def test_where_no_layer_would_do_the_error_says_so():
    k, rho, phi = np.full(6, 5e3), np.full(6, 150.0), np.ones(6)
    with pytest.raises(ValueError, match=r"^controller: chatters, .* no phi would do"):
        check_chatter("controller", M_HAT, k, rho, phi, TS)


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
    load_scenario("joint_sine", {"time_step": 1e-3, "controller.phi": 0.2})
    with pytest.raises(ValueError, match=r"chatters.*T_s = 0\.002 s"):
        load_scenario("joint_sine", {"time_step": 2e-3, "controller.phi": 0.2})


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
