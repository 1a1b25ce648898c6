"""scara_drake.perturbation."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from leaf import ports
from pydrake.common.yaml import yaml_load_typed

from scara_drake import robot
from scara_drake.common.fields import check
from scara_drake.plant.perturbation import JointPerturbation, JointPerturbationSource

M_HAT = robot.nominal_inertias()


def force(perturbation, t):
    system = perturbation.make_system()
    context = system.CreateDefaultContext()
    context.SetTime(t)
    return system.get_output_port().Eval(context)


@given(
    t=st.floats(0, 100),
    offset=st.floats(-200, 200),
    amplitude=st.floats(-200, 200),
    frequency=st.floats(0, 50),
    phase=st.floats(-math.pi, math.pi),
)
@settings(deadline=None)
def test_it_is_an_offset_and_a_sine_times_the_nominal_inertia(
    t, offset, amplitude, frequency, phase
):
    joints = np.arange(6.0)
    perturbation = JointPerturbation(
        (offset * joints).tolist(), [amplitude] * 6, [frequency] * 6, [phase] * 6
    )
    wanted = M_HAT * (offset * joints + amplitude * math.sin(frequency * t + phase))
    np.testing.assert_allclose(force(perturbation, t), wanted, rtol=1e-9, atol=1e-6)


@pytest.mark.parametrize(
    ("t", "acts"), [(0.0, False), (0.999, False), (1.0, True), (1.999, True), (2.0, False)]
)
def test_it_acts_from_start_until_stop(t, acts):
    wanted = M_HAT * 3.0 * acts
    np.testing.assert_allclose(force(JointPerturbation([3.0] * 6, start=1.0, stop=2.0), t), wanted)


def test_by_default_there_is_none():
    np.testing.assert_array_equal(force(JointPerturbation(), 1.0), np.zeros(6))


def test_ports():
    system = JointPerturbationSource(JointPerturbation())
    assert ports(system) == ({}, {"perturbation_force": 6})


def test_it_reads_from_yaml():
    read = yaml_load_typed(
        schema=JointPerturbation,
        data="{amplitude: [0, 5, 0, 0, 0, 0], start: 2.0}",
        defaults=JointPerturbation(),
    )
    assert read == JointPerturbation(amplitude=[0, 5, 0, 0, 0, 0], start=2.0)
    check(read, "p")


@pytest.mark.parametrize(
    ("perturbation", "named"),
    [
        (JointPerturbation(offset=[0.0] * 5), r"p\.offset: 5 entries, allowed 6"),
        (JointPerturbation(amplitude=[math.inf] * 6), r"p\.amplitude\[0\]: inf"),
        (JointPerturbation(frequency=[-1.0] * 6), r"p\.frequency\[0\]: -1\.0, allowed 0 to"),
        (JointPerturbation(phase=[10.0] * 6), r"p\.phase\[0\]: 10\.0"),
        (JointPerturbation(start=2.0, stop=1.0), r"p\.stop: 1\.0, allowed 2 to 86400"),
        (JointPerturbation(start=-1.0), r"p\.start: -1\.0"),
    ],
)
def test_bad_fields_are_named(perturbation, named):
    with pytest.raises(ValueError, match=named):
        check(perturbation, "p")
