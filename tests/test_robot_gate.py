"""How far the robot's supervisor lets a command lead the arm, and that back is always allowed."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from robot_rig import Rig, command_at, moved
from strategies import examples

from scara_drake import joints, kinematics
from scara_drake.ik.result import ROTATION_LENGTH
from scara_drake.safety import Reason, State
from scara_drake.supervision.config import RobotSupervision
from scara_drake.supervision.gate import smallest_singular_value
from scara_drake.vectors import SERVO_STATE

REACH = 0.98 * (kinematics.A4 + kinematics.D6)


def engaged(**more):
    rig = Rig(**more)
    rig.engage()
    rig.step(2)
    return rig


def place(rig):
    return np.array(SERVO_STATE.unpack(rig.servo).p)


def beyond(p, mast):
    """How far a point is from the circle of the end of the beam [m]."""
    return np.hypot(np.hypot(p[0], p[1]) - kinematics.D3, p[2] - mast)


def postures():
    low, high = joints.LOWER + 0.05, joints.UPPER - 0.05
    return st.tuples(*(st.floats(a, b) for a, b in zip(low, high, strict=True))).map(np.array)


@examples(40)
@given(postures(), st.sampled_from(["position", "pose"]), st.sampled_from(["arm", "full"]))
def test_the_smallest_singular_value_is_that_of_the_controlled_rows(q, task, joints_):
    rows = kinematics.jacobian(q)
    rows[:3] *= ROTATION_LENGTH
    first = 1 if joints_ == "arm" else 0
    controlled = rows[3:, first:] if task == "position" else rows[:, first:]
    expected = np.linalg.svd(controlled, compute_uv=False).min()
    motion = Rig(task=task, joints=joints_).settings
    assert smallest_singular_value(q, motion) == pytest.approx(expected, abs=2e-8)


@pytest.mark.parametrize("direction", [(1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0)])
def test_a_command_out_of_reach_ends_at_its_edge_and_says_so(direction):
    rig = engaged()
    rig.command = moved(rig.command, 3.0 * np.array(direction))
    status = rig.step(6000)
    assert status[:2] == (State.ACTIVE, Reason.WORKSPACE)
    assert beyond(place(rig), rig.desired[0]) <= REACH + 1e-6
    back = command_at(joints.HOME)
    rig.command = back
    assert rig.step(9000)[:2] == (State.ACTIVE, Reason.NONE)
    np.testing.assert_allclose(place(rig), back[:3], atol=1e-3)


def test_what_is_tangential_at_the_edge_of_the_box_stays():
    low, high = [0.5, -1.0, -20.0], [1.2, 20.0, 20.0]
    rig = engaged(config=RobotSupervision(box_lower=low, box_upper=high))
    start = place(rig)
    rig.command = moved(rig.command, (0.2, -2.0, 0.0))
    assert rig.step(4000)[:2] == (State.ACTIVE, Reason.WORKSPACE)
    np.testing.assert_allclose(place(rig), [min(start[0] + 0.2, 1.2), -1.0, start[2]], atol=2e-3)


def test_an_arm_that_starts_outside_the_box_may_stay_and_move_in_only():
    p = command_at(joints.HOME)[:3]
    box = RobotSupervision(box_lower=[-20.0, p[1] + 0.1, -20.0])
    rig = engaged(config=box)
    rig.step(300)
    assert abs(rig.joint_rates()).max() < 1e-9
    rig.command = moved(rig.command, (0.0, -0.2, 0.0))
    rig.step(500)
    assert place(rig)[1] > p[1] - 1e-4
    rig.command = moved(rig.command, (0.0, 0.5, 0.0))
    rig.step(3000)
    assert place(rig)[1] > p[1] + 0.1


# A posture with one joint near its limit, and the way of the tool that takes it there.
def near_limit(joint, gap, upper=True):
    q = joints.HOME.copy()
    q[joint] = joints.UPPER[joint] - gap if upper else joints.LOWER[joint] + gap
    return q


@pytest.mark.parametrize("upper", [True, False])
@pytest.mark.parametrize("joint", [1, 3, 4])
def test_a_joint_stops_at_its_margin_and_comes_back(joint, upper):
    q = near_limit(joint, 0.3, upper)
    rig = engaged(q=q)
    column = kinematics.jacobian(q)[3:, joint] * (1.0 if upper else -1.0)
    rig.command = moved(rig.command, 0.4 * column / np.linalg.norm(column))
    seen = {rig.step()[1] for _ in range(5000)}
    inside = rig.desired[:6]
    gap = joints.UPPER - inside if upper else inside - joints.LOWER
    assert gap[joint] > 0.0
    assert seen & {Reason.JOINT_LIMIT, Reason.SINGULARITY, Reason.WORKSPACE, Reason.NONE}
    rig.command = command_at(q)
    assert rig.step(6000)[0] == State.ACTIVE
    np.testing.assert_allclose(place(rig), command_at(q)[:3], atol=2e-3)


def test_the_mast_stops_at_its_margin_and_comes_back():
    q = near_limit(0, 0.1)
    rig = engaged(q=q)
    rig.command = moved(rig.command, mast=1.0)
    rig.step(3000)
    assert rig.desired[0] <= joints.UPPER[0] - 0.02 + 1e-3
    assert rig.status[1] in (Reason.WORKSPACE, Reason.JOINT_LIMIT)
    rig.command = moved(command_at(q), mast=-0.1)
    rig.step(4000)
    assert rig.desired[0] == pytest.approx(q[0] - 0.1, abs=2e-3)


def test_a_joint_that_starts_beyond_its_margin_moves_inwards():
    q = near_limit(4, 0.005)
    rig = engaged(q=q)
    outwards = np.array([-0.02, -0.1, 0.0])
    rig.command = moved(command_at(q), outwards)
    assert rig.step(1000)[1] == Reason.JOINT_LIMIT
    np.testing.assert_allclose(rig.desired[:6], q, atol=1e-9)
    rig.command = moved(command_at(q), -outwards)
    rig.step(3000)
    np.testing.assert_allclose(place(rig), command_at(q)[:3] - outwards, atol=1e-3)
    assert rig.desired[4] < q[4]


def test_a_singular_posture_is_neared_slowly_then_no_more_and_left_at_once():
    # The forearm folded back: the tool over the elbow's axis.
    q = joints.HOME.copy()
    q[3], q[4] = 0.0, -2.2
    rig = engaged(q=q)
    motion = rig.settings
    low, slowest = RobotSupervision().singularity_stop, 1.0
    rng = np.random.default_rng(3)
    for _ in range(12):
        rig.command = moved(command_at(q), rng.uniform(-1.0, 1.0, 3))
        for _ in range(700):
            rig.step()
            slowest = min(slowest, smallest_singular_value(rig.desired[:6].copy(), motion))
    assert slowest > 0.3 * low
    rig.command = command_at(q)
    rig.step(8000)
    np.testing.assert_allclose(place(rig), command_at(q)[:3], atol=5e-3)


@examples(15)
@given(postures(), st.lists(st.floats(-1.5, 1.5), min_size=3, max_size=3))
def test_whatever_is_asked_rates_and_ranges_are_kept_and_no_step_is_made(q, way):
    rig = engaged(q=q)
    rig.command = moved(rig.command, way)
    rig.step(600)
    references = np.array(rig.references)
    assert (references[:, :6] >= joints.LOWER - 1e-12).all()
    assert (references[:, :6] <= joints.UPPER + 1e-12).all()
    assert (abs(rig.joint_rates()) <= joints.MAX_SPEED + 1e-9).all()
    assert np.isfinite(references).all()
