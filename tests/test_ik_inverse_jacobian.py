"""The kernels of the 1 kHz loop against forward kinematics and finite differences."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scara_drake import ik, joints, kinematics
from scara_drake.ik.kernels.postures import Bounds, Goal
from scara_drake.ik.kernels.rates import joint_rates_kernel, track_pose_kernel

LOWER, UPPER = np.array(joints.LOWER), np.array(joints.UPPER)
BIG_STEP = np.full(6, 1.0)


def rotation_vector(R):
    w = np.empty(3)
    kinematics.rotation_vector_kernel(R, np.eye(3), w)
    return w


def regular_postures(n, seed, first_joint=0):
    """Postures away from limits and singularities of both stages."""
    rng = np.random.default_rng(seed)
    found: list[np.ndarray] = []
    while len(found) < n:
        q = 0.9 * rng.uniform(LOWER, UPPER) + 0.05 * (LOWER + UPPER)
        J = kinematics.jacobian(q)[:, first_joint:]
        weighted = np.diag([0.2857] * 3 + [1.0] * 3) @ J
        null = np.eye(J.shape[1]) - np.linalg.pinv(J[3:]) @ J[3:]
        turning = np.linalg.svd(J[:3] @ null)[1][min(3, J.shape[1] - 3) - 1]
        if (
            np.linalg.svd(weighted)[1][-1] > 0.05
            and np.linalg.svd(J[3:])[1][-1] > 0.1
            and turning > 0.15
        ):
            found.append(q)
    return found


@pytest.mark.parametrize("first_joint", [0, 1])
@pytest.mark.parametrize("position_first", [True, False])
def test_rates_of_a_joint_motion_reproduce_its_tool_motion(first_joint, position_first):
    # The tool motion comes from differences of poses, not from a Jacobian.
    rng = np.random.default_rng(1)
    h = 1e-6
    for q in regular_postures(40, 1, first_joint):
        rate = rng.uniform(-1, 1, 6)
        ahead, behind = (kinematics.forward_kinematics(q + s * h * rate) for s in (1, -1))
        v = (ahead[:3, 3] - behind[:3, 3]) / (2 * h)
        w = rotation_vector(ahead[:3, :3] @ behind[:3, :3].T) / (2 * h)
        rates = np.empty(6)
        bounds = Bounds(first_joint, LOWER, UPPER)
        joint_rates_kernel(q, v, w, bounds, position_first, rate[0], rates)
        np.testing.assert_allclose(rates, rate, atol=1e-5)


def test_position_first_rates_hold_the_velocity_exactly():
    rng = np.random.default_rng(2)
    for q in regular_postures(40, 2, 1):
        v, w, mast = rng.normal(size=3), rng.normal(size=3), rng.normal()
        rates = np.empty(6)
        joint_rates_kernel(q, v, w, Bounds(1, LOWER, UPPER), True, mast, rates)
        np.testing.assert_allclose(kinematics.jacobian(q)[3:] @ rates, v, atol=1e-5)
        assert rates[0] == mast


def test_the_masts_own_motion_is_taken_out_of_the_task():
    q, rates = joints.HOME + np.array([1.0, 0, 0, 0, 0, 0]), np.empty(6)
    bounds = Bounds(1, LOWER, UPPER)
    joint_rates_kernel(q, np.array([0, 0, 0.3]), np.zeros(3), bounds, False, 0.3, rates)
    np.testing.assert_allclose(rates, [0.3, 0, 0, 0, 0, 0], atol=1e-12)


@settings(deadline=None, max_examples=200)
@given(
    unit=st.tuples(*[st.floats(0.0, 1.0)] * 6),
    v=st.tuples(*[st.floats(-1, 1)] * 3),
    w=st.tuples(*[st.floats(-1, 1)] * 3),
    first_joint=st.sampled_from([0, 1]),
    position_first=st.booleans(),
    mast_rate=st.floats(-0.5, 0.5),
)
def test_rates_stay_bounded_and_never_leave_a_limit(
    unit, v, w, first_joint, position_first, mast_rate
):
    q = np.minimum(np.maximum(LOWER + np.array(unit) * (UPPER - LOWER), LOWER), UPPER)
    rates = np.empty(6)
    bounds = Bounds(first_joint, LOWER, UPPER)
    joint_rates_kernel(q, np.array(v), np.array(w), bounds, position_first, mast_rate, rates)
    assert np.all(np.isfinite(rates))
    assert np.abs(rates).max() < 2e3
    assert not np.any((q <= LOWER) & (rates < 0.0))
    assert not np.any((q >= UPPER) & (rates > 0.0))


def test_rates_of_the_other_joints_take_over_at_a_limit():
    q = regular_postures(1, 3)[0]
    v, w = np.array([0.2, -0.1, 0.1]), np.zeros(3)
    rates = np.empty(6)
    joint_rates_kernel(q, v, w, Bounds(0, LOWER, UPPER), True, 0.0, rates)
    j = int(np.argmax(np.abs(rates[1:]))) + 1
    lower, upper = LOWER.copy(), UPPER.copy()
    (upper if rates[j] > 0 else lower)[j] = q[j]
    joint_rates_kernel(q, v, w, Bounds(0, lower, upper), True, 0.0, rates)
    assert rates[j] == 0.0
    np.testing.assert_allclose(kinematics.jacobian(q)[3:] @ rates, v, atol=1e-3)


def track(q, X, first_joint, position_first, max_step=BIG_STEP, iterations=2):
    goal = Goal(X[:3, 3].copy(), X[:3, :3].copy(), Bounds(first_joint, LOWER, UPPER))
    return track_pose_kernel(q, goal, position_first, max_step, iterations)


@pytest.mark.parametrize("first_joint", [0, 1])
@pytest.mark.parametrize("position_first", [True, False])
def test_tracking_reaches_a_near_pose_and_reports_its_errors(first_joint, position_first):
    rng = np.random.default_rng(4)
    for q in regular_postures(40, 4, first_joint):
        goal = q + 2e-3 * rng.uniform(-1, 1, 6)
        if first_joint == 1:
            goal[0] = q[0]
        X = kinematics.forward_kinematics(goal)
        moved = q.copy()
        reported = track(moved, X, first_joint, position_first, iterations=4)
        errors = kinematics.pose_error(X, kinematics.forward_kinematics(moved))
        np.testing.assert_allclose(reported, errors, atol=1e-9)
        assert errors[0] < 1e-6
        assert errors[1] < 1e-5


def test_tracking_a_moving_point_keeps_the_position_and_turns_as_near_as_it_can():
    # A circle of 0.2 m at 0.3 m/s for 5 s, the arm alone, the orientation held: the position
    # stays within a micrometre, the orientation ends where a full minimisation would put it.
    q = joints.HOME.copy()
    q[0] = 5.0
    X = kinematics.forward_kinematics(q)
    centre = X[:3, 3].copy()
    worst = largest = 0.0
    for k in range(5000):
        angle = 1.5 * k * 1e-3
        X[:3, 3] = centre + 0.2 * np.array(
            [np.sin(angle), np.cos(angle) - 1.0, 0.5 * np.sin(angle)]
        )
        before = q.copy()
        position, _ = track(q, X, 1, True, max_step=np.full(6, 0.01))
        worst, largest = max(worst, position), max(largest, np.abs(q - before).max())
    assert worst < 1e-6
    assert largest < 5e-3
    assert q[0] == 5.0
    here = ik.solve(X, "inverse_jacobian", "arm", "position", q_seed=q)
    assert kinematics.pose_error(X, kinematics.forward_kinematics(q))[1] < (
        here.rotation_error + 5e-3
    )


@settings(deadline=None, max_examples=200)
@given(
    unit=st.tuples(*[st.floats(0.0, 1.0)] * 6),
    p=st.tuples(st.floats(-4, 4), st.floats(-4, 4), st.floats(0, 12)),
    rpy=st.tuples(*[st.floats(-np.pi, np.pi)] * 3),
    first_joint=st.sampled_from([0, 1]),
    position_first=st.booleans(),
    step=st.floats(1e-4, 0.5),
)
def test_tracking_any_target_keeps_limits_and_steps(
    unit, p, rpy, first_joint, position_first, step
):
    q = np.minimum(np.maximum(LOWER + np.array(unit) * (UPPER - LOWER), LOWER), UPPER)
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = kinematics.rotation_from_intrinsic_xyz(rpy), p
    max_step = step * np.array([0.3, 1.0, 1.0, 1.5, 2.0, 2.0])
    for _ in range(5):
        before = q.copy()
        track(q, X, first_joint, position_first, max_step=max_step)
        assert np.all(np.isfinite(q))
        assert np.all((q >= LOWER) & (q <= UPPER))
        assert np.all(np.abs(q - before) <= max_step * (1 + 1e-9))
        if first_joint == 1:
            assert q[0] == before[0]


def test_tracking_out_of_reach_ends_stretched_and_quiet():
    q = joints.HOME.copy()
    q[0] = 6.0
    X = np.eye(4)
    X[:3, 3] = [3.0, 1.0, 6.0]
    for _ in range(4000):
        before = q.copy()
        position, _ = track(q, X, 1, True, max_step=np.full(6, 2e-3))
    assert position == pytest.approx(np.hypot(3.0, 1.0) - kinematics.REACH, abs=0.02)
    assert np.abs(q - before).max() < 2e-3


def test_a_far_target_is_reached_without_a_jump():
    X = kinematics.forward_kinematics([4.0, 0.6, 0.5, -0.9, 1.3, 0.8])
    q = joints.HOME.copy()
    for _ in range(3000):
        errors = track(q, X, 0, False, max_step=np.full(6, 2e-3))
    assert errors[0] < 1e-6
    assert errors[1] < 1e-6


def test_path_follows_each_point_from_the_one_before():
    s = np.linspace(0, 1, 50)[:, None]
    q = joints.HOME + s * np.array([0.5, 0.6, -0.5, 0.4, -0.5, 0.7])
    X = kinematics.forward_kinematics(q)
    path = ik.solve_path(X, method="inverse_jacobian", q_seed=q[0])
    assert path.success.all()
    np.testing.assert_allclose(path.q, q, atol=1e-6)
    assert path.reason == ("converged",) * 50


def test_path_with_the_papers_position_rows_drifts_in_the_orientation():
    # Equation (26) alone: joint 6 does not move the tool point, so it never moves.
    s = np.linspace(0, 1, 50)[:, None]
    q = np.array([5.0, *joints.HOME[1:]]) + s * np.array([0, 0.6, -0.5, 0.4, -0.5, 0.7])
    X = kinematics.forward_kinematics(q)
    path = ik.solve_path(X, "inverse_jacobian", "arm", q_seed=q[0], rows="position")
    assert path.position_error.max() < 1e-6
    np.testing.assert_allclose(path.q[:, 5], q[0, 5], atol=1e-9)
    assert path.rotation_error[-1] > 0.1
    assert not path.success[-1]
