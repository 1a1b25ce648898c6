"""Figures 20, 21, 23 to 27 and 28: the experiments' own arithmetic, on short runs."""

import numpy as np
import pytest

from scara_drake import joints
from scara_drake.experiments.quantity import text
from scara_drake.experiments.teleoperation import figure_28, figures_20_27


@pytest.fixture(scope="module")
def motion():
    return figures_20_27.run(duration=4.0)


@pytest.fixture(scope="module")
def haptics():
    return figure_28.run(duration=19.0)


def test_the_parts_of_the_tool_error_add_up(motion):
    data = motion.data
    whole = data.p_WE_commanded - data.p_WE_measured
    np.testing.assert_allclose(data.tool_error.sum("part"), whole, atol=1e-12)


def test_the_channel_s_part_is_the_motion_during_its_delay(motion):
    # free_motion delays by 0.1 (1 + sin t); its block is read one sample later.
    data = motion.data.sel(run="normalised", axis="x")
    t = data.time.values
    past = np.interp(t - 0.1 * (1 + np.sin(t - 1e-3)) - 1e-3, t, data.p_WE_commanded)
    np.testing.assert_allclose(data.p_WE_received, past, atol=1e-5)


def test_the_mast_in_mm_and_n_hangs_by_the_weight_that_its_integral_leaves(motion):
    data = motion.data.sel(run="mast in mm and N", joint="d1")
    expected = 1e-3 * (735.5 * 9.81 - 500.0) / (150.0 * 50.0)  # [m], (m g - rho) / (k c)
    error = float((data.q_desired - data.q_measured)[-1])
    assert error == pytest.approx(expected, rel=0.02)
    plain = motion.data.sel(run="normalised", joint="d1")
    assert abs(float((plain.q_desired - plain.q_measured)[-1])) < 1e-5


def test_joints_track_after_the_first_second(motion):
    data = motion.data.sel(run="normalised", time=slice(1.0, None))
    error = abs(data.q_desired - data.q_measured).max("time")
    assert (error < 1e-3).all()
    assert list(error.joint.values) == list(joints.JOINT_NAMES)


def test_the_force_felt_is_the_contact_force_one_delay_ago(haptics):
    for channel in figure_28.CHANNELS:
        assert figure_28.lag_error(haptics.data, channel) < 0.5


def test_delays_are_felt_at_the_edges_of_the_press(haptics):
    # Constant part of 1 + sin t each way: an edge comes up + down later.
    data = haptics.data
    touch = {c: figure_28.edges(data.force_felt.sel(channel=c)).values for c in figure_28.CHANNELS}
    first = touch["none"][0]
    late = touch["paper_offset"][0] - first
    assert 0.0 < late < 0.4
    np.testing.assert_allclose(figure_28.late(data, "none"), 0.0)


@pytest.mark.parametrize("name", ["motion", "haptics"])
def test_claims_have_a_criterion(name, request):
    for claim in request.getfixturevalue(name).claims:
        assert claim.reason
        assert "nan" not in text(claim.measured) or claim.verdict != "reproduced"
