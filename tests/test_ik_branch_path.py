"""Paths over all branches: the largest joint step is no larger than that of any other way."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from scara_drake import ik, kinematics
from scara_drake.ik.kernels.branch_path import has_jump_kernel, smoothest_path_kernel
from scara_drake.joints import HOME, LOWER, UPPER


def generating_path(rng, scale, arm):
    """A cubic spline through four postures: 50 points."""
    centre = 0.8 * rng.uniform(LOWER, UPPER) + 0.1 * (LOWER + UPPER)
    knots = centre + rng.uniform(-0.4, 0.4, (4, 6)) * scale
    if arm:
        knots[:, 0] = centre[0]
    return np.clip(CubicSpline(range(4), knots)(np.linspace(0, 3, 50)), LOWER, UPPER)


def largest_step(q):
    return np.abs(np.diff(q, axis=0)).max()


@pytest.mark.parametrize("arm", [True, False], ids=["arm", "with the mast"])
def test_the_smoothest_path_is_at_least_as_smooth_as_the_generating_one(arm):
    rng = np.random.default_rng(14)
    for scale in (1, 4):
        for _ in range(4):
            path = generating_path(rng, scale, arm)
            X = kinematics.forward_kinematics(path)
            p, R = X[:, :3, 3].copy(), X[:, :3, :3].copy()
            q = np.empty((50, 6))
            largest = smoothest_path_kernel(p, R, int(arm), path[0], True, q)
            assert largest == pytest.approx(largest_step(q), abs=1e-12)
            assert np.abs(kinematics.forward_kinematics(q)[1:] - X[1:]).max() < 1e-8
            assert largest_step(q) <= largest_step(path) + 1e-6
            assert ((q >= LOWER) & (q <= UPPER)).all()
            free = np.empty((50, 6))
            assert smoothest_path_kernel(p, R, int(arm), path[0], False, free) <= largest + 1e-9


@pytest.mark.parametrize("scale", [1, 2, 4])
@pytest.mark.parametrize("joints", ["arm", "full"])
def test_every_point_of_every_path_within_tolerance_and_no_jump(joints, scale):
    rng = np.random.default_rng(50 + scale)
    for _ in range(25):
        path = generating_path(rng, scale, joints == "arm")
        X = kinematics.forward_kinematics(path)
        answer = ik.solve_path(X, joints=joints, q_seed=path[0])
        position, rotation = kinematics.pose_error(X, kinematics.forward_kinematics(answer.q))
        assert answer.success.all()
        assert (position <= 5e-3).all()
        assert (rotation <= 0.0175).all()
        assert largest_step(answer.q) <= 1.5 * largest_step(path)


@pytest.mark.parametrize("joints", ["arm", "full"])
def test_without_a_seed_the_path_does_not_begin_where_it_cannot_go_on(joints):
    rng = np.random.default_rng(77)
    for _ in range(25):
        path = generating_path(rng, 1, joints == "arm")
        X = kinematics.forward_kinematics(path)
        seed = HOME.copy()
        seed[0] = path[0, 0]
        answer = ik.solve_path(X, joints=joints, q_seed=seed if joints == "arm" else None)
        assert answer.success.all()
        assert largest_step(answer.q) <= 0.7


def test_a_point_without_a_solution_leaves_the_path_as_it_was():
    X = kinematics.forward_kinematics(np.tile(HOME, (3, 1)))
    X[1, :3, 3] += 9.0
    q = np.full((3, 6), 7.0)
    p, R = X[:, :3, 3].copy(), X[:, :3, :3].copy()
    assert smoothest_path_kernel(p, R, 1, np.array(HOME), True, q) == np.inf
    np.testing.assert_array_equal(q, 7.0)


def test_a_jump_is_a_step_that_stands_out():
    smooth = np.outer(np.linspace(0, 1, 20), np.ones(6))
    assert not has_jump_kernel(smooth, 1.1)
    jumped = smooth.copy()
    jumped[10:, 3] += 0.5
    assert has_jump_kernel(jumped, 1.1)
