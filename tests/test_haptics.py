from __future__ import annotations

import math
from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pydrake.common.yaml import yaml_load_typed
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context

from scara_drake.operator.devices import Sample, at_rest
from scara_drake.operator.haptics import (
    HapticMapping,
    HapticOutput,
    haptics_step,
    impact_level,
    sustained_level,
)

MAPPING = HapticMapping()
PARAMETERS = MAPPING.parameters()


def levels(forces: list[float], mapping: HapticMapping = MAPPING) -> np.ndarray:
    """Low and high level (n, 2) after each tick of a sequence of forces [N]."""
    parameters, memory, rumble = mapping.parameters(), np.zeros(3), np.zeros(2)
    history = []
    for force in forces:
        haptics_step(np.array([0.0, force, 0.0]), parameters, memory, rumble)
        history.append(rumble.copy())
    return np.array(history)


def settled(force: float, mapping: HapticMapping = MAPPING) -> float:
    return float(levels([force] * 60, mapping)[-1, 0])


def test_parameters_follow_the_fields() -> None:
    assert PARAMETERS.shape == (11,)
    assert [f.name for f in fields(HapticMapping)][10] == "period"
    assert PARAMETERS[10] == MAPPING.period


@settings(deadline=None)
@given(force=st.floats(0, 1e4), more=st.floats(0, 1e3))
def test_sustained_level_is_monotone_and_in_range(force: float, more: float) -> None:
    level = sustained_level(force, PARAMETERS)
    assert MAPPING.level_minimum <= level <= 1.0
    assert sustained_level(force + more, PARAMETERS) >= level


def test_sustained_level_has_its_ends_and_weber_s_form() -> None:
    assert sustained_level(5.0, PARAMETERS) == pytest.approx(0.12)
    assert sustained_level(250.0, PARAMETERS) == pytest.approx(1.0)
    # A quarter of the way up in force: 0.12 + 0.88 ln(6)/ln(21).
    quarter = sustained_level(5.0 + 0.25 * 245.0, PARAMETERS)
    assert quarter == pytest.approx(0.12 + 0.88 * math.log(6) / math.log(21))
    # More resolution for small forces than for large ones.
    assert quarter - 0.12 > 2 * (1.0 - sustained_level(5.0 + 0.75 * 245.0, PARAMETERS))


@settings(deadline=None)
@given(rate=st.floats(-1e6, 1e6), more=st.floats(0, 1e4))
def test_impact_level_is_even_monotone_and_in_range(rate: float, more: float) -> None:
    level = impact_level(rate, PARAMETERS)
    assert 0.0 <= level <= 1.0
    assert impact_level(-rate, PARAMETERS) == level
    assert impact_level(abs(rate) + more, PARAMETERS) >= level
    if abs(rate) <= MAPPING.impact_threshold:
        assert level == 0.0


@settings(max_examples=100, deadline=None)
@given(forces=arrays(float, (20, 3), elements=st.floats(-1e4, 1e4)))
def test_levels_stay_in_range_and_within_the_slew_limits(forces: np.ndarray) -> None:
    memory, rumble = np.zeros(3), np.zeros(2)
    for force in forces:
        before = rumble.copy()
        haptics_step(force, PARAMETERS, memory, rumble)
        assert ((rumble >= 0.0) & (rumble <= 1.0)).all()
        change = rumble - before
        assert change.max() <= 8.0 / 30 + 1e-12
        assert change.min() >= -20.0 / 30 - 1e-12


@settings(max_examples=50, deadline=None)
@given(forces=st.lists(st.floats(-4.999, 4.999), min_size=1, max_size=30))
def test_nothing_below_the_threshold(forces: list[float]) -> None:
    np.testing.assert_array_equal(levels(forces), 0.0)


def test_hysteresis_between_the_thresholds() -> None:
    assert settled(4.5) == 0.0
    engaged = levels([10.0] * 20 + [4.5] * 60)
    assert engaged[-1, 0] == pytest.approx(0.12)  # 4.5 N is above 0.8 of 5 N
    released = levels([10.0] * 20 + [4.5] * 20 + [3.9] * 20 + [4.5] * 20)
    assert released[-1, 0] == 0.0


def test_settled_low_level_is_the_sustained_level_and_the_high_one_is_off() -> None:
    for force in (6.0, 30.0, 100.0, 400.0):
        history = levels([force] * 60)
        assert history[-1, 0] == pytest.approx(sustained_level(force, PARAMETERS))
        assert history[-1, 1] == 0.0
    assert settled(-100.0) == settled(100.0)


def test_an_impact_makes_a_burst_that_decays_and_grows_with_its_rate() -> None:
    hard, soft = levels([0.0] + [200.0] * 30)[:, 1], levels([0.0] + [60.0] * 30)[:, 1]
    assert 0.2 < soft.max() < hard.max()
    assert hard.argmax() <= 4  # within 0.1 s of it
    assert (np.diff(hard[4:]) <= 0.0).all()
    # Decay of exp(-t / 80 ms), once the slew limit is behind.
    np.testing.assert_allclose(hard[7:12] / hard[6:11], math.exp(-MAPPING.period / 0.08), rtol=1e-9)
    gentle = levels([5.0 * k for k in range(30)])[:, 1]  # 150 N/s
    np.testing.assert_array_equal(gentle, 0.0)


def test_slew_makes_a_straight_rise() -> None:
    slow = replace(MAPPING, slew_up=3.0, slew_down=6.0)
    history = levels([400.0] * 20 + [0.0] * 20, slow)[:, 0]
    np.testing.assert_allclose(history[:10], 3.0 * MAPPING.period * np.arange(1, 11))
    np.testing.assert_allclose(
        history[20:25], 1.0 - 6.0 * MAPPING.period * np.arange(1, 6), atol=1e-12
    )


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_a_force_that_is_not_finite_stops_the_low_motor_without_a_burst(bad: float) -> None:
    history = levels([20.0] * 30 + [bad] * 10)
    assert np.isfinite(history).all()
    np.testing.assert_array_equal(history[-1], [0.0, 0.0])
    np.testing.assert_array_equal(history[30:, 1], 0.0)


class FakeDevice:
    name = "fake"

    def __init__(self) -> None:
        self.pulses: list[tuple[float, float, int]] = []

    def sample(self) -> Sample:
        return at_rest(0.0)

    def rumble(self, low: float, high: float, milliseconds: int) -> bool:
        self.pulses.append((low, high, milliseconds))
        return True

    def close(self) -> None:
        pass


def with_force(system: HapticOutput, force: float) -> Context:
    context = system.CreateDefaultContext()
    system.GetInputPort("f_haptic").FixValue(context, np.array([0.0, force, 0.0]))
    return context


def test_ports_and_initial_output() -> None:
    system = HapticOutput(MAPPING)
    assert system.GetInputPort("f_haptic").size() == 3
    output = system.GetOutputPort("rumble")
    assert output.size() == 2
    np.testing.assert_array_equal(output.Eval(with_force(system, 100.0)), [0.0, 0.0])


def test_system_steps_the_pure_function_at_its_period() -> None:
    system = HapticOutput(MAPPING)
    context = with_force(system, 100.0)
    Simulator(system, context).AdvanceTo(0.15)  # ticks at 0, 33, 66, 99, 132 ms
    wanted = levels([100.0] * 5)[-1]
    np.testing.assert_array_equal(system.GetOutputPort("rumble").Eval(context), wanted)


def test_device_gets_each_update_as_a_short_pulse() -> None:
    device = FakeDevice()
    system = HapticOutput(MAPPING, device)
    Simulator(system, with_force(system, 100.0)).AdvanceTo(0.15)
    wanted = levels([100.0] * 5)
    np.testing.assert_array_equal([pulse[:2] for pulse in device.pulses], wanted)
    assert {pulse[2] for pulse in device.pulses} == {150}


def test_evaluating_the_output_does_not_shake_the_device() -> None:
    device = FakeDevice()
    system = HapticOutput(MAPPING, device)
    system.GetOutputPort("rumble").Eval(with_force(system, 100.0))
    assert device.pulses == []


def test_clone_and_second_run_give_equal_bits() -> None:
    system = HapticOutput(MAPPING)
    context = with_force(system, 80.0)
    simulator = Simulator(system, context)
    simulator.AdvanceTo(0.1)
    clone = context.Clone()
    simulator.AdvanceTo(0.4)
    Simulator(system, clone).AdvanceTo(0.4)
    port = system.GetOutputPort("rumble")
    np.testing.assert_array_equal(port.Eval(context), port.Eval(clone))
    fresh = with_force(system, 80.0)
    np.testing.assert_array_equal(port.Eval(fresh), [0.0, 0.0])
    Simulator(system, fresh).AdvanceTo(0.4)
    np.testing.assert_array_equal(port.Eval(fresh), port.Eval(context))


@pytest.mark.parametrize(
    ("field", "value", "named"),
    [
        ("force_threshold", -1.0, "mapping.force_threshold: -1.0"),
        ("release_ratio", 1.1, "mapping.release_ratio: 1.1, allowed 0 to 1"),
        ("force_full", 5.0, "mapping.force_full: 5.0, allowed 5.005"),
        ("curvature", 0.0, "mapping.curvature: 0.0"),
        ("level_minimum", math.nan, "mapping.level_minimum: nan"),
        ("impact_threshold", math.inf, "mapping.impact_threshold: inf"),
        ("impact_full", 100.0, "mapping.impact_full: 100.0"),
        ("burst_time", 0.0, "mapping.burst_time: 0.0"),
        ("slew_up", 0.0, "mapping.slew_up: 0.0"),
        ("slew_down", -1.0, "mapping.slew_down: -1.0"),
        ("period", 1e-3, "mapping.period: 0.001, allowed 0.01 to 0.1"),
    ],
)
def test_bad_fields_are_named(field: str, value: Any, named: str) -> None:
    with pytest.raises(ValueError, match=named):
        HapticOutput(replace(MAPPING, **{field: value}))


def test_reads_from_yaml() -> None:
    mapping = yaml_load_typed(schema=HapticMapping, data="{force_full: 90}", defaults=MAPPING)
    assert mapping == HapticMapping(force_full=90.0)
