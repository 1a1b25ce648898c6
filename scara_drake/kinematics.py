"""Kinematics of the SCARA: Denavit-Hartenberg chain, Jacobian, orientation angles, pose error.

Frames: W is the world, at mast height d1 = 0 with z up; E is the tool frame at the end of the last
row of the paper's Table 1. A configuration is ``q = [d1 (m), theta2 .. theta6 (rad)]``.

The functions ending in ``_kernel`` are compiled, take contiguous float64 arrays of one
configuration and write into arrays of the caller, so that a 1 kHz loop allocates nothing. The
public functions take any leading batch shape.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

# Lengths of Table 1, [m]: d of joint 3, a of joint 4, d of joint 6.
D3 = 0.750
A4 = 0.820
D6 = 0.730
REACH = D3 + A4 + D6
# The beam stays horizontal: the tool reaches every point within A4 + D6 of a circle of radius D3
# around the mast. It is kept this far from the edge, where the arm loses a direction of motion.
REACH_LIMIT = 0.98 * (A4 + D6)  # [m]


@njit(cache=True)
def tool_pose_kernel(q: Array, p_WE: Array, R_WE: Array) -> None:
    """Write the tool position (3,) [m] and rotation (3, 3) of one configuration (6,).

    Closed product of the six rows of Table 1: with C = Rz(θ2) Ry(θ3) the arm plane, the forearm
    lies along C Rz(θ4) e_x and the tool along C Rz(θ4 + θ5) (-e_y).
    """
    s2, c2 = np.sin(q[1]), np.cos(q[1])
    s3, c3 = np.sin(q[2]), np.cos(q[2])
    s4, c4 = np.sin(q[3]), np.cos(q[3])
    s45, c45 = np.sin(q[3] + q[4]), np.cos(q[3] + q[4])
    s6, c6 = np.sin(q[5]), np.cos(q[5])
    # Columns of C: x, y (the axis of the beam, z2) and z (the axis of joints 4 and 5).
    xx, xy, xz = c2 * c3, s2 * c3, -s3
    yx, yy = -s2, c2
    zx, zy, zz = c2 * s3, s2 * s3, c3
    # Columns of C Rz(θ4 + θ5) Rx(90°): along u, along the plane normal, along the tool axis a.
    ux, uy, uz = c45 * xx + s45 * yx, c45 * xy + s45 * yy, c45 * xz
    ax, ay, az = s45 * xx - c45 * yx, s45 * xy - c45 * yy, s45 * xz
    R_WE[0, 0], R_WE[1, 0], R_WE[2, 0] = c6 * ux + s6 * zx, c6 * uy + s6 * zy, c6 * uz + s6 * zz
    R_WE[0, 1], R_WE[1, 1], R_WE[2, 1] = c6 * zx - s6 * ux, c6 * zy - s6 * uy, c6 * zz - s6 * uz
    R_WE[0, 2], R_WE[1, 2], R_WE[2, 2] = ax, ay, az
    p_WE[0] = D3 * yx + A4 * (c4 * xx + s4 * yx) + D6 * ax
    p_WE[1] = D3 * yy + A4 * (c4 * xy + s4 * yy) + D6 * ay
    p_WE[2] = q[0] + A4 * c4 * xz + D6 * az


@njit(cache=True)
def tool_kinematics_kernel(q: Array, p_WE: Array, R_WE: Array, J_WE: Array) -> None:
    """Write the tool pose and its Jacobian (6, 6): rows angular then linear, expressed in W.

    Column of a revolute joint with axis z through o: (z, z x (p - o)), equation (11) of the paper.
    """
    tool_pose_kernel(q, p_WE, R_WE)
    s2, c2 = np.sin(q[1]), np.cos(q[1])
    s3, c3 = np.sin(q[2]), np.cos(q[2])
    yx, yy = -s2, c2
    nx, ny, nz = c2 * s3, s2 * s3, c3
    ax, ay, az = R_WE[0, 2], R_WE[1, 2], R_WE[2, 2]
    # Levers from each axis to the tool point.
    rx, ry, rz = p_WE[0], p_WE[1], p_WE[2] - q[0]
    ex, ey = rx - D3 * yx, ry - D3 * yy
    tx, ty, tz = D6 * ax, D6 * ay, D6 * az
    for i in range(6):
        J_WE[i, 0] = 0.0
    J_WE[5, 0] = 1.0
    J_WE[0, 1], J_WE[1, 1], J_WE[2, 1] = 0.0, 0.0, 1.0
    J_WE[3, 1], J_WE[4, 1], J_WE[5, 1] = -ry, rx, 0.0
    J_WE[0, 2], J_WE[1, 2], J_WE[2, 2] = yx, yy, 0.0
    J_WE[3, 2], J_WE[4, 2], J_WE[5, 2] = yy * rz, -yx * rz, yx * ry - yy * rx
    J_WE[0, 3], J_WE[1, 3], J_WE[2, 3] = nx, ny, nz
    J_WE[3, 3], J_WE[4, 3], J_WE[5, 3] = ny * rz - nz * ey, nz * ex - nx * rz, nx * ey - ny * ex
    J_WE[0, 4], J_WE[1, 4], J_WE[2, 4] = nx, ny, nz
    J_WE[3, 4], J_WE[4, 4], J_WE[5, 4] = ny * tz - nz * ty, nz * tx - nx * tz, nx * ty - ny * tx
    J_WE[0, 5], J_WE[1, 5], J_WE[2, 5] = ax, ay, az
    J_WE[3, 5], J_WE[4, 5], J_WE[5, 5] = 0.0, 0.0, 0.0


@njit(cache=True)
def rotation_vector_kernel(R_desired: Array, R: Array, w: Array) -> float:
    """Write the rotation vector (3,) [rad], in W, from R to R_desired; return its length."""
    # E = R_desired R^T; its skew part is sin(angle) times the axis.
    c = 0.0
    for i in range(3):
        for k in range(3):
            c += R_desired[i, k] * R[i, k]
    cos_angle = 0.5 * (c - 1.0)
    e21 = e12 = e02 = e20 = e10 = e01 = 0.0
    for k in range(3):
        e21 += R_desired[2, k] * R[1, k]
        e12 += R_desired[1, k] * R[2, k]
        e02 += R_desired[0, k] * R[2, k]
        e20 += R_desired[2, k] * R[0, k]
        e10 += R_desired[1, k] * R[0, k]
        e01 += R_desired[0, k] * R[1, k]
    x, y, z = 0.5 * (e21 - e12), 0.5 * (e02 - e20), 0.5 * (e10 - e01)
    sin_angle = np.sqrt(x * x + y * y + z * z)
    angle = np.arctan2(sin_angle, cos_angle)
    if sin_angle > 1e-9:
        g = angle / sin_angle
        w[0], w[1], w[2] = g * x, g * y, g * z
    elif cos_angle > 0.0:
        w[0], w[1], w[2] = x, y, z
    else:
        # Half a turn: E = 2 a a^T - 1, whose diagonal and columns give the axis a.
        d0 = d1 = d2 = 0.0
        for k in range(3):
            d0 += R_desired[0, k] * R[0, k]
            d1 += R_desired[1, k] * R[1, k]
            d2 += R_desired[2, k] * R[2, k]
        s01, s02, s12 = 0.5 * (e01 + e10), 0.5 * (e02 + e20), 0.5 * (e12 + e21)
        if d0 >= d1 and d0 >= d2:
            n = np.sqrt(0.5 * (d0 + 1.0))
            w[0], w[1], w[2] = angle * n, angle * 0.5 * s01 / n, angle * 0.5 * s02 / n
        elif d1 >= d2:
            n = np.sqrt(0.5 * (d1 + 1.0))
            w[0], w[1], w[2] = angle * 0.5 * s01 / n, angle * n, angle * 0.5 * s12 / n
        else:
            n = np.sqrt(0.5 * (d2 + 1.0))
            w[0], w[1], w[2] = angle * 0.5 * s02 / n, angle * 0.5 * s12 / n, angle * n
    return angle


@njit(cache=True)
def rotation_from_quaternion_kernel(quaternion: Array, R: Array) -> None:
    """Write the rotation (3, 3) of a quaternion (4,) w, x, y, z of any positive length."""
    w, x, y, z = quaternion[0], quaternion[1], quaternion[2], quaternion[3]
    n = w * w + x * x + y * y + z * z
    s = 2.0 / n if n > 0.0 else 0.0
    R[0, 0], R[0, 1], R[0, 2] = 1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)
    R[1, 0], R[1, 1], R[1, 2] = s * (x * y + w * z), 1 - s * (x * x + z * z), s * (y * z - w * x)
    R[2, 0], R[2, 1], R[2, 2] = s * (x * z - w * y), s * (y * z + w * x), 1 - s * (x * x + y * y)


@njit(cache=True)
def quaternion_from_rotation_kernel(R: Array, quaternion: Array) -> None:
    """Write the quaternion (4,) w, x, y, z of a rotation (3, 3), with w of 0 or more.

    The largest of the four is found from the diagonal first, as then nothing cancels (Shepperd,
    1978).
    """
    trace = R[0, 0] + R[1, 1] + R[2, 2]
    w, x, y, z = quaternion[0:1], quaternion[1:2], quaternion[2:3], quaternion[3:4]
    if trace >= R[0, 0] and trace >= R[1, 1] and trace >= R[2, 2]:
        w[0] = 1.0 + trace
        x[0], y[0], z[0] = R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]
    elif R[0, 0] >= R[1, 1] and R[0, 0] >= R[2, 2]:
        w[0], x[0] = R[2, 1] - R[1, 2], 1.0 - (trace - 2.0 * R[0, 0])
        y[0], z[0] = R[0, 1] + R[1, 0], R[0, 2] + R[2, 0]
    elif R[1, 1] >= R[2, 2]:
        w[0], y[0] = R[0, 2] - R[2, 0], 1.0 - (trace - 2.0 * R[1, 1])
        x[0], z[0] = R[0, 1] + R[1, 0], R[1, 2] + R[2, 1]
    else:
        w[0], z[0] = R[1, 0] - R[0, 1], 1.0 - (trace - 2.0 * R[2, 2])
        x[0], y[0] = R[0, 2] + R[2, 0], R[1, 2] + R[2, 1]
    length = np.sqrt((quaternion**2).sum())
    quaternion /= length if w[0] >= 0.0 else -length


@njit(cache=True)
def draw_into_reach(p: Array) -> bool:
    """Move a point (3,) relative to the arm's base back into its reach; return whether it was out.

    The point goes straight towards the nearest point of the circle that the end of the beam can
    be on, and stops at `REACH_LIMIT` from it.
    """
    radius = np.sqrt(p[0] * p[0] + p[1] * p[1])
    x = D3 * p[0] / radius if radius > 0.0 else D3
    y = D3 * p[1] / radius if radius > 0.0 else 0.0
    distance = np.sqrt((p[0] - x) ** 2 + (p[1] - y) ** 2 + p[2] ** 2)
    if distance <= REACH_LIMIT:
        return False
    share = REACH_LIMIT / distance
    p[0], p[1], p[2] = x + share * (p[0] - x), y + share * (p[1] - y), share * p[2]
    return True


@njit(cache=True)
def _forward_kinematics_batch(q: Array, X_WE: Array) -> None:
    for i in range(q.shape[0]):
        tool_pose_kernel(q[i], X_WE[i, :3, 3], X_WE[i, :3, :3])
        X_WE[i, 3, 3] = 1.0


@njit(cache=True)
def _jacobian_batch(q: Array, J_WE: Array) -> None:
    p, R = np.empty(3), np.empty((3, 3))
    for i in range(q.shape[0]):
        tool_kinematics_kernel(q[i], p, R, J_WE[i])


def _configurations(q: ArrayLike) -> Array:
    array = np.ascontiguousarray(q, dtype=np.float64)
    if array.ndim == 0 or array.shape[-1] != 6:
        raise ValueError(
            f"q: shape {array.shape}, allowed (..., 6): d1 [m], theta2 .. theta6 [rad]"
        )
    return array


def forward_kinematics(q: ArrayLike) -> Array:
    """Tool pose X_WE (..., 4, 4) of configurations q (..., 6), Tables 1 and equation (21).

    Raises:
        ValueError: the last axis of q has not six entries.
    """
    array = _configurations(q)
    X_WE = np.zeros((*array.shape[:-1], 4, 4))
    _forward_kinematics_batch(array.reshape(-1, 6), X_WE.reshape(-1, 4, 4))
    return X_WE


def jacobian(q: ArrayLike) -> Array:
    r"""Jacobian J_WE (..., 6, 6) of configurations q (..., 6), equation (11).

    The column of a revolute joint with the axis z through o, and of the mast:

    .. math::

        J_j = (z_j,\; z_j \times (p_E - o_j)), \quad J_1 = (0,\; e_z)

    Rows are the angular then the linear velocity of E in W, as in Drake's spatial velocity; column
    j is per unit rate of joint j (m/s for the mast, rad/s for the others).

    Raises:
        ValueError: the last axis of q has not six entries.
    """
    array = _configurations(q)
    J_WE = np.zeros((*array.shape[:-1], 6, 6))
    _jacobian_batch(array.reshape(-1, 6), J_WE.reshape(-1, 6, 6))
    return J_WE


def rotation_from_intrinsic_xyz(rpy: ArrayLike) -> Array:
    r"""Rotation (..., 3, 3) = Rx(roll) Ry(pitch) Rz(yaw) of angles (..., 3) [rad].

    .. math::

        R = R_x(\text{roll})\, R_y(\text{pitch})\, R_z(\text{yaw})

    This is the paper's convention: of 24 orders, only this one lets the arm with its mast meet all
    four postures of Table 5. Drake's RollPitchYaw is Rz(yaw) Ry(pitch) Rx(roll).
    """
    angles = np.asarray(rpy, dtype=np.float64)
    if angles.ndim == 0 or angles.shape[-1] != 3:
        raise ValueError(f"rpy: shape {angles.shape}, allowed (..., 3): roll, pitch, yaw [rad]")
    (sr, sp, sy), (cr, cp, cy) = (np.moveaxis(f(angles), -1, 0) for f in (np.sin, np.cos))
    rows = [
        [cp * cy, -cp * sy, sp],
        [cr * sy + sr * sp * cy, cr * cy - sr * sp * sy, -sr * cp],
        [sr * sy - cr * sp * cy, sr * cy + cr * sp * sy, cr * cp],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def intrinsic_xyz_from_rotation(R: ArrayLike) -> Array:
    """Angles roll, pitch, yaw (..., 3) [rad] of rotations (..., 3, 3); pitch lies in ±π/2.

    At pitch = ±π/2 only the sum or the difference of roll and yaw is defined: yaw is then zero.
    """
    m = np.asarray(R, dtype=np.float64)
    if m.shape[-2:] != (3, 3):
        raise ValueError(f"R: shape {m.shape}, allowed (..., 3, 3)")
    cos_pitch = np.hypot(m[..., 0, 0], m[..., 0, 1])
    pitch = np.arctan2(m[..., 0, 2], cos_pitch)
    regular = cos_pitch > 1e-12
    roll = np.where(
        regular,
        np.arctan2(-m[..., 1, 2], m[..., 2, 2]),
        np.arctan2(m[..., 2, 1], m[..., 1, 1]),
    )
    yaw = np.where(regular, np.arctan2(-m[..., 0, 1], m[..., 0, 0]), 0.0)
    return np.stack([roll, pitch, yaw], axis=-1)


def pose_error(X_desired: ArrayLike, X: ArrayLike) -> tuple[Array, Array]:
    """Distance (...) [m] and rotation angle (...) [rad] between poses (..., 4, 4), broadcast.

    The angle is that of R_desired^T R: well defined where roll and yaw are not. It is computed
    from the chord, so that small angles keep their digits.
    """
    D, A = np.broadcast_arrays(
        np.asarray(X_desired, dtype=np.float64), np.asarray(X, dtype=np.float64)
    )
    if D.shape[-2:] != (4, 4):
        raise ValueError(f"X: shape {D.shape}, allowed (..., 4, 4)")
    distance = np.linalg.norm(D[..., :3, 3] - A[..., :3, 3], axis=-1)
    chord = np.linalg.norm(D[..., :3, :3] - A[..., :3, :3], axis=(-2, -1)) / np.sqrt(8.0)
    return distance, 2.0 * np.arcsin(np.minimum(chord, 1.0))
