"""Closed form of the arm at a given mast height, and what it shares with the one with the mast.

In the frame Rz(θ2), where y is the axis of the beam, the wrist centre (the tool point less d6
along the tool axis a) lies at

    (a4 cos θ4 cos θ3,  d3 + a4 sin θ4,  d1 - a4 cos θ4 sin θ3)

and joints 4 and 5 are parallel, so their axis n = (sin θ3, 0, cos θ3) is normal to a. The five
joints have one equation too many for a pose: the residual says how far it is from being met.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.ik.kernels.errors import linear_kernel, linearize_kernel
from scara_drake.ik.kernels.least_squares import (
    cholesky_kernel,
    normal_equations_kernel,
    substitute_kernel,
)
from scara_drake.ik.kernels.postures import mirror_kernel, wrap_kernel
from scara_drake.kinematics import A4, D3, D6, rotation_vector_kernel, tool_pose_kernel

Array = NDArray[np.float64]

EXACT = 1e-9  # errors [m] and [rad] of a solution
SHARP = 1e-11  # those that need no Newton step
SAME = 1e-5  # solutions that differ less in every joint are one
# A candidate further than this from exact is of another branch or of no posture [m], [rad].
NEAR = 1e-3
NEWTON_STEPS = 20
DAMPING = 1e-3  # of the Newton steps, in units of the squared error
SMALL_FOREARM = 1e-3  # of the forearm across the beam, [m]: θ3 is then taken from the tool axis
VERTICAL = 1e-12  # horizontal part of the tool axis [1], also of the wrist [m], that is rounding
ON_THE_AXIS = 1e-6  # distance from wrist to mast axis, [m]: θ2 is then taken from the tool axis


@njit(cache=True)
def tool_angles_kernel(R_WE: Array, c2: float, s2: float, c3: float, s3: float, q: Array) -> None:
    """Write theta5 and theta6 of q (6,) from the rotation, with theta4 already there."""
    nx, ny, nz = c2 * s3, s2 * s3, c3
    along = (R_WE[0, 2] * c2 + R_WE[1, 2] * s2) * c3 - R_WE[2, 2] * s3  # a in the arm plane
    across = R_WE[1, 2] * c2 - R_WE[0, 2] * s2
    q[4] = wrap_kernel(np.arctan2(along, -across) - q[3])
    sin6 = nx * R_WE[0, 0] + ny * R_WE[1, 0] + nz * R_WE[2, 0]
    cos6 = nx * R_WE[0, 1] + ny * R_WE[1, 1] + nz * R_WE[2, 1]
    q[5] = wrap_kernel(np.arctan2(sin6, cos6))


@njit(cache=True)
def other_posture_kernel(q: Array, mirrored: Array) -> None:
    """Write the posture (6,) of the same pose with the beam half a turn on, within (-pi, pi]."""
    mirror_kernel(q, mirrored)
    for j in range(2, 6):
        mirrored[j] = wrap_kernel(mirrored[j])


@njit(cache=True)
def make_exact_kernel(
    q: Array, p_WE: Array, R_WE: Array, first_joint: int, p: Array, R: Array
) -> bool:
    """Confirm q (6,) by forward kinematics; Newton steps supply the digits that are missing.

    p (3,) and R (3, 3) are work space. Returns whether both errors end within 1e-9.
    """
    tool_pose_kernel(q, p, R)
    x, y, z = p_WE[0] - p[0], p_WE[1] - p[1], p_WE[2] - p[2]
    error = max(np.sqrt(x * x + y * y + z * z), rotation_vector_kernel(R_WE, R, p))
    if error < SHARP or error > NEAR:
        return error < SHARP
    return _newton(q, p_WE, R_WE, first_joint) <= EXACT


@njit(cache=True)
def _newton(q: Array, p_WE: Array, R_WE: Array, first_joint: int) -> float:
    """Newton steps on q (6,) while they help, damped near singular postures; the larger error."""
    at, H, dq, free, best = linear_kernel(), np.empty((6, 6)), np.empty(6), np.ones(6), q.copy()
    free[0] = 1.0 - first_joint
    least, larger, damping = np.inf, np.inf, 1.0
    for _ in range(NEWTON_STEPS):
        square, rotation = linearize_kernel(q, p_WE, R_WE, at)
        cost = square + rotation * rotation
        if cost < least:
            best[:] = q
            small = cost > 0.25 * least
            least, larger = cost, max(np.sqrt(square), rotation)
            if larger < SHARP and small:
                break
            damping *= 0.1
        else:
            if larger < SHARP or damping > 1e6:
                break
            q[:] = best
            linearize_kernel(q, p_WE, R_WE, at)
            damping *= 100.0
        normal_equations_kernel(at.J, at.e_p, at.e_w, 1.0, free, H, dq)
        for j in range(6):
            H[j, j] += damping * (DAMPING * least + 1e-16)
        cholesky_kernel(H, 6)
        substitute_kernel(H, dq, 6)
        q += dq
    q[:] = best
    for j in range(1, 6):
        q[j] = wrap_kernel(q[j])
    return larger


@njit(cache=True)
def known_kernel(q: Array, solutions: Array, n: int) -> bool:
    """Whether q (6,) is one of the first n solutions, whole turns aside."""
    for k in range(n):
        same = abs(q[0] - solutions[k, 0]) < SAME
        for j in range(1, 6):
            same = same and abs(wrap_kernel(q[j] - solutions[k, j])) < SAME
        if same:
            return True
    return False


@njit(cache=True)
def _branch(
    p_WE: Array, R_WE: Array, mast_height: float, sigma: float, bound: float, q: Array
) -> float:
    """Write the candidate q (6,) of one side and return its residual; past `bound`, only that."""
    ux, uy, uz = -R_WE[0, 2], -R_WE[1, 2], -R_WE[2, 2]
    wx, wy = p_WE[0] + D6 * ux, p_WE[1] + D6 * uy
    wz = p_WE[2] + D6 * uz - mast_height
    square = wx * wx + wy * wy
    radius = np.sqrt(square)
    s4 = (square + wz * wz - D3 * D3 - A4 * A4) / (2.0 * D3 * A4)
    s4 = min(max(s4, -1.0), 1.0)
    y = D3 + A4 * s4
    if radius > ON_THE_AXIS:
        x = sigma * np.sqrt(max(0.0, (radius - y) * (radius + y)))
        length = radius * np.sqrt(x * x + y * y)
        if length > 0.0:
            c2, s2 = (wx * x + wy * y) / length, (wy * x - wx * y) / length
        else:  # out of reach: the posture would have its wrist on the axis of the mast
            c2, s2 = wy / radius, -wx / radius
        across, along = wx * c2 + wy * s2, wy * c2 - wx * s2
    else:
        level = np.sqrt(ux * ux + uy * uy)
        c2 = sigma * uy / level if level > VERTICAL else sigma
        s2 = -sigma * ux / level if level > VERTICAL else 0.0
        across, along = wx * c2 + wy * s2, wy * c2 - wx * s2
        x = across
    # The forearm across the beam, (x, -wz), and the direction that is normal to the tool axis.
    forearm = np.sqrt(x * x + wz * wz)
    tool_x = ux * c2 + uy * s2
    normal = np.sqrt(tool_x * tool_x + uz * uz)
    if forearm < SMALL_FOREARM and forearm < normal:
        c3, s3 = tool_x / normal, -uz / normal
        if x * c3 - wz * s3 < 0.0:
            c3, s3 = -c3, -s3
    elif forearm > 1e-9:
        c3, s3 = x / forearm, -wz / forearm
    else:
        c3, s3 = 1.0, 0.0
    extent = np.sqrt(forearm * forearm + (y - D3) * (y - D3))
    residual = (
        np.sqrt((across - x) * (across - x) + (along - y) * (along - y))
        + abs(extent - A4)
        + abs(x * s3 + wz * c3)
        + abs(tool_x * s3 + uz * c3)
    )
    if residual <= bound:
        q[0] = mast_height
        q[1], q[2] = wrap_kernel(np.arctan2(s2, c2)), wrap_kernel(np.arctan2(s3, c3))
        q[3] = np.arctan2(A4 * s4, forearm)
        tool_angles_kernel(R_WE, c2, s2, c3, s3, q)
    return residual


@njit(cache=True)
def arm_branches_kernel(
    p_WE: Array, R_WE: Array, mast_height: float, q: Array, residual: Array
) -> int:
    """Write the four candidates q (4, 6) of the arm, and how far each is from the pose.

    Rows 0 and 1 have the wrist on one side of the beam (sigma = 1), rows 2 and 3 on the other; the
    second row of a pair is the first with the beam half a turn on. A pose that the five joints can
    hold has in general two solutions, the pair with residual zero. Limits are not applied; angles
    lie within (-pi, pi]; square roots of what is out of reach count as zero.

    Where the wrist lies on the axis of the beam (θ4 = ±pi/2), or near it, θ3 follows from the tool
    axis; where the wrist lies on the axis of the mast, θ2 does. Where the tool axis leaves them
    free as well, a family of solutions turns them against θ6, and the one with that angle zero
    stands for it.

    Args:
        p_WE: tool position (3,) [m].
        R_WE: tool rotation (3, 3).
        mast_height: d1 [m].
        q: candidates (4, 6).
        residual: (4,), sum of the misfit of the wrist [m] and of the tool axis [rad].

    Returns:
        The number of candidates, 4.
    """
    for k in (0, 2):
        sigma = 1.0 if k == 0 else -1.0
        residual[k] = _branch(p_WE, R_WE, mast_height, sigma, np.inf, q[k])
        residual[k + 1] = residual[k]
        other_posture_kernel(q[k], q[k + 1])
    return 4


@njit(cache=True)
def arm_solutions_kernel(p_WE: Array, R_WE: Array, mast_height: float, q: Array) -> int:
    """Write every solution of the arm, q (4 or more, 6), exact within 1e-9, limits not applied.

    Returns their number: 2 for a pose that the arm can hold, 0 for one that it cannot; 4 where it
    can from both sides, as in the SCARA configuration.
    """
    p, R = np.empty(3), np.empty((3, 3))
    n = 0
    for sigma in (1.0, -1.0):
        posture = q[n]
        if _branch(p_WE, R_WE, mast_height, sigma, NEAR, posture) > NEAR:
            continue
        if not make_exact_kernel(posture, p_WE, R_WE, 1, p, R) or known_kernel(posture, q, n):
            continue
        other_posture_kernel(posture, q[n + 1])
        n += 1 if known_kernel(q[n + 1], q, n) else 2
    return n
