"""Lyapunov's function on recordings: s as recorded against the equations of motion."""

from functools import cache

import numpy as np
import pytest
from numpy.typing import ArrayLike

from scara_drake import joints, load_scenario, robot, simulate
from scara_drake.control.ismc_law import GAINS
from scara_drake.stability.delay_margin import mass_ratios
from scara_drake.stability.evidence import pushed_scenario
from scara_drake.stability.lyapunov import lyapunov, perturbation

TS = 1e-3
STILL = {"operator.amplitude": 0.0, "operator.displacement": 0.0}


@cache
def run(name):
    """A scenario and its recording."""
    scenario = {
        "calm": lambda: load_scenario("joint_sine"),
        "pushed": pushed_scenario,
        "still": lambda: load_scenario(
            "joint_sine", {**STILL, "perturbation.offset": [0.0] * 5 + [-30.0]}
        ),
    }[name]()
    return scenario, simulate(scenario, duration=1.2)


@pytest.mark.parametrize("b", [1.0, 1.7])
def test_the_recorded_s_follows_equation_50(b):
    # s' = D - b u1 with D of the equations of motion, up to half the change in a period.
    scenario, recording = run("calm")
    gains = GAINS.unpack(scenario.controller.array())
    s = recording.sliding_variable.values
    u1 = gains.rho * np.clip(s / gains.phi, -1.0, 1.0)
    D = perturbation(recording, scenario, b)
    s_rate = np.diff(s, axis=0)[300:] / TS
    late = slice(300, -1)
    np.testing.assert_allclose(D[late] - b * u1[late], s_rate, atol=0.02 * np.abs(D[late]).max())


def test_a_known_perturbation_is_found_and_held_by_the_layer():
    # Joint 6 carries its nominal inertia: D = 30 rad/s² and s = phi D / rho = 0.3.
    scenario, recording = run("still")
    found = lyapunov(recording, scenario).sel(joint="theta6").isel(time=-1)
    assert float(found.perturbation) == pytest.approx(30.0, rel=0.01)
    assert float(found.V) == pytest.approx(0.5 * 0.3**2, rel=0.02)
    assert found.within_bound
    assert float(found.bound) == pytest.approx(float(found.largest_s), rel=0.2)


@pytest.mark.parametrize("ratio", ["paper", "least", "largest"])
def test_outside_the_layer_v_falls(ratio):
    scenario, recording = run("pushed")
    low, high = mass_ratios(scenario.controller)
    ratios: dict[str, ArrayLike] = {"paper": 1.0, "least": low, "largest": high}
    found = lyapunov(recording, scenario, ratios[ratio])
    assert (found.samples_checked > 0).all()
    assert (found.samples_outside > found.samples_checked).all()
    assert (found.share_decreasing == 1.0).all()
    assert (found.worst_rate < 0.0).all()
    assert (found.worst_margin > 0.9).all()
    np.testing.assert_array_equal(found.V, 0.5 * recording.sliding_variable.values[:-1] ** 2)


def test_inside_the_layer_v_may_rise_and_s_keeps_its_bound():
    scenario, recording = run("calm")
    found = lyapunov(recording, scenario)
    assert (found.share_rising_inside > 0.01).all()
    assert found.within_bound.all()
    # The reference moves off at full speed: theta4 is asked for more than rho, no bound holds.
    finite = np.isfinite(found.bound)
    assert finite.sum() >= 5
    assert (found.samples_outside == 0)[finite].all()
    assert found.share_decreasing.isnull()[finite].all()
    # A joint leaves the layer only after its perturbation has exceeded rho.
    too_much = abs(found.perturbation) >= GAINS.unpack(scenario.controller.array()).rho
    left = found.samples_outside > 0
    assert (too_much.argmax("time") < found.outside.argmax("time"))[left].all()
    assert (found.largest_s <= 1.01 * found.bound)[finite].all()


def test_it_sees_what_does_not_fall():
    scenario, recording = run("pushed")
    changed = recording.copy(deep=True)
    s = changed.sliding_variable
    s[:] = np.sign(s) * (abs(s) + 0.2 * changed.time)  # of a law that lets s grow
    found = lyapunov(changed, scenario)
    assert (found.share_decreasing.min()) < 1.0
    calm, recording = run("calm")
    changed = recording.copy(deep=True)
    changed.sliding_variable[:] = 1.2 * changed.sliding_variable
    assert not lyapunov(changed, calm).within_bound.sel(joint="d1")


@pytest.mark.parametrize(
    ("overrides", "name"),
    [
        ({"controller": "!SlidingMode {}"}, "controller"),
        ({"drives.lag": {}}, "drives.lag"),
        ({"drives.encoder": {}}, "drives.encoder"),
        ({"drives.friction": {}}, "drives.friction"),
        ({"process_delay.actuation": "!ConstantDelay {delay: 0.0}"}, "process_delay"),
    ],
)
def test_a_scenario_with_other_dynamics_is_refused(overrides, name):
    _, recording = run("calm")
    with pytest.raises(ValueError, match=f"^{name}: .*, allowed"):
        lyapunov(recording, load_scenario("joint_sine", overrides))


def test_a_wrong_mass_ratio_is_refused():
    scenario, recording = run("calm")
    with pytest.raises(ValueError, match=r"^mass_ratio\[2\]: 0\.0, allowed above 0"):
        lyapunov(recording, scenario, [1.0, 1.0, 0.0, 1.0, 1.0, 1.0])


def test_the_push_is_beyond_rho_and_rho_within_the_drives():
    scenario, _ = run("pushed")
    rho, push = np.array(scenario.controller.rho), np.array(scenario.perturbation.offset)
    assert (robot.nominal_inertias() * rho < joints.EFFORT).all()
    assert (push > rho).all()
