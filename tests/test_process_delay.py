"""Process delays: the delays, and the readings of the paper's zeta(t) and d(t)."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from pydrake.common.yaml import yaml_dump, yaml_dump_typed, yaml_load, yaml_load_typed

from scara_drake import joints, robot
from scara_drake.channel.delays import ConstantDelay, SineDelay
from scara_drake.common.fields import check
from scara_drake.control.process_delay import (
    CONTROL_DELAY_READINGS,
    ProcessDelay,
    perturbation_reading,
)
from scara_drake.plant.perturbation import JointPerturbation


@dataclass
class Parts:
    process_delay: ProcessDelay | None = None
    perturbation: JointPerturbation | None = None


def parts(overrides):
    """The parts of a scenario with these overrides."""
    data: dict[str, dict[str, Any]] = {}
    for key, value in overrides.items():
        part, name = key.split(".")
        data.setdefault(part, {})[name] = value
    return yaml_load_typed(schema=Parts, data=yaml_dump(data), defaults=Parts())


def test_reading_a_delays_the_input_by_zeta_and_the_state_by_d_where_they_are_positive():
    delay = parts(CONTROL_DELAY_READINGS["A"]).process_delay
    check(delay, "process_delay")
    assert delay.reference is None
    for t in np.linspace(0.0, 7.0, 71):
        ms = 1e3 * np.array([d.at(t) for d in (delay.actuation, delay.measurement)])
        wanted = [max(100 * math.sin(t), 0.0), max(100 * math.cos(t), 0.0)]
        np.testing.assert_allclose(ms, wanted, atol=1e-9)


@pytest.mark.parametrize("joint", [None, *joints.JOINT_NAMES])
def test_reading_b_adds_zeta_and_d_to_u(joint):
    perturbation = parts(perturbation_reading(joint)).perturbation
    check(perturbation, "perturbation")
    system = perturbation.make_system()
    context = system.CreateDefaultContext()
    on = np.array([joint in (None, name) for name in joints.JOINT_NAMES])
    peak = 0.0
    for t in np.linspace(0.0, 6.3, 64):
        context.SetTime(t)
        u = system.get_output_port().Eval(context) / robot.nominal_inertias()
        np.testing.assert_allclose(u, on * (100 * math.sin(t) + 100 * math.cos(t)), atol=1e-9)
        peak = max(peak, np.abs(u).max())
    assert peak == pytest.approx(141.4, abs=0.2)


def test_reading_c_delays_the_command_alone():
    assert parts(CONTROL_DELAY_READINGS["C"]) == Parts(ProcessDelay(reference=SineDelay(0.1)))


def test_an_unknown_joint_is_refused():
    with pytest.raises(ValueError, match=r"joint: 'theta7', allowed d1, theta2"):
        perturbation_reading("theta7")


def test_delays_read_from_yaml_and_write_back():
    text = "{actuation: !ConstantDelay {delay: 0.001}, measurement: null}"
    delay = yaml_load_typed(schema=ProcessDelay, data=text, defaults=ProcessDelay())
    assert delay == ProcessDelay(actuation=ConstantDelay(0.001))
    assert yaml_load_typed(schema=ProcessDelay, data=yaml_dump_typed(delay)) == delay
    assert yaml_load(data=yaml_dump(CONTROL_DELAY_READINGS["A"]), private=True)


@pytest.mark.parametrize(
    ("delay", "named"),
    [
        (ProcessDelay(actuation=ConstantDelay(-1.0)), r"p\.actuation\.delay: -1\.0"),
        (ProcessDelay(measurement=SineDelay(math.nan)), r"p\.measurement\.amplitude: nan"),
        (
            ProcessDelay(reference=SineDelay(2.0, 1.0)),
            r"p\.reference: a delay of up to 3 s, allowed 0 to 2\.5 s",
        ),
    ],
)
def test_bad_delays_are_named(delay, named):
    with pytest.raises(ValueError, match=named):
        check(delay, "p")
    check(ProcessDelay(), "p")
