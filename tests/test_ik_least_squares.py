"""The small linear algebra against numpy's."""

import numpy as np
import pytest

from scara_drake import joints, kinematics
from scara_drake.ik.kernels import least_squares as ls
from scara_drake.ik.kernels.postures import Bounds
from scara_drake.ik.result import ROTATION_LENGTH

RNG = np.random.default_rng(0)


def test_cholesky_solves():
    for n in (1, 3, 6):
        A = RNG.normal(size=(n, n))
        H, b = A @ A.T + 0.1 * np.eye(n), RNG.normal(size=n)
        L, x = H.copy(), b.copy()
        ls.cholesky_kernel(L, n)
        ls.substitute_kernel(L, x, n)
        np.testing.assert_allclose(H @ x, b, atol=1e-9)


def test_eigenvalues_of_a_symmetric_matrix():
    for _ in range(50):
        A = RNG.normal(size=(3, 3))
        G = A @ A.T
        expected = np.linalg.eigvalsh(G)[::-1]
        for rank in (1, 2, 3):
            assert ls.eigenvalue_kernel(G, rank) == pytest.approx(expected[rank - 1], abs=1e-9)
    assert ls.eigenvalue_kernel(2.0 * np.eye(3), 3) == pytest.approx(2.0)


def regular_posture(first_joint, position_first):
    """A posture whose singular values lie above every damping bound."""
    while True:
        q = RNG.uniform(joints.LOWER, joints.UPPER)
        J = kinematics.jacobian(q)[:, first_joint:]
        if position_first:
            Jp, Jw = J[3:], J[:3]
            N = np.eye(J.shape[1]) - np.linalg.pinv(Jp) @ Jp
            free = min(3, J.shape[1] - 3)
            good = np.linalg.svd(Jp)[1][2] > 0.05 and np.linalg.svd(Jw @ N)[1][free - 1] > 0.08
        else:
            W = np.diag([ROTATION_LENGTH] * 3 + [1.0] * 3)
            good = np.linalg.svd(W @ J)[1][-1] > 0.03
        if good:
            return q, J


@pytest.mark.parametrize("first_joint", [0, 1])
def test_position_first_is_the_two_level_pseudo_inverse(first_joint):
    for _ in range(30):
        q, J = regular_posture(first_joint, True)
        e_p, e_w, dq = RNG.normal(size=3), RNG.normal(size=3), np.empty(6)
        free = np.array([float(j >= first_joint) for j in range(6)])
        ls.position_first_kernel(kinematics.jacobian(q), e_p, e_w, free, 0.0, 0.0, dq)
        Jp, Jw = J[3:], J[:3]
        P = np.linalg.pinv(Jp)
        N = np.eye(J.shape[1]) - P @ Jp
        expected = P @ e_p + np.linalg.pinv(Jw @ N, rcond=1e-6) @ (e_w - Jw @ P @ e_p)
        np.testing.assert_allclose(dq[first_joint:], expected, rtol=1e-4, atol=1e-4)
        assert np.all(dq[:first_joint] == 0.0)


@pytest.mark.parametrize("first_joint", [0, 1])
def test_weighted_is_the_weighted_pseudo_inverse(first_joint):
    W = np.diag([ROTATION_LENGTH] * 3 + [1.0] * 3)
    for _ in range(30):
        q, J = regular_posture(first_joint, False)
        e_p, e_w, dq = RNG.normal(size=3), RNG.normal(size=3), np.empty(6)
        free = np.array([float(j >= first_joint) for j in range(6)])
        ls.weighted_kernel(kinematics.jacobian(q), e_p, e_w, free, 0.0, dq)
        expected = np.linalg.pinv(W @ J) @ W @ np.concatenate([e_w, e_p])
        np.testing.assert_allclose(dq[first_joint:], expected, rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize("position_first", [True, False])
def test_steps_stay_bounded_at_singular_postures(position_first):
    stretched = np.array([5.0, 0.0, 0.0, np.pi / 2, np.pi / 2, 0.0])
    folded = np.array([5.0, 0.3, 0.2, np.pi / 2, 0.1, 0.0])  # beam and forearm in line
    for q in (stretched, folded, np.array([5.0, 0, 0, 0, 0, 0.0])):
        for offset in (0.0, 1e-9, 1e-5, 1e-3):
            J = kinematics.jacobian(q + offset)
            for first_joint in (0, 1):
                free = np.array([float(j >= first_joint) for j in range(6)])
                for _ in range(10):
                    e_p, e_w = RNG.normal(size=(2, 3))
                    e_p, e_w = e_p / np.linalg.norm(e_p), e_w / np.linalg.norm(e_w)
                    dq = np.empty(6)
                    if position_first:
                        ls.position_first_kernel(J, e_p, e_w, free, 0.0, 0.0, dq)
                    else:
                        ls.weighted_kernel(J, e_p, e_w, free, 0.0, dq)
                    # Gain of damped least squares: at most 1 / (2 bound) in each stage.
                    bound = 1e3 if position_first else 0.6 / ls.WEIGHTED_BOUND
                    assert np.linalg.norm(dq) < bound


def test_nothing_moves_where_nothing_is_free():
    J, dq = kinematics.jacobian(joints.HOME), np.ones(6)
    ls.position_first_kernel(J, np.ones(3), np.ones(3), np.zeros(6), 0.0, 0.0, dq)
    assert np.all(dq == 0.0)
    dq = np.ones(6)
    ls.weighted_kernel(J, np.ones(3), np.ones(3), np.zeros(6), 0.0, dq)
    assert np.all(dq == 0.0)


@pytest.mark.parametrize("position_first", [True, False])
def test_a_joint_at_its_limit_is_held_and_the_others_take_over(position_first):
    J = kinematics.jacobian(joints.HOME)
    free, free_dq, dq = np.empty(6), np.empty(6), np.empty(6)
    e_p, e_w = np.array([0.1, 0.2, -0.1]), np.array([0.1, -0.1, 0.2])
    wide = np.full(6, 100.0)
    home, priority = np.array(joints.HOME), ls.Priority(position_first, 0.0, 0.0)
    bounds = Bounds(0, -wide, wide)
    ls.bounded_step_kernel(J, e_p, e_w, priority, home, bounds, free, free_dq)
    for j in range(6):
        lower, upper = -wide, wide.copy()
        lower, upper = lower.copy(), upper.copy()
        if free_dq[j] > 0.0:
            upper[j] = joints.HOME[j]
        else:
            lower[j] = joints.HOME[j]
        bounds = Bounds(0, lower, upper)
        ls.bounded_step_kernel(J, e_p, e_w, priority, home, bounds, free, dq)
        assert dq[j] == 0.0
        assert free[j] == 0.0
        if position_first:
            np.testing.assert_allclose(J[3:] @ dq, e_p, atol=1e-2)
