"""What can be told before a run, and that the run does as was told."""

import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import examples

from scara_drake import joints, load_scenario, metrics, simulate
from scara_drake.scenario import scenario_names
from scara_drake.stability.foresee import foresee, loop_delay

STILL = {"operator.amplitude": 0.0, "operator.displacement": 0.0}


@pytest.mark.parametrize("name", scenario_names())
def test_of_a_shipped_scenario_nothing_is_told(name):
    assert foresee(load_scenario(name)) == []


CASES: dict[str, tuple[dict[str, Any], str]] = {
    "mass": ({"robot.mass_scale": 10.0}, "d1 needs 72153 N"),
    "payload": (
        {"robot.payload_mass": 500.0},
        r"theta3 needs .* N m to hold the arm where it starts, its drive has 3000",
    ),
    "no gains": ({f"controller.{name}": 0.0 for name in ("c", "k", "rho")}, "nothing holds d1"),
    "no slope": ({"controller.c": [50.0, 0.0, 20.0, 15.0, 10.0, 10.0]}, "nothing holds theta2 in"),
    "no kp": ({"controller": "!Pid {}", "controller.kp": 0.0}, "nothing holds d1"),
    "delay": (
        {"process_delay.actuation": "!ConstantDelay {delay: 0.02}"},
        "a delay of 21 ms, where it starts it bears",
    ),
    "little rho": ({"controller.rho": 0.5}, "rho of d1 gives 368, the weight asks for 7215"),
}


@pytest.mark.parametrize("case", CASES)
def test_what_is_told_comes(case):
    overrides, told = CASES[case]
    scenario = load_scenario("joint_sine", overrides)
    lines = foresee(scenario)
    assert any(re.search(told, line) for line in lines), lines
    assert all("\n" not in line for line in lines)
    error = metrics.tracking_error(simulate(scenario, duration=2.0)).sel(time=slice(1.0, None))
    sound = metrics.tracking_error(simulate(load_scenario("joint_sine"), duration=2.0))
    sound = sound.sel(time=slice(1.0, None))
    assert float(np.abs(error).max()) > 10.0 * float(np.abs(sound).max())


@examples(10)
@given(st.floats(0.0, 0.004))
def test_the_delay_that_is_told_is_the_one_that_grows(delay):
    overrides = {
        "process_delay.measurement": {"_tag": "!ConstantDelay", "delay": delay},
        "controller": "!IntegralSlidingMode {}",
        **STILL,
    }
    scenario = load_scenario("joint_sine", overrides)
    assert loop_delay(scenario) == pytest.approx(delay + 1e-3)
    run = simulate(scenario, duration=2.0)
    flips = np.abs(np.diff(run.tau_applied.values[-400:], axis=0)) / joints.EFFORT
    told = bool(foresee(scenario))
    # Between, where the loop is near its limit, either may be.
    if flips.max() > 0.5:
        assert told
    if flips.max() < 1e-4:
        assert not told


DEVICES: dict[str, tuple[dict[str, Any], str]] = {
    "force": ({}, "the hand can press with 6 N, the device touch pushes back with 3.3 N at most"),
    "damping": ({}, "coupling.master_damping is cut from 20 to 4, as much as the device touch"),
    "stiffness": ({}, "pressed on wall the coupling asks the device touch for 909.1 N/m"),
    "waves": (
        {"coupling": "!WaveVariables {}"},
        "the device touch for 20 N s/m, it renders 4 N",
    ),
    "P+d": ({"coupling": "!PositionDamping {}"}, "asks the device touch for 30 N s/m, it renders"),
    "direct": ({"coupling": "!Direct {}"}, r"asks the device touch for 1e\+04 N/m, it renders 400"),
    "model": ({"coupling": "!ModelMediated {}"}, r"max_stiffness is cut from 1e\+04 to 400"),
}


@pytest.mark.parametrize("case", DEVICES)
def test_what_a_device_cannot_do_is_told(case):
    overrides, told = DEVICES[case]
    lines = foresee(load_scenario("bilateral", {"operator.device": "touch", **overrides}))
    assert any(re.search(told, line) for line in lines), lines
    calm = {"operator.device": "omega.3", "coupling": "!Tdpa {force_scale: 0.3}"}
    assert foresee(load_scenario("bilateral", calm)) == []
