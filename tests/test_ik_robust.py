"""The default for one pose: no failure on what can be reached, and the nearest branch."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from scara_drake import ik, kinematics
from scara_drake.ik.kernels.postures import settle_kernel
from scara_drake.ik.robust import robust_kernel
from scara_drake.joints import HOME, LOWER, UPPER


def failures(n, first_joint, disturbed, seed):
    """Count the poses, of n that can be met, that the kernel does not meet by its own check."""
    rng = np.random.default_rng(seed)
    postures = rng.uniform(LOWER, UPPER, (n, 6))
    targets = kinematics.forward_kinematics(postures)
    if disturbed:
        shift, turn = rng.normal(size=(2, n, 3))
        shift *= 4e-3 * rng.uniform(size=(n, 1)) / np.linalg.norm(shift, axis=1, keepdims=True)
        turn *= 0.014 * rng.uniform(size=(n, 1)) / np.linalg.norm(turn, axis=1, keepdims=True)
        targets[:, :3, 3] += shift
        targets[:, :3, :3] = Rotation.from_rotvec(turn).as_matrix() @ targets[:, :3, :3]
    answers = np.empty((n, 6))
    near = np.array(HOME)
    for k, X in enumerate(targets):
        near[0] = postures[k, 0]
        p, R = X[:3, 3].copy(), X[:3, :3].copy()
        robust_kernel(p, R, first_joint, near, k, answers[k])
    position, rotation = kinematics.pose_error(targets, kinematics.forward_kinematics(answers))
    good = (position <= 5e-3) & (rotation <= 0.0175)
    good &= ((answers >= LOWER) & (answers <= UPPER)).all(axis=1)
    if first_joint == 1:
        good &= answers[:, 0] == postures[:, 0]
    return int((~good).sum())


@pytest.mark.parametrize("first_joint", [1, 0], ids=["arm", "with the mast"])
@pytest.mark.parametrize("disturbed", [False, True], ids=["reachable", "disturbed"])
def test_no_failure_on_what_can_be_met(first_joint, disturbed):
    assert failures(2000, first_joint, disturbed, seed=31) == 0


@pytest.mark.slow
@pytest.mark.parametrize("first_joint", [1, 0], ids=["arm", "with the mast"])
def test_no_failure_in_a_hundred_thousand(first_joint):
    assert failures(100_000, first_joint, False, seed=32) == 0
    assert failures(100_000, first_joint, True, seed=33) <= 10  # 99.99 %


@pytest.mark.parametrize("joints", ["arm", "full"])
def test_the_branch_nearest_to_the_seed_is_taken(joints):
    rng = np.random.default_rng(8)
    for _ in range(200):
        q = rng.uniform(LOWER, UPPER)
        seed = np.clip(q + rng.normal(0, 0.02, 6), LOWER, UPPER)
        if joints == "arm":
            seed[0] = q[0]
        X = kinematics.forward_kinematics(q)
        result = ik.solve(X, joints=joints, q_seed=seed)
        assert result.success
        assert np.linalg.norm(result.q - seed) <= np.linalg.norm(q - seed) + 1e-9


def test_a_posture_on_its_limits_is_found_there():
    q = np.array([5.0, 0.3, 0.4, UPPER[3], LOWER[4], 0.2])
    result = ik.solve(kinematics.forward_kinematics(q), joints="arm", q_seed=q)
    np.testing.assert_allclose(result.q, q, atol=1e-8)
    assert (result.q <= UPPER).all()
    assert (result.q >= LOWER).all()


@settings(deadline=None)
@given(st.lists(st.floats(-20, 20), min_size=6, max_size=6))
def test_only_rounding_is_settled(values):
    q = np.array(values)
    settled = q.copy()
    settle_kernel(settled, 1e-9)
    assert (np.abs(settled - q) <= 1e-9).all()
    inside = (q >= LOWER) & (q <= UPPER)
    np.testing.assert_array_equal(settled[inside], q[inside])


@pytest.mark.parametrize(
    ("target", "reason"),
    [([9.0, 0.0, 5.0], "out of reach"), ([0.9, 0.3, 5.6], "orientation not attainable")],
)
def test_what_cannot_be_met_is_no_success_and_says_why(target, reason):
    X = np.eye(4)
    X[:3, :3] = kinematics.rotation_from_intrinsic_xyz([0.3, 0.2, 0.1])
    X[:3, 3] = target
    result = ik.solve(X, joints="arm", q_seed=[5.0, 0, 0, 0, 0, 0])
    assert not result.success
    assert result.reason == reason
    position, rotation = kinematics.pose_error(X, kinematics.forward_kinematics(result.q))
    np.testing.assert_allclose([result.position_error, result.rotation_error], [position, rotation])
    # It is the best of all that many searches find, in the weighted sense.
    best = np.hypot(position / 5e-3, rotation / 0.0175)
    for seed in range(20):
        q = np.random.default_rng(seed).uniform(LOWER, UPPER)
        q[0] = 5.0
        other = ik.solve(X, "inverse_jacobian", "arm", q_seed=q)
        assert np.hypot(other.position_error / 5e-3, other.rotation_error / 0.0175) >= 0.99 * best
