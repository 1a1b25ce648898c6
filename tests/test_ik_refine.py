"""Local solutions: what they keep, and what they minimise."""

import numpy as np
import pytest

from scara_drake import joints, kinematics
from scara_drake.ik.kernels.errors import error_kernel
from scara_drake.ik.kernels.postures import (
    Bounds,
    Goal,
    keep_limits_kernel,
    nearest_turns_kernel,
)
from scara_drake.ik.kernels.refine import Descent, refine_kernel

LOWER, UPPER = np.array(joints.LOWER), np.array(joints.UPPER)
NONE = np.empty((0, 2))


def targets(n, seed):
    q = np.random.default_rng(seed).uniform(LOWER, UPPER, (n, 6))
    return zip(q, kinematics.forward_kinematics(q), strict=True)


def test_errors_are_those_of_forward_kinematics():
    for q, X in targets(20, 0):
        other = np.clip(q + 0.3, LOWER, UPPER)
        expected = kinematics.pose_error(X, kinematics.forward_kinematics(other))
        found = error_kernel(other, X[:3, 3].copy(), X[:3, :3].copy())
        np.testing.assert_allclose(found, expected, atol=1e-7)


def test_refining_never_makes_it_worse_and_stays_inside():
    rng = np.random.default_rng(1)
    for _, X in targets(100, 1):
        start = rng.uniform(LOWER, UPPER)
        p, R = X[:3, 3].copy(), X[:3, :3].copy()
        before = np.hypot(*(np.array(error_kernel(start, p, R)) * [1.0, 0.3]))
        for wrap in (True, False):
            q = start.copy()
            e_p, e_w, evaluations, iterations = refine_kernel(
                q, Goal(p, R, Bounds(0, LOWER, UPPER)), Descent(0.3, 0.5, 30, wrap), NONE
            )
            assert np.hypot(e_p, 0.3 * e_w) <= before
            assert np.all((q >= LOWER) & (q <= UPPER))
            assert evaluations == iterations + 1
            np.testing.assert_allclose((e_p, e_w), error_kernel(q, p, R), atol=1e-12)


def test_an_unreachable_pose_ends_at_a_stationary_point():
    # The arm alone cannot meet a free pose: the gradient of the cost, by differences, is zero
    # along every joint that is not at a limit.
    rng = np.random.default_rng(2)
    for q_true, X in targets(20, 2):
        p = X[:3, 3].copy()
        R = kinematics.rotation_from_intrinsic_xyz(rng.uniform(-np.pi, np.pi, 3))
        q = q_true.copy()
        refine_kernel(q, Goal(p, R, Bounds(1, LOWER, UPPER)), Descent(0.3, 0.5, 500, True), NONE)

        def cost(q, p=p, R=R):
            e_p, e_w = error_kernel(q, p, R)
            return e_p**2 + 0.09 * e_w**2

        for j in range(1, 6):
            step = np.zeros(6)
            step[j] = 1e-5
            slope = (cost(q + step) - cost(q - step)) / 2e-5
            at_limit = q[j] in (LOWER[j], UPPER[j])
            if not at_limit:
                assert abs(slope) < 1e-3


def test_limits_and_turns():
    q = np.array([11.0, 7.0, -7.0, 3.0, -3.0, 20.0])
    wrapped, clipped = q.copy(), q.copy()
    keep_limits_kernel(wrapped, Bounds(0, LOWER, UPPER), True)
    keep_limits_kernel(clipped, Bounds(0, LOWER, UPPER), False)
    turn, corner = 2 * np.pi, 0.75 * np.pi
    np.testing.assert_allclose(
        wrapped, [10.0, 7.0 - turn, -7.0 + turn, corner, -corner, 20.0 - 3 * turn]
    )
    np.testing.assert_allclose(clipped, [10.0, turn, -turn, corner, -corner, turn])


@pytest.mark.parametrize(
    ("value", "reference", "expected"),
    [(1.0, -4.0, 1.0 - 2 * np.pi), (1.0, 6.0, 1.0), (-1.0, 6.0, 2 * np.pi - 1.0), (3.0, 3.1, 3.0)],
)
def test_nearest_turns(value, reference, expected):
    q, near = np.full(6, value), np.full(6, reference)
    nearest_turns_kernel(q, near)
    np.testing.assert_allclose(q[[1, 2, 5]], expected)
    np.testing.assert_array_equal(q[[0, 3, 4]], value)
