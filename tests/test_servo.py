import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scara_drake import joints, kinematics
from scara_drake.common.motion import limit_motion
from scara_drake.ik import servo
from scara_drake.ik.kernels.limiter import LIMITS
from scara_drake.ik.system import InverseKinematics
from scara_drake.kinematics import REACH_LIMIT, draw_into_reach
from scara_drake.vectors import SERVO_STATE, pose_vector

DT = 1e-3
BOUNDS = LIMITS.pack(lower=joints.LOWER, upper=joints.UPPER, rate=joints.MAX_SPEED)


def follow(commands, q0=joints.HOME, joints_="arm", task="position"):
    """Run the servo over commands (n, 8); return references (n, 12), statuses and limiters."""
    settings_ = InverseKinematics(joints=joints_, task=task).settings(DT)
    state, desired = servo.servo_state_at(q0), np.concatenate([q0, np.zeros(6)])
    references, statuses, limiters = [], [], []
    for command in commands:
        servo.servo_step(command, desired, state, settings_, BOUNDS)
        references.append(desired.copy())
        statuses.append(float(SERVO_STATE.unpack(state).status))
        limiters.append(state.copy())
    return np.array(references), np.array(statuses), np.array(limiters)


def command_at(q, offset=(0.0, 0.0, 0.0), mast=None):
    command = np.append(pose_vector(q), q[0] if mast is None else mast)
    command[:3] += offset
    return command


@settings(deadline=None, max_examples=60)
@given(
    st.lists(st.floats(-2.0, 2.0), min_size=3, max_size=3),
    st.floats(0.05, 3.0),
    st.floats(0.1, 20.0),
)
def test_limiter_keeps_its_bounds_and_arrives_without_overshoot(start, speed, acceleration):
    error, rate, previous = np.array(start), np.zeros(3), np.zeros(3)
    initial = float(np.linalg.norm(error))
    time_needed = initial / speed + 4 * np.sqrt(max(initial, 1e-9) / acceleration) + 1.0
    for _ in range(int(time_needed / DT) + 1):
        limit_motion(error, rate, speed, acceleration, 60.0, DT)
        assert np.linalg.norm(rate) <= speed * (1 + 1e-9)
        assert np.linalg.norm(rate - previous) <= acceleration * DT * (1 + 1e-9)
        previous = rate.copy()
        error -= DT * rate
        # On the straight line, and at most a hair past the target.
        assert np.dot(error, start) >= -2e-3 * initial**2 - 1e-6 * initial
    assert np.linalg.norm(error) < 1e-3 * max(initial, 1.0)


def test_unbounded_limiter_is_the_critically_damped_follower():
    # e'' + 2 w e' + w² e = 0 from rest: e = e0 (1 + w t) exp(-w t).
    w, dt = 20.0, 1e-5
    error, rate = np.array([0.3]), np.zeros(1)
    for _ in range(20000):
        limit_motion(error, rate, 1e9, 1e9, w, dt)
        error -= dt * rate
    t = 0.2
    np.testing.assert_allclose(error, 0.3 * (1 + w * t) * np.exp(-w * t), rtol=5e-3)


def test_velocity_references_are_the_derivative_of_the_position_references():
    t = np.arange(3000) * DT
    commands = np.tile(command_at(joints.HOME), (3000, 1))
    commands[:, 0] += 0.2 * np.sin(2.0 * t)
    commands[:, 2] += 0.15 * np.sin(3.0 * t)
    references, statuses, _ = follow(commands)
    assert (statuses == servo.TRACKING).all()
    slope = np.diff(references[:, :6], axis=0) / DT
    np.testing.assert_allclose(references[1:, 6:], slope, atol=1e-9)


def test_the_tool_point_is_followed_exactly():
    t = np.arange(4000) * DT
    commands = np.tile(command_at(joints.HOME), (4000, 1))
    commands[:, 0] += 0.3 * np.sin(1.5 * t)
    commands[:, 1] += 0.2 * np.sin(2.1 * t)
    commands[:, 7] += 0.2 * np.sin(t)
    commands[:, 2] += 0.2 * np.sin(t)
    references, statuses, limiters = follow(commands)
    X_WE = kinematics.forward_kinematics(references[:, :6])
    assert (statuses == servo.TRACKING).all()
    assert np.abs(X_WE[:, :3, 3] - limiters[:, :3]).max() < 2e-5  # [m]
    np.testing.assert_allclose(
        references[:, 0], limiters[:, SERVO_STATE.slices["mast"].start], atol=1e-9
    )


def test_full_pose_is_followed_with_the_mast_taking_part():
    q_target = joints.HOME + np.array([0.3, 0.2, 0.25, 0.2, -0.2, 0.4])
    references, statuses, _ = follow(
        np.tile(command_at(q_target), (4000, 1)), joints_="full", task="pose"
    )
    X_WE = kinematics.forward_kinematics(references[-1, :6])
    distance, angle = kinematics.pose_error(kinematics.forward_kinematics(q_target), X_WE)
    assert (statuses == servo.TRACKING).all()
    assert distance < 1e-5
    assert angle < 1e-5


@pytest.mark.parametrize("direction", [(1.0, 0, 0), (0, -1.0, 0), (0, 0, 1.0), (-0.6, 0.6, -0.6)])
def test_a_target_out_of_reach_is_drawn_back_smoothly(direction):
    commands = np.tile(command_at(joints.HOME, 3.0 * np.array(direction)), (8000, 1))
    references, statuses, _ = follow(commands)
    assert set(statuses) <= {servo.REACH_LIMITED, servo.HOLDING}
    # At most the acceleration that the limiter allows, mapped through the arm; no jump at the edge.
    assert (np.abs(references[:, 6:]) <= joints.MAX_SPEED + 1e-12).all()
    arm = kinematics.forward_kinematics(references[-1, :6])[:3, 3] - [0, 0, references[-1, 0]]
    beyond = np.hypot(np.hypot(arm[0], arm[1]) - 0.75, arm[2])
    assert beyond <= REACH_LIMIT + 5e-3


@settings(deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.1, 4.0))
def test_points_are_drawn_to_the_edge_of_the_reach_and_no_further(seed, distance):
    direction = np.random.default_rng(seed).normal(size=3)
    point = distance * direction / np.linalg.norm(direction)
    drawn = point.copy()
    out = draw_into_reach(drawn)

    def from_the_circle(p):
        return np.hypot(np.hypot(p[0], p[1]) - 0.75, p[2])

    assert out == (from_the_circle(point) > REACH_LIMIT)
    if out:
        assert from_the_circle(drawn) == pytest.approx(REACH_LIMIT)
        assert np.arctan2(drawn[1], drawn[0]) == pytest.approx(np.arctan2(point[1], point[0]))
    else:
        np.testing.assert_array_equal(drawn, point)


def test_every_posture_is_within_the_reach():
    q = np.random.default_rng(0).uniform(joints.LOWER, joints.UPPER, (20000, 6))
    p = kinematics.forward_kinematics(q)[:, :3, 3] - np.array([[0, 0, 1]]) * q[:, :1]
    beyond = np.hypot(np.hypot(p[:, 0], p[:, 1]) - 0.75, p[:, 2])
    assert beyond.max() <= 1.55 + 1e-12
    assert beyond.max() > REACH_LIMIT  # the edge is real


def test_a_held_target_can_be_left_again():
    away = np.tile(command_at(joints.HOME, (0.0, 4.0, 0.0)), (6000, 1))
    back = np.tile(command_at(joints.HOME), (6000, 1))
    references, statuses, _ = follow(np.concatenate([away, back]))
    tool = kinematics.forward_kinematics(references[-1, :6])[:3, 3]
    assert statuses[-1] == servo.TRACKING
    np.testing.assert_allclose(tool, back[0, :3], atol=1e-4)


@settings(deadline=None, max_examples=25)
@given(st.integers(0, 2**32 - 1))
def test_whatever_is_commanded_the_references_keep_every_limit(seed):
    rng = np.random.default_rng(seed)
    commands = np.repeat(
        command_at(joints.HOME) + rng.normal(0, 1.0, (8, 8)) * [1, 1, 1, 1, 1, 1, 1, 2], 400, axis=0
    )
    references, _, _ = follow(commands)
    q, v = references[:, :6], references[:, 6:]
    assert np.isfinite(references).all()
    assert (q >= joints.LOWER).all()
    assert (q <= joints.UPPER).all()
    assert (np.abs(v) <= joints.MAX_SPEED * (1 + 1e-12)).all()
    steps = np.abs(np.diff(np.vstack([joints.HOME, q]), axis=0))
    assert (steps <= joints.MAX_SPEED * DT * (1 + 1e-9)).all()


def test_a_command_that_leads_back_moves_the_arm_again():
    """Out of what five joints can hold, and back: the tool is where it was, and follows again."""
    q0 = np.array([3.0, -0.4955, 0.0, -0.504, 0.9995, 0.0])
    away = np.linspace(0.0, 1.7, 3400)
    outward = np.array([command_at(q0, (x, 0.0, 0.0)) for x in away])
    waiting, home = np.repeat(outward[-1:], 500, axis=0), np.repeat(outward[:1], 4000, axis=0)
    references, statuses, _ = follow([*outward, *waiting, *home], q0, task="pose")
    held = statuses == servo.HOLDING
    assert held[len(outward) :][:500].all()
    assert not held[-3000:].any()
    np.testing.assert_allclose(references[-1, :6], q0, atol=1e-6)
    steps = np.abs(np.diff(references[:, :6], axis=0))
    assert np.all(steps <= DT * joints.MAX_SPEED * (1 + 1e-9))


@pytest.mark.parametrize(("joints_", "least"), [("arm", 18), ("full", 20)])
def test_nearly_every_posture_comes_back_from_where_it_was_held(joints_, least):
    """20 random postures, sent 2 m away and called back; some start out of reach."""
    rng = np.random.default_rng(1)
    back, held = 0, 0
    low, high = np.array(joints.LOWER), np.array(joints.UPPER)
    for q0 in rng.uniform(0.9 * low + 0.1 * high, 0.1 * low + 0.9 * high, (20, 6)):
        direction = rng.normal(size=3)
        away = command_at(q0, 2.0 * direction / np.linalg.norm(direction))
        commands = [away] * 3000 + [command_at(q0)] * 9000
        references, statuses, _ = follow(commands, q0, joints_, "pose")
        held += bool((statuses[:3000] == servo.HOLDING).any())
        distance, _ = kinematics.pose_error(
            kinematics.forward_kinematics(q0), kinematics.forward_kinematics(references[-1, :6])
        )
        back += bool(distance < 2e-3)
    assert held >= 10
    assert back >= least


@settings(deadline=None, max_examples=20)
@given(st.lists(st.floats(-6.0, 6.0), min_size=6, max_size=6))
def test_an_answer_is_approached_on_a_line_within_the_speeds(far):
    answer = np.clip(far, joints.LOWER, joints.UPPER)
    q, rates, before = joints.HOME.copy(), np.zeros(6), joints.HOME.copy()
    while servo.approach(q, answer, BOUNDS, DT, rates):
        assert np.all(np.abs(rates) <= joints.MAX_SPEED * (1 + 1e-9))
        np.testing.assert_allclose(q - before, DT * rates, atol=1e-12)
        before = q.copy()
    np.testing.assert_array_equal(q, answer)
