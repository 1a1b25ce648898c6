import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from leaf import ports

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
