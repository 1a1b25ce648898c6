"""Closed form of the arm and its mast together: one trigonometric polynomial in θ2.

With u = -a (a the tool axis), w the wrist centre, and in the frame Rz(θ2)
X = u_x cos θ2 + u_y sin θ2, W = w_x cos θ2 + w_y sin θ2, Y = w_y cos θ2 - w_x sin θ2, the two
conditions of the arm (see `closed_form_arm`) are met for some d1 and θ3 where

    X² (w_x² + w_y² + d3² - a4² - 2 d3 Y) + u_z² W² = 0,

of degree three: up to six θ2, and for each two postures.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.ik.kernels.closed_form_arm import (
    VERTICAL,
    known_kernel,
    make_exact_kernel,
    other_posture_kernel,
    tool_angles_kernel,
)
from scara_drake.ik.kernels.postures import wrap_kernel
from scara_drake.ik.kernels.trigonometric import MAX_ROOTS, evaluate_kernel, roots_kernel
from scara_drake.kinematics import A4, D3, D6

Array = NDArray[np.float64]

# Below this the direction (X, -u_z), which gives θ3, is lost [1]; likewise the forearm across the
# beam [m].
LOST_DIRECTION = 1e-5
LOST_FOREARM = 1e-6
# A forearm nearer to the plane of mast and beam [m] leaves the sign of cos θ4 open.
OPEN_SIGN = 1e-5
# A multiple root is blurred this far [rad], and the polynomial there is zero within this share of
# its amplitudes.
BLUR = 1e-3
SNAP = 1e-9


class Wrist(NamedTuple):
    """A target.

    Attributes:
        u: opposite of the tool axis (3,).
        w: wrist centre (3,) [m].
        p_WE: tool position (3,) [m].
        R_WE: tool rotation (3, 3).
        p: work space (3,).
        R: work space (3, 3).
    """

    u: Array
    w: Array
    p_WE: Array
    R_WE: Array
    p: Array
    R: Array


@njit(cache=True)
def mast_polynomial_kernel(u: Array, w: Array, c: Array) -> None:
    """Write the coefficients (7,) of the polynomial in θ2; u and w (3,) as in the module."""
    level, radius = u[0] * u[0] + u[1] * u[1], w[0] * w[0] + w[1] * w[1]
    constant, rise = radius + D3 * D3 - A4 * A4, u[2] * u[2]
    # X² = level / 2 + cx cos 2θ2 + sx sin 2θ2, and W² alike.
    cx, sx = 0.5 * (u[0] * u[0] - u[1] * u[1]), u[0] * u[1]
    cw, sw = 0.5 * (w[0] * w[0] - w[1] * w[1]), w[0] * w[1]
    c[0] = 0.5 * (constant * level + rise * radius)
    c[1] = -D3 * (level * w[1] + cx * w[1] - sx * w[0])
    c[2] = D3 * (level * w[0] - cx * w[0] - sx * w[1])
    c[3] = constant * cx + rise * cw
    c[4] = constant * sx + rise * sw
    c[5] = -D3 * (cx * w[1] + sx * w[0])
    c[6] = D3 * (cx * w[0] - sx * w[1])


@njit(cache=True)
def _postures_at(theta2: float, target: Wrist, q: Array, n: int) -> int:
    """Append the solutions with this θ2 to the n in q; return their new number."""
    u, w, p_WE, R_WE, p, R = target
    c2, s2 = np.cos(theta2), np.sin(theta2)
    tool_x = u[0] * c2 + u[1] * s2
    across, along = w[0] * c2 + w[1] * s2, w[1] * c2 - w[0] * s2
    s4 = min(max((along - D3) / A4, -1.0), 1.0)
    forearm = A4 * np.sqrt((1.0 - s4) * (1.0 + s4))
    normal = np.sqrt(tool_x * tool_x + u[2] * u[2])
    # cos θ4 >= 0 here; the mirrored postures have the other sign.
    for sign in (1.0, -1.0):
        if n + 1 >= q.shape[0]:
            return n
        posture = q[n]
        if normal > LOST_DIRECTION or (forearm <= LOST_FOREARM and normal > VERTICAL):
            c3, s3 = sign * tool_x / normal, -sign * u[2] / normal
            if across * c3 < 0.0 and abs(across * c3) > OPEN_SIGN:
                continue
        elif forearm > LOST_FOREARM:
            c3 = across / forearm
            if abs(c3) > 1.0 + OPEN_SIGN:
                continue
            c3 = min(max(c3, -1.0), 1.0)
            s3 = sign * np.sqrt(1.0 - c3 * c3)
        else:
            c3, s3 = sign, 0.0
        posture[0] = w[2] + forearm * s3
        posture[1], posture[2] = wrap_kernel(theta2), wrap_kernel(np.arctan2(s3, c3))
        posture[3] = np.arctan2(A4 * s4, forearm)
        tool_angles_kernel(R_WE, c2, s2, c3, s3, posture)
        if not make_exact_kernel(posture, p_WE, R_WE, 0, p, R) or known_kernel(posture, q, n):
            continue
        other_posture_kernel(posture, q[n + 1])
        n += 1 if known_kernel(q[n + 1], q, n) else 2
    return n


@njit(cache=True)
def mast_branches_kernel(p_WE: Array, R_WE: Array, q: Array) -> int:
    """Write every solution q (24, 6) of arm and mast, exact within 1e-9, limits not applied.

    In general there are 4, 8 or 12 (0 where the pose is out of reach), angles within (-pi, pi].
    Where two solutions meet (a singular posture, such as θ4 = ±pi/2) they are listed once.

    Two families of poses have a continuum of solutions. With the arm straight and the tool along
    the beam, θ3 turns against θ6: its members with θ3 = 0 and pi are listed. With wrist and tool on
    the axis of the mast, θ2 turns against θ6: its members with θ2 = 0 are listed.

    Args:
        p_WE: tool position (3,) [m].
        R_WE: tool rotation (3, 3).
        q: solutions (24, 6).

    Returns:
        The number of solutions.
    """
    u, w, c = np.empty(3), np.empty(3), np.empty(7)
    roots, multiple = np.empty(MAX_ROOTS), np.empty(MAX_ROOTS)
    target = Wrist(u, w, p_WE, R_WE, np.empty(3), np.empty((3, 3)))
    for i in range(3):
        u[i] = -R_WE[i, 2]
        w[i] = p_WE[i] + D6 * u[i]
    mast_polynomial_kernel(u, w, c)
    if max(abs(u[0]), abs(u[1]), abs(w[0]), abs(w[1])) < VERTICAL:
        c[:] = 0.0
    scale = 0.0
    for k in range(7):
        scale += abs(c[k])
    n = 0
    for k in range(roots_kernel(c, roots, multiple)):
        before = n
        if multiple[k] > 0.0 and scale > 0.0:
            # Most multiple roots are at X = 0 or W = 0, which is known to the last digit.
            for i in range(4):
                v = u if i < 2 else w
                exact = np.arctan2(-v[0], v[1]) + (i % 2) * np.pi
                f, _, _ = evaluate_kernel(c, exact)
                if abs(wrap_kernel(exact - roots[k])) < BLUR and abs(f) < SNAP * scale:
                    n = _postures_at(exact, target, q, n)
        if n == before:
            n = _postures_at(roots[k], target, q, n)
    return n
