"""Figures 18 and 19: sines with an arm that the law does not know, and how they are judged."""

import functools

import numpy as np
import pytest

from scara_drake import joints
from scara_drake.experiments.claim import IN_KIND, NOT_COMPARABLE, NOT_REPRODUCED, REPRODUCED
from scara_drake.experiments.control import figures_18_19 as figures
from scara_drake.kinematics import forward_kinematics

NOMINAL, UP, DOWN, LOAD = figures.RUNS


@functools.cache
def experiment():
    return figures.run()


def error():
    data = experiment().data.sel(time=slice(1.0, None))
    return abs(data.q_desired - data.q_measured).max("time")


def verdicts(claims):
    return [claim.verdict for claim in claims]


def test_data_are_labelled():
    data = experiment().data
    for variable in data.data_vars.values():
        assert {"units", "long_name"} <= set(variable.attrs)
        assert np.isfinite(variable).all()
    assert list(data.joint.values) == list(joints.JOINT_NAMES)


def test_the_references_are_the_paper_s_sines():
    data = experiment().data.sel(run=NOMINAL)
    sine = 0.7854 * np.sin(1.25 * data.time)
    np.testing.assert_allclose(data.q_desired.sel(joint="theta2"), sine, atol=1e-12)
    np.testing.assert_allclose(data.q_desired.sel(joint="theta4"), 0.2 + sine, atol=1e-12)


def test_joints_track_after_the_first_second():
    nominal = error().sel(run=NOMINAL)
    assert (nominal.sel(joint=["theta2", "theta4"]) < 0.3e-3).all()
    assert (error().sel(joint=figures.ARM) < 3e-3).all()


def test_the_torque_is_quiet_in_every_run():
    tau = experiment().data.tau.sel(time=slice(1.0, None), joint=figures.ARM)
    assert (abs(tau.diff("time")).mean("time") < 1.0).all()


@pytest.mark.parametrize(
    ("name", "mass"), [(NOMINAL, 735.5), (UP, 956.15), (DOWN, 514.85), (LOAD, 745.5)]
)
def test_the_arms_differ_as_their_names_say(name, mass):
    # The mast carries all of it, and stands still after 6 s.
    force = experiment().data.tau.sel(run=name, joint="d1", time=slice(7.0, None))
    np.testing.assert_allclose(force.mean("time"), 9.81 * mass, rtol=1e-3)


def test_the_load_is_off_the_tool_s_axis():
    # Turning joint 6 carries it around by its whole offset: half a turn moves it by twice that.
    q = np.array([joints.HOME, joints.HOME])
    q[1, 5] = np.pi
    X = forward_kinematics(q)
    offset = figures.RUNS[LOAD]["robot.payload_offset"]
    places = X[:, :3, 3] + X[:, :3, :3] @ np.array(offset)
    assert np.linalg.norm(places[1] - places[0]) == pytest.approx(0.2)


def test_verdicts():
    assert verdicts(experiment().claims) == [REPRODUCED, REPRODUCED, REPRODUCED, NOT_COMPARABLE]


def test_it_judges_what_it_is_given():
    data = experiment().data.copy(deep=True)
    late = {"time": slice(1.0, None)}
    data.q_measured.loc[{"run": NOMINAL, "joint": "theta2", **late}] += 1e-3
    data.q_measured.loc[{"run": LOAD, "joint": "theta6", **late}] += 5e-3
    data.tau.loc[{"run": NOMINAL, "joint": "theta3"}] += 2.0 * (np.arange(data.time.size) % 2)
    assert verdicts(figures.claims(data))[:3] == [IN_KIND, NOT_REPRODUCED, NOT_REPRODUCED]
    data.q_measured.loc[{"joint": "theta2", **late}] += 1e-2
    assert verdicts(figures.claims(data))[0] == NOT_REPRODUCED
