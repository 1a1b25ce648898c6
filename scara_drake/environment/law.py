"""The contact of the tool point with the analytic surfaces, as one kernel on packed rows.

A surface is a signed distance with its gradient, which is the normal n out of it. With the depth d
below it and its rate d' = n . (v_surface - v_tool), it pushes the tool along n with the impedance
of equation (52) of the paper, made unilateral::

    f = max(0, K d + b(d) B d'),   b(d) = min(d / blend, 1),   where d > 0;   else f = 0

or with the law of Hunt and Crossley (1975), whose damping grows with the depth by itself::

    f = K dⁿ max(0, 1 + 3/2 alpha d')

The raw equation (52) steps by B d' at touch and pulls the tool back on a fast retreat. The blend b
lets the damping grow over the first millimetre, so the force starts at zero; the clamp never pulls.
Of either law (f - K dⁿ) d' >= 0, so a surface at rest never gives energy.
"""

from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.kinematics import tool_kinematics_kernel

Array = NDArray[np.float64]

# Kinds of surface, and laws.
WALL, BOX, CYLINDER = 0, 1, 2
IMPEDANCE, HUNT_CROSSLEY, DRAKE = 0, 1, 2
LAWS: Final = {"impedance": IMPEDANCE, "hunt_crossley": HUNT_CROSSLEY, "drake": DRAKE}

# Columns of a row: p_WS (3), R_WS by rows (9), sizes (3), the direction (3) of the motion.
KIND, LAW, POSITION, ROTATION, SIZE, EDGE = 0, 1, 2, 5, 14, 17
STIFFNESS, DAMPING, BLEND, EXPONENT, ALPHA = 18, 19, 20, 21, 22
DIRECTION, SPEED, AMPLITUDE, OMEGA, PHASE, WIDTH = 23, 26, 27, 28, 29, 30


@njit(cache=True)
def surface_distance(surface: Array, p_S: Array, normal_S: Array) -> float:
    """Signed distance [m] of a point (3,) from a surface, both in the surface frame S.

    Writes the unit gradient (3,), the normal out of the surface. Outside, and up to `EDGE` below a
    rounded edge, it is continuous; deeper it jumps where two faces, or all sides of a pipe, are
    equally near.

    Args:
        surface: a row of `Environment.parameters`. A wall is the plane z = 0. A box has half its
            sides in `SIZE`; a cylinder around z has its radius and half its length there. Their
            edges are rounded with the radius in `EDGE`, within the sharp shape.
        p_S: where [m].
        normal_S: receives the gradient.
    """
    if surface[KIND] == WALL:
        normal_S[0] = normal_S[1] = 0.0
        normal_S[2] = 1.0
        return p_S[2]
    edge = surface[EDGE]
    if surface[KIND] == BOX:
        return _rounded(p_S, surface[SIZE : SIZE + 3], edge, normal_S)
    # In the plane through the axis and the point a cylinder is a box.
    across = np.hypot(p_S[0], p_S[1])
    distance = _rounded(np.array([across, p_S[2]]), surface[SIZE : SIZE + 2], edge, normal_S[1:])
    outward = normal_S[1]
    normal_S[0] = outward * p_S[0] / across if across > 0.0 else outward
    normal_S[1] = outward * p_S[1] / across if across > 0.0 else 0.0
    return distance


@njit(cache=True)
def _rounded(p: Array, half: Array, edge: float, gradient: Array) -> float:
    """Signed distance of p (n,) from the box |p_k| <= half_k with rounded edges; see above."""
    outside, nearest, face = 0.0, -np.inf, 0
    for k in range(half.size):
        beyond = abs(p[k]) - (half[k] - edge)  # of the core, which the rounding surrounds
        outside += max(beyond, 0.0) ** 2
        if beyond > nearest:
            nearest, face = beyond, k
    if outside == 0.0:
        gradient[: half.size] = 0.0
        gradient[face] = 1.0 if p[face] >= 0.0 else -1.0
        return nearest - edge
    length = np.sqrt(outside)
    for k in range(half.size):
        beyond = max(abs(p[k]) - (half[k] - edge), 0.0)
        gradient[k] = (beyond if p[k] >= 0.0 else -beyond) / length
    return length - edge


@njit(cache=True)
def normal_force(surface: Array, depth: float, rate: float) -> float:
    """Force [N] of a surface at a depth [m] that grows with a rate [m/s]."""
    if depth <= 0.0:
        return 0.0
    if surface[LAW] == HUNT_CROSSLEY:
        spring = surface[STIFFNESS] * depth ** surface[EXPONENT]
        return spring * max(1.0 + 1.5 * surface[ALPHA] * rate, 0.0)
    damping = surface[DAMPING] * min(depth / surface[BLEND], 1.0)
    return max(surface[STIFFNESS] * depth + damping * rate, 0.0)


@njit(cache=True)
def contact_force(
    time: float, p_WE: Array, v_WE: Array, surfaces: Array, penetration: Array, f_W: Array
) -> None:
    """Write the penetrations (n,) [m] and the force (3,) [N] on a point (3,) moving at v (3,).

    The forces of several surfaces add up. A surface whose law is Drake's counts for nothing here.

    Args:
        time: for the surfaces that move [s].
        p_WE: the point [m].
        v_WE: its velocity [m/s].
        surfaces: `Environment.parameters` (n, WIDTH).
        penetration: receives the depths, zero outside.
        f_W: receives the force.
    """
    f_W[:] = 0.0
    p_S, normal_S, normal_W = np.empty(3), np.empty(3), np.empty(3)
    for i in range(surfaces.shape[0]):
        surface = surfaces[i]
        penetration[i] = 0.0
        if surface[LAW] == DRAKE:
            continue
        angle = surface[OMEGA] * time + surface[PHASE]
        offset = surface[SPEED] * time + surface[AMPLITUDE] * np.sin(angle)
        speed = surface[SPEED] + surface[AMPLITUDE] * surface[OMEGA] * np.cos(angle)
        p_S[:] = 0.0
        for k in range(3):
            along = p_WE[k] - surface[POSITION + k] - offset * surface[DIRECTION + k]
            for j in range(3):
                p_S[j] += surface[ROTATION + 3 * k + j] * along
        depth = -surface_distance(surface, p_S, normal_S)
        if depth <= 0.0:
            continue
        rate = 0.0
        for k in range(3):
            normal_W[k] = 0.0
            for j in range(3):
                normal_W[k] += surface[ROTATION + 3 * k + j] * normal_S[j]
            rate += normal_W[k] * (speed * surface[DIRECTION + k] - v_WE[k])
        force = normal_force(surface, depth, rate)
        penetration[i] = depth
        for k in range(3):
            f_W[k] += force * normal_W[k]


@njit(cache=True)
def tool_contact(
    time: float,
    state: Array,
    surfaces: Array,
    penetration: Array,
    f_W: Array,
    generalized_force: Array,
) -> None:
    """Write the contact of the tool point of a robot state (12,), and J_vᵀ f (6,) [N, N m]."""
    p, v, R, J = np.empty(3), np.zeros(3), np.empty((3, 3)), np.empty((6, 6))
    tool_kinematics_kernel(state[:6], p, R, J)
    for i in range(3):
        for j in range(6):
            v[i] += J[3 + i, j] * state[6 + j]
    contact_force(time, p, v, surfaces, penetration, f_W)
    for j in range(6):
        generalized_force[j] = J[3, j] * f_W[0] + J[4, j] * f_W[1] + J[5, j] * f_W[2]
