import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from kinds import of_kind
from leaf import ports, tick

from scara_drake import load_scenario, simulate
from scara_drake.environment import Wall
from scara_drake.operator.joystick import Joystick
from scara_drake.operator.kinesthetic import KinestheticMapping, KinestheticOutput, step_kinesthetic

forces = st.lists(st.floats(-1e4, 1e4), min_size=3, max_size=3).map(np.array)


@settings(deadline=None)
@given(st.lists(forces, min_size=1, max_size=30))
def test_force_keeps_its_limit_and_its_slew(sequence):
    felt = np.zeros(3)
    for force in sequence:
        before = felt.copy()
        step_kinesthetic(force, 0.02, 3.3, 0.5, felt)
        assert np.linalg.norm(felt) <= 3.3 * (1 + 1e-12)
        assert np.linalg.norm(felt - before) <= 0.5 * (1 + 1e-12)


@given(forces)
def test_settled_force_is_scaled_and_keeps_its_direction(force):
    felt = np.zeros(3)
    step_kinesthetic(force, 0.02, 3.3, np.inf, felt)
    size = 0.02 * np.linalg.norm(force)
    expected = 0.02 * force * (min(1.0, 3.3 / size) if size > 0.0 else 1.0)
    np.testing.assert_allclose(felt, expected, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_what_is_not_finite_relaxes_the_hand(bad):
    felt = np.array([1.0, 0.0, 0.0])
    step_kinesthetic(np.array([bad, 0.0, 0.0]), 0.02, 3.3, 0.25, felt)
    np.testing.assert_allclose(felt, [0.75, 0.0, 0.0])


def test_system():
    system = KinestheticOutput(KinestheticMapping(scale=0.1, limit=10.0, slew=1e3))
    assert ports(system) == ({"f_haptic": 3}, {"f_kinesthetic": 3})
    context = system.CreateDefaultContext()
    system.get_input_port().FixValue(context, [0.0, 50.0, 0.0])
    for expected in (1.0, 2.0, 3.0, 4.0, 5.0, 5.0):
        tick(system, context)
        np.testing.assert_allclose(system.get_output_port().Eval(context), [0.0, expected, 0.0])


def test_a_scenario_with_a_kinesthetic_device_records_its_force():
    scenario = load_scenario("teleoperation", {"kinesthetic": "{scale: 0.05, slew: 1000000.0}"})
    of_kind(Joystick, scenario.operator).mapping.centre[1] = -0.97  # [m]
    wall = of_kind(Wall, scenario.environment.surfaces[0])
    wall.point[1] = -0.968  # [m]: the tool begins 2 mm inside
    run = simulate(scenario, duration=0.5)
    assert float(abs(run.f_haptic).max()) > 1.0
    expected = (0.05 * run.f_haptic).clip(-3.3, 3.3)
    np.testing.assert_allclose(run.f_kinesthetic[1:], expected[:-1], atol=1e-9)


@pytest.mark.parametrize(("field", "value"), [("scale", -1.0), ("limit", 0.0), ("slew", np.nan)])
def test_bad_fields_are_named(field, value):
    with pytest.raises(ValueError, match=rf"^mapping\.{field}: "):
        KinestheticOutput(KinestheticMapping(**{field: value}))
