import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from leaf import ports
from strategies import examples

from scara_drake import joints, load_scenario, robot
from scara_drake.common.fields import check
from scara_drake.kinematics import forward_kinematics
from scara_drake.operator.joint_motion import JointMotion, JointMotionSource, joint_reference

MOTION = JointMotion(
    base=[3.0, 0.1, 0.2, 0.3, 0.4, 0.5],
    amplitude=[0.0, 0.7854, 0.0, 0.7854, 0.0, 0.1],
    frequency=[0.0, 1.25, 0.0, 1.25, 0.0, 2.0],
    displacement=[0.5, 0.0, -0.2, 0.0, 0.0, 0.0],
    start=1.0,
    move_duration=2.0,
)


def state_at(t):
    state = np.empty(12)
    joint_reference(t, MOTION.parameters(), state)
    return state


@settings(deadline=None)
@given(st.floats(0.0, 5.0))
def test_rates_are_the_derivative_of_the_positions(t):
    h = 1e-5
    slope = (state_at(t + h)[:6] - state_at(t - h)[:6]) / (2 * h)
    np.testing.assert_allclose(state_at(t)[6:], slope, atol=1e-6)


def test_the_move_goes_from_rest_to_rest():
    np.testing.assert_allclose(state_at(1.0)[[0, 2, 6, 8]], [3.0, 0.2, 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(state_at(2.0)[[0, 2]], [3.25, 0.1])
    np.testing.assert_allclose(state_at(9.0)[[0, 2, 6, 8]], [3.5, 0.0, 0.0, 0.0], atol=1e-12)


def test_a_motion_out_of_the_joint_range_is_refused():
    with pytest.raises(ValueError, match=r"operator at its extreme: d1 = 10\.3 m, allowed 2\.5 to"):
        check(JointMotion(displacement=[7.3, 0, 0, 0, 0, 0]), "operator")
    with pytest.raises(ValueError, match=r"^operator\.base: theta4 = -3 rad, allowed"):
        check(JointMotion(base=[3.0, 0.0, 0.0, -3.0, 0.0, 0.0]), "operator")


def test_source_ports_and_outputs():
    source = JointMotionSource(MOTION)
    assert ports(source) == ({}, {"state_desired": 12, "X_WE_desired": 7})
    context = source.CreateDefaultContext()
    context.SetTime(1.7)
    np.testing.assert_array_equal(source.get_output_port(0).Eval(context), state_at(1.7))
    pose = source.GetOutputPort("X_WE_desired").Eval(context)
    np.testing.assert_allclose(pose[:3], forward_kinematics(state_at(1.7)[:6])[:3, 3])


@st.composite
def motions(draw):
    """Sines and a move of one joint, fast and slow, within its range."""
    i = draw(st.integers(0, 5))
    room = 0.2 * (joints.UPPER[i] - joints.LOWER[i])
    made = {name: [0.0] * 6 for name in ("amplitude", "frequency", "displacement")}
    base = joints.HOME.tolist()
    base[i] = 0.5 * (joints.UPPER[i] + joints.LOWER[i])
    made["amplitude"][i] = draw(st.floats(-room, room))
    made["frequency"][i] = 10.0 ** draw(st.floats(-2.0, 3.0))
    made["displacement"][i] = draw(st.floats(-room, room))
    return JointMotion(base, **made, move_duration=10.0 ** draw(st.floats(-3.0, 2.0)))  # type: ignore[arg-type]  # six floats each


def refusal(motion):
    try:
        check(motion, "operator")
    except ValueError as refused:
        return str(refused)
    return None


@examples(200)
@given(motions())
def test_a_motion_that_is_taken_asks_for_no_more_than_the_drives_have(motion):
    if (refused := refusal(motion)) is not None:
        assert "\n" not in refused
        assert re.search(r"operator(\.\w+(\[\d\])?| at its extreme): .*, allowed", refused)
        return
    parameters, state = motion.parameters(), np.empty(12)
    move = motion.start + motion.move_duration * np.linspace(0.0, 1.0, 101)
    highest, speeds = np.zeros(6), []
    for t in move:
        joint_reference(t, parameters, state)
        highest = np.maximum(highest, np.abs(state[6:]))
        speeds.append(state[6:].copy())
    assert (highest <= joints.MAX_SPEED * (1.0 + 1e-4)).all()
    mean = np.abs(np.diff(speeds, axis=0)) / np.diff(move)[:, None]
    assert (mean <= robot.drive_accelerations() * (1.0 + 1e-3)).all()


@pytest.mark.parametrize(
    ("overrides", "field"),
    [
        ({"operator.frequency": 1000.0}, "operator.frequency[1]"),
        ({"operator.move_duration": 0.1}, "operator.move_duration"),
        (
            {"operator.amplitude": [0, 1e-3, 0, 0, 0, 0], "operator.frequency": 300.0},
            "operator.frequency[1]",
        ),
    ],
)
def test_the_largest_that_is_allowed_is_allowed(overrides, field):
    with pytest.raises(ValueError, match=rf"^{re.escape(field)}: .* allowed") as refused:
        load_scenario("joint_sine", overrides)
    (text,) = re.findall(r"allowed (?:up to )?([\d.e+-]+)", str(refused.value))
    value = float(text)
    key = field.partition("[")[0]
    slack = 1.0 - 1e-3 if "frequency" in key else 1.0 + 1e-3
    load_scenario("joint_sine", {**overrides, key: value * slack})
    with pytest.raises(ValueError, match="allowed"):
        load_scenario("joint_sine", {**overrides, key: value * (2.0 - slack) * (2.0 - slack)})
