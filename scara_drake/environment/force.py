"""The force of the surfaces on a point, and on the joints of the robot whose tool it is."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.scratch import scratch
from scara_drake.environment.law import DRAKE, course_at, force_by, surface_of
from scara_drake.environment.surfaces import surface_distance
from scara_drake.kinematics import tool_kinematics_kernel

Array = NDArray[np.float64]


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
        surfaces: `Environment.parameters`.
        penetration: receives the depths, zero outside.
        f_W: receives the force.
    """
    f_W[:] = 0.0
    p_S, normal_S, normal_W = scratch(3), scratch(3), scratch(3)
    for i in range(surfaces.shape[0]):
        s = surface_of(surfaces[i])
        penetration[i] = 0.0
        if s.law == DRAKE:
            continue
        offset, speed = course_at(s, time)
        p_S[:] = 0.0
        for k in range(3):
            along = p_WE[k] - s.p_WS[k] - offset * s.direction[k]
            for j in range(3):
                p_S[j] += s.R_WS[k, j] * along
        depth = -surface_distance(surfaces[i], p_S, normal_S)
        if depth <= 0.0:
            continue
        rate = 0.0
        for k in range(3):
            normal_W[k] = 0.0
            for j in range(3):
                normal_W[k] += s.R_WS[k, j] * normal_S[j]
            rate += normal_W[k] * (speed * s.direction[k] - v_WE[k])
        force = force_by(s.law, s, depth, rate)
        penetration[i] = depth
        for k in range(3):
            f_W[k] += force * normal_W[k]


@njit(cache=True)
def tool_contact(
    t: float,
    state: Array,
    surfaces: Array,
    penetration: Array,
    f_env_on_tool_W: Array,
    generalized_force: Array,
) -> None:
    """Write the contact of the tool point of a robot state (12,), and J_vᵀ f (6,) [N, N m]."""
    p, v, R, J = scratch(3), scratch(3), scratch(3, 3), scratch(6, 6)
    tool_kinematics_kernel(state[:6], p, R, J)
    for i in range(3):
        v[i] = 0.0
        for j in range(6):
            v[i] += J[3 + i, j] * state[6 + j]
    f = f_env_on_tool_W
    contact_force(t, p, v, surfaces, penetration, f)
    for j in range(6):
        generalized_force[j] = J[3, j] * f[0] + J[4, j] * f[1] + J[5, j] * f[2]


@njit(cache=True)
def tool_contact_next(
    t: float,
    period: float,
    state: Array,
    surfaces: Array,
    penetration: Array,
    f_env_on_tool_W: Array,
    generalized_force: Array,
) -> None:
    """`tool_contact` with the surfaces where they are a period [s] later."""
    tool_contact(t + period, state, surfaces, penetration, f_env_on_tool_W, generalized_force)
