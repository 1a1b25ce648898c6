"""Kinematics against the plain product of Table 1, finite differences, and Drake's angles."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.common.eigen_geometry import AngleAxis, Quaternion
from pydrake.math import RollPitchYaw, RotationMatrix

from scara_drake import joints, kinematics

angle = st.floats(-np.pi, np.pi)
small = st.floats(-1.0, 1.0)


def turned(w):
    """Rotation (3, 3) of a rotation vector, by Drake."""
    angle = float(np.linalg.norm(w))
    axis = np.asarray(w) / angle if angle > 1e-100 else np.array([1.0, 0.0, 0.0])
    return RotationMatrix(AngleAxis(angle, axis)).matrix()


def row(theta, d, a, alpha):
    """Rz(theta) Tz(d) Tx(a) Rx(alpha), one row of Table 1."""
    ct, s, ca, sa = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
    return np.array(
        [[ct, -s * ca, s * sa, a * ct], [s, ct * ca, -ct * sa, a * s], [0, sa, ca, d], [0, 0, 0, 1]]
    )


def product(q):
    quarter = np.pi / 2
    rows = [
        (0, q[0], 0, 0),
        (q[1], 0, 0, -quarter),
        (q[2], 0.750, 0, quarter),
        (q[3], 0, 0.820, 0),
        (q[4], 0, 0, quarter),
        (q[5], 0.730, 0, 0),
    ]
    X = np.eye(4)
    for r in rows:
        X = X @ row(*r)
    return X


def postures(n, seed=0):
    return np.random.default_rng(seed).uniform(joints.LOWER, joints.UPPER, (n, 6))


def test_forward_kinematics_is_the_product_of_table_1():
    for q in postures(100):
        np.testing.assert_allclose(kinematics.forward_kinematics(q), product(q), atol=1e-12)


def test_zero_posture_by_hand():
    # Beam along y, forearm along x, tool along -y: the lengths add up by eye.
    X = kinematics.forward_kinematics(np.zeros(6))
    np.testing.assert_allclose(X[:3, 3], [0.820, 0.750 - 0.730, 0.0], atol=1e-15)
    np.testing.assert_allclose(X[:3, 2], [0.0, -1.0, 0.0], atol=1e-15)


def test_batches_keep_their_shape_and_their_values():
    q = postures(12).reshape(3, 4, 6)
    X, J = kinematics.forward_kinematics(q), kinematics.jacobian(q)
    assert X.shape == (3, 4, 4, 4)
    assert J.shape == (3, 4, 6, 6)
    np.testing.assert_array_equal(X[1, 2], kinematics.forward_kinematics(q[1, 2]))
    np.testing.assert_array_equal(J[2, 3], kinematics.jacobian(q[2, 3]))
    assert kinematics.forward_kinematics(np.empty((0, 6))).shape == (0, 4, 4)
    strided = np.asfortranarray(q[0])
    np.testing.assert_array_equal(kinematics.forward_kinematics(strided), X[0])


def test_integers_are_accepted():
    np.testing.assert_array_equal(
        kinematics.forward_kinematics([1, 0, 0, 0, 0, 0]),
        kinematics.forward_kinematics([1.0, 0, 0, 0, 0, 0]),
    )


def test_jacobian_is_the_derivative():
    h = 1e-6
    for q in postures(30, seed=1):
        J = kinematics.jacobian(q)
        for j in range(6):
            step = np.zeros(6)
            step[j] = h
            plus, minus = (kinematics.forward_kinematics(q + s * step) for s in (1, -1))
            v = (plus[:3, 3] - minus[:3, 3]) / (2 * h)
            E = plus[:3, :3] @ minus[:3, :3].T
            w = np.array([E[2, 1] - E[1, 2], E[0, 2] - E[2, 0], E[1, 0] - E[0, 1]]) / (4 * h)
            np.testing.assert_allclose(J[:, j], np.concatenate([w, v]), atol=1e-8)


@pytest.mark.parametrize("call", [kinematics.forward_kinematics, kinematics.jacobian])
@pytest.mark.parametrize("q", [1.0, np.zeros(5), np.zeros((6, 5))])
def test_wrong_shapes_are_refused(call, q):
    with pytest.raises(ValueError, match=r"q: shape .* allowed \(\.\.\., 6\)"):
        call(q)


def test_angles_and_rotations_refuse_wrong_shapes():
    with pytest.raises(ValueError, match="rpy: shape"):
        kinematics.rotation_from_intrinsic_xyz([1.0, 2.0])
    with pytest.raises(ValueError, match="R: shape"):
        kinematics.intrinsic_xyz_from_rotation(np.eye(4))
    with pytest.raises(ValueError, match="X: shape"):
        kinematics.pose_error(np.eye(3), np.eye(3))


@settings(deadline=None)
@given(roll=angle, pitch=angle, yaw=angle)
def test_intrinsic_xyz_turns_about_x_then_the_new_y_then_the_new_z(roll, pitch, yaw):
    R = kinematics.rotation_from_intrinsic_xyz([roll, pitch, yaw])
    by_turns = turned([roll, 0, 0]) @ turned([0, pitch, 0]) @ turned([0, 0, yaw])
    np.testing.assert_allclose(R, by_turns, atol=1e-14)


@settings(deadline=None)
@given(roll=angle, pitch=st.floats(-np.pi / 2, np.pi / 2), yaw=angle)
def test_angles_round_trip(roll, pitch, yaw):
    R = kinematics.rotation_from_intrinsic_xyz([roll, pitch, yaw])
    angles = kinematics.intrinsic_xyz_from_rotation(R)
    assert abs(angles[1]) <= np.pi / 2
    np.testing.assert_allclose(kinematics.rotation_from_intrinsic_xyz(angles), R, atol=1e-10)


@pytest.mark.parametrize("pitch", [np.pi / 2, -np.pi / 2])
def test_angles_at_gimbal_lock(pitch):
    R = kinematics.rotation_from_intrinsic_xyz([0.3, pitch, 0.4])
    angles = kinematics.intrinsic_xyz_from_rotation(R)
    assert angles[2] == 0.0
    np.testing.assert_allclose(kinematics.rotation_from_intrinsic_xyz(angles), R, atol=1e-12)


def test_drakes_roll_pitch_yaw_is_another_convention():
    rpy = np.array([-2.35, -0.82, -1.74])  # Table 5, posture 1
    R = kinematics.rotation_from_intrinsic_xyz(rpy)
    drake = RollPitchYaw(rpy).ToRotationMatrix().matrix()
    assert np.abs(R - drake).max() > 0.1
    # They are each other's reversed order.
    reversed_order = RollPitchYaw(-rpy).ToRotationMatrix().matrix().T
    np.testing.assert_allclose(R, reversed_order, atol=1e-14)


@settings(deadline=None)
@given(
    axis=st.tuples(small, small, small).filter(lambda a: np.linalg.norm(a) > 0.1),
    angle=st.one_of(
        st.floats(0.0, np.pi),
        st.floats(0.0, 1e-6),
        st.floats(np.pi - 1e-6, np.pi),
        st.sampled_from([0.0, 1e-12, 1e-9, np.pi]),
    ),
    turn=st.tuples(angle, angle, angle),
)
def test_rotation_vector_turns_one_rotation_into_the_other(axis, angle, turn):
    w = angle * np.array(axis) / np.linalg.norm(axis)
    R = kinematics.rotation_from_intrinsic_xyz(turn)
    R_desired = turned(w) @ R
    found = np.empty(3)
    length = kinematics.rotation_vector_kernel(R_desired, R, found)
    assert length == pytest.approx(angle, abs=2e-8)
    assert length == pytest.approx(np.linalg.norm(found), abs=1e-8)
    np.testing.assert_allclose(turned(found) @ R, R_desired, atol=2e-8)


@pytest.mark.parametrize("axis", [[1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 2, -3]])
def test_rotation_vector_of_half_a_turn(axis):
    w = np.pi * np.array(axis) / np.linalg.norm(axis)
    found = np.empty(3)
    R_desired = turned(w)
    assert kinematics.rotation_vector_kernel(R_desired, np.eye(3), found) == pytest.approx(np.pi)
    np.testing.assert_allclose(np.abs(found @ w), np.pi**2, rtol=1e-7)


@settings(deadline=None)
@given(angle=st.one_of(st.floats(0.0, np.pi), st.floats(0.0, 1e-6)), distance=st.floats(0.0, 10.0))
def test_pose_error_of_a_known_displacement(angle, distance):
    X = product([3.0, 0.4, -0.3, 0.5, 0.7, 1.0])
    D = X.copy()
    direction = np.array([2.0, -1.0, 2.0]) / 3.0
    D[:3, 3] += distance * direction
    D[:3, :3] = turned(angle * direction) @ X[:3, :3]
    position, rotation = kinematics.pose_error(D, X)
    assert position == pytest.approx(distance, abs=1e-12)
    # The chord is flat at half a turn: there its angle is good to the root of the rounding.
    tolerance = 1e-14 if angle < 1e-6 else 1e-7
    assert rotation == pytest.approx(angle, abs=tolerance)


def test_pose_error_broadcasts():
    X = kinematics.forward_kinematics(postures(5))
    position, rotation = kinematics.pose_error(X[0], X)
    assert position.shape == rotation.shape == (5,)
    assert position[0] == rotation[0] == 0.0


def test_rotation_from_quaternion_of_any_length():
    R = np.empty((3, 3))
    quaternion = np.array([0.3, -0.5, 0.2, 0.9])
    kinematics.rotation_from_quaternion_kernel(quaternion, R)
    unit = quaternion / np.linalg.norm(quaternion)
    expected = RotationMatrix(Quaternion(unit)).matrix()
    np.testing.assert_allclose(R, expected, atol=1e-14)


def test_rotation_from_no_quaternion_is_the_identity():
    R = np.empty((3, 3))
    kinematics.rotation_from_quaternion_kernel(np.zeros(4), R)
    np.testing.assert_array_equal(R, np.eye(3))


def test_reach_is_the_sum_of_the_lengths():
    # Stretched: forearm along the beam (theta4 = 90 deg), tool along the forearm (theta5 = 90 deg).
    q = [0.0, 0.0, 0.0, np.pi / 2, np.pi / 2, 0.0]
    assert np.linalg.norm(product(q)[:3, 3]) == pytest.approx(kinematics.REACH)
    np.testing.assert_allclose(kinematics.REACH, 2.3)
