"""The step of a serial arm of six joints, as a kernel.

What Drake's discrete plant does without contact and within the joint limits::

    (M(q) + h D) v⁺ = M(q) v + h (tau - c(q, v)),   q⁺ = q + h v⁺

M by composite rigid bodies and c by recursive Newton-Euler (Featherstone, 2008, chapters 5 and 6),
the reflected inertias of the drives on the diagonal of M, damping implicit. All spatial quantities
are in W about its origin, angular before linear, so nothing is shifted from link to link.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.layout import Cell, Layout
from scara_drake.dynamics.spatial import (
    cross,
    dot,
    momentum,
    plus,
    rotated,
    row_of,
    times,
    vector,
)

Array = NDArray[np.float64]

JOINTS = 6
# Where a joint may be two periods later at its present speed, the plant adds limit forces.
LIMIT_WINDOW = 2.0


class Arm(NamedTuple):
    """A serial arm, and the step that is taken with it.

    Attributes:
        slides: (6,), 1 where a joint slides along its z axis, 0 where it turns about it.
        R_PJ: frame of joint i in the link before it (6, 3, 3).
        p_PJ: its origin there (6, 3) [m].
        mass: of the links, with what is welded to them (6,) [kg].
        p_com: their centres of mass, in the links (6, 3) [m].
        inertia: about these centres, in the links (6, 3, 3) [kg m²].
        armature: reflected inertia of the drives (6,) [kg, kg m²].
        damping: of the joints (6,) [N s/m, N m s/rad].
        effort: limits of the drives (6,) [N, N m].
        lower: limits of the joints (6,) [m, rad].
        upper: limits of the joints (6,) [m, rad].
        gravity: in W (3,) [m/s²].
        period: h [s].
    """

    slides: Array
    R_PJ: Array
    p_PJ: Array
    mass: Array
    p_com: Array
    inertia: Array
    armature: Array
    damping: Array
    effort: Array
    lower: Array
    upper: Array
    gravity: Array
    period: float


class Work(NamedTuple):
    """What a step works out on its way.

    Attributes:
        R_WL: orientations of the links at the start of the step (6, 3, 3).
        p_WL: their origins (6, 3) [m].
        axis: spatial axes of the joints (6, 6).
        composite: spatial inertias (6, 10): mass, mass times centre, inertia xx yy zz xy xz yz.
        force: spatial forces (6, 6) on the links and all that follow.
        M: mass matrix (6, 6), then its Cholesky factor with the damping.
        bias: c (6,) [N, N m].
        effort: of the drives and of all else on the joints (6,) [N, N m].
        right: right side of the step's equation, then the new velocities (6,).
        beyond: number of the joint that is at its limit, from 1; 0 for none.
    """

    R_WL: Array
    p_WL: Array
    axis: Array
    composite: Array
    force: Array
    M: Array
    bias: Array
    effort: Array
    right: Array
    beyond: Cell


ARM = Layout(
    Arm,
    slides=6,
    R_PJ=(6, 3, 3),
    p_PJ=(6, 3),
    mass=6,
    p_com=(6, 3),
    inertia=(6, 3, 3),
    armature=6,
    damping=6,
    effort=6,
    lower=6,
    upper=6,
    gravity=3,
)
WORK = Layout(
    Work,
    R_WL=(6, 3, 3),
    p_WL=(6, 3),
    axis=(6, 6),
    composite=(6, 10),
    force=(6, 6),
    M=(6, 6),
    bias=6,
    effort=6,
    right=6,
    beyond=(),
)
arm_of, work_of = ARM.reader(), WORK.reader()


@njit(cache=True, error_model="numpy")
def place_links(q: Array, a: Arm, w: Work) -> None:
    """Write the poses of the links and the spatial axes of the joints at q (6,)."""
    x, y, z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    p = (0.0, 0.0, 0.0)
    R, axis = w.R_WL, w.axis
    for i in range(JOINTS):
        # Columns of R_WJ and the origin of the joint, from the link before.
        p_PJ = vector(a.p_PJ, i, 0)
        x, y, z = (
            rotated(a.R_PJ, i, (1.0, 0.0, 0.0)),
            rotated(a.R_PJ, i, (0.0, 1.0, 0.0)),
            rotated(a.R_PJ, i, (0.0, 0.0, 1.0)),
        )
        if i > 0:
            p = plus(p, rotated(R, i - 1, p_PJ))
            x, y, z = rotated(R, i - 1, x), rotated(R, i - 1, y), rotated(R, i - 1, z)
        else:
            p = p_PJ
        if a.slides[i] > 0.0:
            p = plus(p, times(q[i], z))
            turn, shift = (0.0, 0.0, 0.0), z
        else:
            c, s = math.cos(q[i]), math.sin(q[i])
            x, y = plus(times(c, x), times(s, y)), plus(times(c, y), times(-s, x))
            turn, shift = z, cross(p, z)
        for k in range(3):
            R[i, k, 0], R[i, k, 1], R[i, k, 2] = x[k], y[k], z[k]
            w.p_WL[i, k] = p[k]
            axis[i, k], axis[i, 3 + k] = turn[k], shift[k]


@njit(cache=True, error_model="numpy")
def place_inertia(i: int, a: Arm, w: Work) -> None:
    """Write the spatial inertia of link i alone, once its pose is known."""
    mass, R, row = a.mass[i], w.R_WL, w.composite
    x, y, z = plus(vector(w.p_WL, i, 0), rotated(R, i, vector(a.p_com, i, 0)))
    # I_W = R I Rᵀ, by its rows.
    first, second, third = row_of(R, i, 0), row_of(R, i, 1), row_of(R, i, 2)
    turned_second, turned_third = rotated(a.inertia, i, second), rotated(a.inertia, i, third)
    row[i, 0] = mass
    row[i, 1], row[i, 2], row[i, 3] = mass * x, mass * y, mass * z
    row[i, 4] = dot(first, rotated(a.inertia, i, first)) + mass * (y * y + z * z)
    row[i, 5] = dot(second, turned_second) + mass * (x * x + z * z)
    row[i, 6] = dot(third, turned_third) + mass * (x * x + y * y)
    row[i, 7] = dot(first, turned_second) - mass * x * y
    row[i, 8] = dot(first, turned_third) - mass * x * z
    row[i, 9] = dot(second, turned_third) - mass * y * z


@njit(cache=True, error_model="numpy")
def link_forces(v: Array, a: Arm, k: Work) -> None:
    """Write the spatial forces that keep each link on its course without joint accelerations."""
    w, v_O, alpha = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    # Gravity as an acceleration of the base.
    a_O = (-a.gravity[0], -a.gravity[1], -a.gravity[2])
    for i in range(JOINTS):
        place_inertia(i, a, k)
        turn, shift = times(v[i], vector(k.axis, i, 0)), times(v[i], vector(k.axis, i, 3))
        alpha = plus(alpha, cross(w, turn))
        a_O = plus(a_O, plus(cross(w, shift), cross(v_O, turn)))
        w, v_O = plus(w, turn), plus(v_O, shift)
        h, p = momentum(k.composite, i, w, v_O)
        moment, force = momentum(k.composite, i, alpha, a_O)
        moment = plus(moment, plus(cross(w, h), cross(v_O, p)))
        force = plus(force, cross(w, p))
        for x in range(3):
            k.force[i, x], k.force[i, 3 + x] = moment[x], force[x]


@njit(cache=True, error_model="numpy")
def mass_matrix_and_bias(a: Arm, k: Work) -> None:
    """Write M with the armatures, and c, from the tip of the arm to its base."""
    for i in range(JOINTS - 1, -1, -1):
        if i < JOINTS - 1:
            for entry in range(k.composite.shape[1]):
                k.composite[i, entry] += k.composite[i + 1, entry]
            for entry in range(k.force.shape[1]):
                k.force[i, entry] += k.force[i + 1, entry]
        turn, shift = vector(k.axis, i, 0), vector(k.axis, i, 3)
        k.bias[i] = dot(turn, vector(k.force, i, 0)) + dot(shift, vector(k.force, i, 3))
        moment, force = momentum(k.composite, i, turn, shift)
        for j in range(i + 1):
            k.M[i, j] = dot(vector(k.axis, j, 0), moment) + dot(vector(k.axis, j, 3), force)
            k.M[j, i] = k.M[i, j]
        k.M[i, i] += a.armature[i]


@njit(cache=True, error_model="numpy")
def solve(right: Array, L: Array) -> None:
    """Solve L x = right in place; Cholesky's factor takes the place of the lower half of L."""
    for i in range(JOINTS):
        for j in range(i + 1):
            rest = L[i, j]
            for k in range(j):
                rest -= L[i, k] * L[j, k]
            L[i, j] = math.sqrt(rest) if i == j else rest / L[j, j]
    for i in range(JOINTS):
        for k in range(i):
            right[i] -= L[i, k] * right[k]
        right[i] /= L[i, i]
    for i in range(JOINTS - 1, -1, -1):
        for k in range(i + 1, JOINTS):
            right[i] -= L[k, i] * right[k]
        right[i] /= L[i, i]


@njit(cache=True, error_model="numpy")
def first_joint_at_limit(q: Array, v: Array, v_next: Array, a: Arm) -> int:
    """Number, from 1, of a joint on which the plant would put a limit force; 0 for none.

    Drake does so where a joint may be beyond its limit within the window, at the faster of the
    velocity that it has and that which it would get without the force.
    """
    for i in range(JOINTS):
        speed = abs(v_next[i])  # NaN stays, and is at no place within the limits
        if abs(v[i]) > speed:
            speed = abs(v[i])
        ahead = LIMIT_WINDOW * a.period * speed
        if not (a.lower[i] < q[i] - ahead and q[i] + ahead < a.upper[i]):
            return i + 1
    return 0


@njit(cache=True, error_model="numpy")
def set_efforts(actuation: Array, force: Array, arm: Array, work: Array) -> None:
    """Set what moves the joints over the next period.

    Args:
        actuation: efforts asked of the drives (6,) [N, N m]; their limits are kept here.
        force: other generalized forces (6,) [N, N m].
        arm: see `Arm`.
        work: see `Work`.
    """
    a, k = arm_of(arm), work_of(work)
    for i in range(JOINTS):
        k.effort[i] = min(max(actuation[i], -a.effort[i]), a.effort[i]) + force[i]


@njit(cache=True, error_model="numpy")
def plant_step(arm: Array, work: Array, state: Array) -> bool:
    """Advance the state (12,) = q, v of the arm by one period, in place.

    Returns whether all joints were within their limits; where one was not, nothing is done.
    """
    a, k = arm_of(arm), work_of(work)
    q, v = state[:JOINTS], state[JOINTS:]
    place_links(q, a, k)
    link_forces(v, a, k)
    mass_matrix_and_bias(a, k)
    h, right = a.period, k.right
    for i in range(JOINTS):
        right[i] = h * (k.effort[i] - k.bias[i])
        for j in range(JOINTS):
            right[i] += k.M[i, j] * v[j]
    for i in range(JOINTS):
        k.M[i, i] += h * a.damping[i]
    solve(right, k.M)
    k.beyond[()] = first_joint_at_limit(q, v, right, a)
    if k.beyond[()] > 0.0:
        return False
    for i in range(JOINTS):
        v[i] = right[i]
        q[i] += h * right[i]
    return True
