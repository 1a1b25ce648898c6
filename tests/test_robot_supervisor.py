"""The robot's supervisor: what it lets through, how it stops, and how it goes on."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from robot_rig import DT, Rig, command_at, moved
from strategies import examples

from scara_drake import joints
from scara_drake.common.motion import limit_motion
from scara_drake.safety import Reason, State
from scara_drake.supervision.config import RobotSupervision
from scara_drake.supervision.placing import offset_between, put_beside, stopping_way
from scara_drake.vectors import COMMAND_FRAME, SERVO_STATE, TOOL_COMMAND

REST = 5e-3  # [m/s]
STOP_TICKS = 400


def triples(most):
    return st.lists(st.floats(-most, most), min_size=3, max_size=3)


def at_full_speed(**more):
    """A rig whose tool goes at 0.5 m/s, and whose mast at 0.2 m/s."""
    rig = Rig(**more)
    rig.engage()
    rig.step(2)
    for _ in range(600):
        rig.command = moved(rig.command, (0.0, 0.45 * DT, 0.0), 0.2 * DT)
        rig.step()
    v, mast = rig.velocities()
    assert np.linalg.norm(v[-1]) > 0.45
    assert mast[-1] > 0.18
    return rig


def stopped_at(rig, since):
    """The tick, from `since` on, after which tool and mast are at rest."""
    v, mast = rig.velocities()
    fast = (np.linalg.norm(v, axis=1) > REST) | (abs(mast) > REST)
    return int(np.flatnonzero(fast)[-1]) + 1 - since if fast[since:].any() else 0


def assert_smooth(rig, since):
    """No step of the commanded velocity beyond what the limiter may."""
    v, mast = rig.velocities()
    change = np.linalg.norm(np.diff(v[since - 1 :], axis=0), axis=1)
    assert change.max() <= rig.kinematics.max_acceleration * DT * (1 + 1e-9)
    assert abs(np.diff(mast[since - 1 :])).max() <= rig.kinematics.mast_acceleration * DT + 1e-12
    assert (abs(rig.joint_rates()) <= joints.MAX_SPEED + 1e-9).all()


NO_NUMBER, NO_ROTATION = np.full(8, np.nan), np.zeros(8)
NOT_MEASURED, GIVES = Reason.BAD_MEASUREMENT, Reason.CHANNEL_ENERGY
STOPS: dict[str, tuple[dict[str, Any], State, Reason, int]] = {
    "the command is lost": ({"lost": True}, State.HOLD, Reason.COMMAND_LOST, 1),
    "the operator lets go": ({"operator": State.HOLD}, State.HOLD, Reason.HELD, 0),
    "his side has a fault": ({"operator": State.FAULT}, State.HOLD, Reason.HELD, 0),
    "the emergency stop": ({"operator": State.ESTOP}, State.ESTOP, Reason.ESTOP_PRESSED, 1),
    "no number in the command": ({"command": NO_NUMBER}, State.FAULT, Reason.BAD_COMMAND, 1),
    "no rotation in the command": ({"command": NO_ROTATION}, State.FAULT, Reason.BAD_COMMAND, 1),
    "no number is measured": ({"arm": NOT_MEASURED}, State.FAULT, NOT_MEASURED, 1),
    "the channel gives energy": ({"link_fault": GIVES}, State.FAULT, GIVES, 1),
}


@pytest.mark.parametrize("name", STOPS)
def test_each_stop_brakes_tool_and_mast_without_a_step(name):
    changes, state, reason, faults = STOPS[name]
    rig = at_full_speed()
    since = len(rig.statuses)
    for attribute, value in changes.items():
        setattr(rig, attribute, value)
    assert rig.step() == (state, reason, 1, faults)
    rig.step(STOP_TICKS + 200)
    assert stopped_at(rig, since) < STOP_TICKS
    assert_smooth(rig, since)
    here = rig.desired.copy()
    rig.step(200)
    assert abs(rig.desired[:6] - here[:6]).max() < 1e-6


@examples(20)
@given(st.floats(0.0, 2.0), st.floats(0.1, 20.0), st.floats(5.0, 100.0))
def test_the_stopping_point_is_reached_as_fast_as_it_may_and_not_passed(speed, acceleration, b):
    error = np.array([stopping_way(speed, acceleration, b)])
    start, rate, ticks = error[0], np.array([speed]), 0
    bound = speed / acceleration + 8.0 / b
    while abs(rate[0]) > REST and ticks < 20000:
        limit_motion(error, rate, 1e3, acceleration, b, 1e-4)
        error -= 1e-4 * rate
        ticks += 1
        assert error[0] > -0.02 * start - 1e-5
    assert ticks * 1e-4 <= bound


def test_nobody_moves_the_arm_before_he_engages():
    rig = Rig()
    rig.command = moved(rig.command, (0.2, 0.1, 0.0), 0.3)
    assert rig.step(300) == (State.IDLE, Reason.NONE, 0, 0)
    assert (rig.joint_rates() == 0.0).all()


@examples(20)
@given(triples(2.0), st.floats(-3.0, 3.0), triples(1.0))
def test_an_engagement_moves_nothing_whatever_is_commanded(p, mast, axis):
    rig = Rig()
    command = TOOL_COMMAND.unpack(moved(rig.command, p, mast).copy())
    turned = np.array([0.5, *axis]) / np.linalg.norm([0.5, *axis])
    rig.command = TOOL_COMMAND.pack(p=command.p, quaternion=turned, mast=command.mast)
    rig.step(5)
    rig.engage()
    assert rig.step()[0] == State.ACTIVE
    rig.step(300)
    assert abs(rig.joint_rates()).max() < 1e-6


def test_after_it_the_arm_follows_what_is_asked_from_there():
    rig = Rig()
    start = rig.let_through.copy()
    rig.command = moved(rig.command, (0.5, -0.3, 0.1))
    rig.engage()
    rig.step(2)
    rig.command = moved(rig.command, (0.0, 0.05, -0.04))
    rig.step(1500)
    place = SERVO_STATE.unpack(rig.servo).p
    np.testing.assert_allclose(place, np.add(start[:3], [0.0, 0.05, -0.04]), atol=1e-4)


@examples(20)
@given(st.integers(0, 2**32 - 1))
def test_offsets_put_the_first_command_where_the_arm_is_held(seed):
    rng = np.random.default_rng(seed)
    one, other, offset, placed = (rng.normal(size=8) for _ in range(4))
    for command in (one, other):
        command[3:7] /= np.linalg.norm(command[3:7])
    offset_between(one, other, offset)
    put_beside(one, offset, placed)
    sign = np.sign(np.dot(placed[3:7], other[3:7]))
    np.testing.assert_allclose(placed[:3], other[:3], atol=1e-12)
    np.testing.assert_allclose(sign * placed[3:7], other[3:7], atol=1e-12)
    assert placed[7] == pytest.approx(other[7])


def test_after_an_outage_the_arm_waits_until_it_is_engaged_again_and_makes_nothing_up():
    rig = at_full_speed()
    rig.lost = True
    rig.step(600)
    rig.command = moved(rig.command, (0.3, -0.4, 0.1))  # asked for meanwhile
    rig.lost = False
    here = rig.desired[:6].copy()
    assert rig.step(300)[:2] == (State.HOLD, Reason.COMMAND_LOST)
    assert abs(rig.desired[:6] - here).max() < 1e-6
    rig.operator = State.HOLD
    rig.step(5)
    rig.engage()
    assert rig.step(300) == (State.ACTIVE, Reason.NONE, 2, 1)
    assert abs(rig.desired[:6] - here).max() < 1e-6


def test_an_engagement_from_within_the_outage_is_none():
    rig = at_full_speed()
    rig.lost = True
    rig.step(300)
    rig.engage()
    rig.lost = False
    assert rig.step(300)[0] == State.HOLD
    rig.engage()
    assert rig.step()[0] == State.ACTIVE


def test_a_scenario_may_let_it_go_on_by_itself_which_makes_nothing_up_either():
    rig = at_full_speed(config=RobotSupervision(after_outage="resume"))
    rig.lost = True
    rig.step(600)
    rig.command, rig.lost = moved(rig.command, (0.3, -0.4, 0.1)), False
    here = rig.desired[:6].copy()
    assert rig.step() == (State.ACTIVE, Reason.NONE, 2, 1)
    rig.step(300)
    assert abs(rig.desired[:6] - here).max() < 1e-6


@pytest.mark.parametrize("stop", ["no number is measured", "the emergency stop"])
def test_a_latch_opens_only_by_a_reset_of_a_side_that_knew(stop):
    rig = at_full_speed()
    changes, state, reason, _ = STOPS[stop]
    before = {name: getattr(rig, name) for name in changes}
    for name, value in changes.items():
        setattr(rig, name, value)
    rig.step(400)
    for name, value in before.items():
        setattr(rig, name, value)
    if state == State.FAULT:
        rig.operator = State.IDLE  # a reset that was pressed before the fault was heard of
        assert rig.step(5)[:2] == (state, reason)
        rig.engage()
        assert rig.step(5)[:2] == (state, reason)
        rig.operator = State.FAULT
    else:
        rig.operator = State.ESTOP
    assert rig.step(5)[:2] == (state, reason)
    rig.operator = State.IDLE
    assert rig.step()[:2] == (State.IDLE, Reason.NONE)
    rig.step(50)
    rig.engage()
    assert rig.step()[0] == State.ACTIVE


def test_a_fault_stays_while_its_cause_does():
    rig = at_full_speed()
    rig.arm = Reason.BAD_MEASUREMENT
    rig.step(10)
    for operator in (State.FAULT, State.IDLE, State.ACTIVE):
        rig.operator = operator
        assert rig.step(10)[0] == State.FAULT


def test_too_large_a_force_drives_the_tool_back_along_it_and_latches():
    rig = at_full_speed()
    rig.force, rig.arm = np.array([0.0, -600.0, 800.0]), Reason.OVER_FORCE
    measured = command_at(rig.desired[:6])
    assert rig.step() == (State.FAULT, Reason.OVER_FORCE, 1, 1)
    since = len(rig.statuses)
    rig.force, rig.arm = np.zeros(3), Reason.NONE
    assert rig.step(1500)[:2] == (State.FAULT, Reason.OVER_FORCE)
    place = SERVO_STATE.unpack(rig.servo).p
    np.testing.assert_allclose(place, measured[:3] + 5e-3 * np.array([0, -0.6, 0.8]), atol=3e-4)
    assert_smooth(rig, since)


def test_a_force_that_stays_drives_it_back_a_tenth_of_a_metre_and_no_farther():
    rig = at_full_speed()
    rig.force, rig.arm = np.array([0.0, -600.0, 800.0]), Reason.OVER_FORCE
    measured = command_at(rig.desired[:6])
    rig.step()
    since = len(rig.statuses)
    rig.step(8000)
    place = SERVO_STATE.unpack(rig.servo).p
    np.testing.assert_allclose(place, measured[:3] + 0.1 * np.array([0, -0.6, 0.8]), atol=3e-4)
    assert_smooth(rig, since)


def test_references_of_an_arm_that_is_lost_are_put_where_it_is_and_the_controller_starts_afresh():
    rig = at_full_speed()
    rig.measured = rig.desired.copy()
    rig.measured[1] += 0.2
    rig.measured[6:] = 0.0
    rig.arm = Reason.TRACKING
    assert rig.step() == (State.FAULT, Reason.TRACKING, 1, 1)
    rig.arm = Reason.NONE
    assert rig.drives[0] == 1.0
    rig.step()
    np.testing.assert_array_equal(rig.desired[:6], rig.measured[:6])
    assert rig.drives[0] == 0.0
    rig.step()
    assert rig.drives[0] == 1.0
    rig.step(500)
    np.testing.assert_allclose(rig.desired[:6], rig.measured[:6], atol=1e-6)
    rig.operator = State.FAULT
    rig.step()
    rig.operator = State.IDLE
    rig.step()
    rig.engage()
    assert rig.step()[0] == State.ACTIVE
    rig.step(300)
    assert abs(rig.joint_rates()[-300:]).max() < 1e-6


def test_the_clutch_passes_and_an_unseen_release_is_an_engagement_anew():
    rig = at_full_speed()
    rig.operator = State.CLUTCH
    assert rig.step(300)[:2] == (State.CLUTCH, Reason.CLUTCHED)
    rig.operator = State.ACTIVE
    assert rig.step(300)[:3] == (State.ACTIVE, Reason.NONE, 1)
    here = rig.desired[:6].copy()
    rig.engagements += 1  # its HOLD was in a packet that never came
    rig.command = moved(rig.command, (0.4, 0.0, 0.0))
    assert rig.step(300)[2] == 2
    assert abs(rig.desired[:6] - here).max() < 1e-6


def test_frames_that_are_none_are_told_from_those_that_are():
    good = COMMAND_FRAME.pack(tool_command=command_at(joints.HOME), state=1.0, engagements=1.0)
    for entry in range(10):
        for value in (np.nan, np.inf, -np.inf, 1e300):
            rig, bad = Rig(), good.copy()
            bad[entry] = value
            if entry == 9 and value == 1e300:
                continue  # a count may be what it likes
            assert rig.step(frame=bad)[:2] == (State.FAULT, Reason.BAD_COMMAND), (entry, value)
            assert np.isfinite(rig.let_through).all()
