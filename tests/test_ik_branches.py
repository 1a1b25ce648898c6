"""The nearest branch against an exhaustive search of its own, in plain numpy."""

import numpy as np
import pytest

from scara_drake import ik, kinematics
from scara_drake.ik.kernels.postures import Bounds, Goal, mirror_kernel
from scara_drake.ik.kernels.refine import (
    Descent,
    refine_kernel,
    refine_position_first_kernel,
)
from scara_drake.joints import HOME, LOWER, UPPER


def exhaustive(X, near, joints, task, restarts, seed):
    """Best rotation error and every local solution from many random restarts."""
    rng = np.random.default_rng(seed)
    first, none = (1 if joints == "arm" else 0), np.empty((0, 2))
    p, R = X[:3, 3].copy(), X[:3, :3].copy()
    low, high = LOWER.copy(), UPPER.copy()
    low[0], high[0] = np.clip([p[2] - 2.3, p[2] + 2.3], LOWER[0], UPPER[0])
    goal = Goal(p, R, Bounds(first, np.array(LOWER), np.array(UPPER)))
    descent = Descent(0.2857, 1.0, 60, True)
    ends = []
    for _ in range(restarts):
        q = rng.uniform(low, high)
        if first:
            q[0] = near[0]
        if task == "position":
            refine_position_first_kernel(q, goal, descent, none)
        else:
            refine_kernel(q, goal, descent, none)
        ends.append(q)
    found = np.array(ends)
    # Every whole turn of theta2, theta3, theta6, not only the nearest.
    turns = np.array(np.meshgrid(*[[-2, -1, 0, 1, 2]] * 3)).reshape(3, -1).T * 2 * np.pi
    wrapped = np.repeat(found, len(turns), axis=0)
    wrapped[:, [1, 2, 5]] += np.tile(turns, (len(found), 1))
    wrapped = wrapped[np.all((wrapped >= LOWER) & (wrapped <= UPPER), axis=1)]
    position, rotation = kinematics.pose_error(X, kinematics.forward_kinematics(wrapped))
    good = position < 1e-6
    best = rotation[good].min()
    good &= rotation <= best + 1e-3
    return best, np.linalg.norm((wrapped[good] - near)[:, first:], axis=1).min()


@pytest.mark.parametrize(
    ("joints", "task"), [("full", "pose"), ("arm", "pose"), ("arm", "position")]
)
@pytest.mark.parametrize("method", ["robust", "dpso"])
def test_nearest_branch_is_that_of_an_exhaustive_search(method, joints, task):
    rng = np.random.default_rng(5)
    missed = 0
    for k in range(30):
        q = rng.uniform(LOWER, UPPER)
        X = kinematics.forward_kinematics(q)
        if task == "position":
            X[:3, :3] = kinematics.rotation_from_intrinsic_xyz(rng.uniform(-np.pi, np.pi, 3))
        near = HOME.copy() if k % 2 else rng.uniform(LOWER, UPPER)
        if joints == "arm":
            near[0] = q[0]
        result = ik.solve(X, method, joints, task, q_seed=near, seed=k, nearest_to=near)
        best, distance = exhaustive(X, near, joints, task, 400, seed=k)
        first = 1 if joints == "arm" else 0
        assert result.success
        far = np.linalg.norm((result.q - near)[first:]) > distance + 1e-2
        turned = result.rotation_error > best + 1e-3 + 1e-6
        missed += far or turned or result.position_error > 1e-6
    # With the mast up to 12 branches exist, some with a small basin: the closed form lists them
    # all, a swarm may miss one, or the best orientation where there are several as good.
    assert missed <= (0 if method == "robust" else 4 if joints == "full" else 2)


def test_the_answer_depends_on_the_seed_and_on_nothing_else():
    q = np.array([5.0, 0.4, 0.3, -0.5, 0.9, 0.2])
    X = kinematics.forward_kinematics(q)
    a, b = (ik.solve(X, "dpso", q_seed=q, seed=3, nearest_to=HOME) for _ in range(2))
    assert a.q.tobytes() == b.q.tobytes()
    assert a.evaluations == b.evaluations


def test_a_posture_is_the_nearest_solution_of_its_own_pose():
    rng = np.random.default_rng(6)
    for k in range(30):
        q = 0.9 * rng.uniform(LOWER, UPPER) + 0.05 * (LOWER + UPPER)
        X = kinematics.forward_kinematics(q)
        result = ik.solve(X, "dpso", "arm", q_seed=q, seed=k, nearest_to=q)
        np.testing.assert_allclose(result.q, q, atol=1e-6)


def test_the_mirror_has_the_same_tool_pose():
    rng = np.random.default_rng(7)
    for q in rng.uniform(LOWER, UPPER, (50, 6)):
        other = np.empty(6)
        mirror_kernel(q, other)
        np.testing.assert_allclose(
            kinematics.forward_kinematics(other), kinematics.forward_kinematics(q), atol=1e-12
        )
        assert np.abs(other - q).max() > 1e-3
