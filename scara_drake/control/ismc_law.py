r"""The law of integral sliding mode control, equations (27) to (47) of the paper.

With :math:`e = q_d - q` the law is

.. math::

    \sigma  &= \dot e + c\,e                            \quad (28) \\
    s       &= \sigma - z                               \quad (27) \\
    \dot z  &= -u_2, \quad u_2 = k\,\sigma              \quad (33) \\
    u_1     &= \rho \operatorname{sat}(s / \phi)        \quad (37) \\
    \tau    &= \hat m\,(u_1 + u_2)

with the boundary layer :math:`\phi`, and :math:`\tau` limited to the drive's effort. Equation (30)
makes u an acceleration, so u is multiplied by a constant nominal inertia :math:`\hat m` per joint:
one number, no model of the dynamics. :math:`z(0) = \sigma(0)` starts the motion on the sliding
surface, without a reaching phase (46).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.layout import Rows
from scara_drake.control.controller import limit_effort

Array = NDArray[np.float64]


class Gains(NamedTuple):
    """Gains of the law, each row (n,).

    Attributes:
        c: [1/s].
        k: [1/s].
        rho: [m/s², rad/s²].
        phi: [m/s, rad/s].
        m_hat: [kg, kg m²].
        effort: limit [N, N m].
        clamp: of |s| [m/s, rad/s].
        period: T_s [s], the same for all joints.
    """

    c: Array
    k: Array
    rho: Array
    phi: Array
    m_hat: Array
    effort: Array
    clamp: Array
    period: Array


GAINS = Rows(Gains)
gains_of = GAINS.reader()


@njit(cache=True)
def sliding_surface(
    state_desired: Array, state: Array, c: Array, lead: float, sigma: Array
) -> None:
    """Write sigma = e' + c e (n,), equation (28), from two states (2n,) = (q, v).

    The reference is carried `lead` seconds along its own velocity before the comparison.
    """
    n = sigma.size
    for i in range(n):
        rate = state_desired[n + i]
        error = state_desired[i] + lead * rate - state[i]
        sigma[i] = rate - state[n + i] + c[i] * error


@njit(cache=True)
def ismc_law(
    sigma: Array,
    gains: Array,
    feedforward: Array,
    z: Array,
    s: Array,
    tau: Array,
    tau_limited: Array,
    saturation: Array,
) -> None:
    """Apply the law for one sample, all arrays (n,): write the last four, advance z.

    The forward Euler step of z is exact for the sampled sum. After it, |sigma - z| is clamped by
    moving z: an integral that has wound up no longer delays the recovery.

    Args:
        sigma: equation (28) [m/s, rad/s].
        gains: (8, n), see `Gains`.
        feedforward: effort that is added to the law's [N, N m].
        z: equation (33), in place.
        s: equation (27).
        tau: effort before the limits [N, N m].
        tau_limited: effort within the limits.
        saturation: see `limit_effort`.
    """
    g = gains_of(gains)
    outside = np.empty(sigma.size)
    for i in range(sigma.size):
        s[i] = sigma[i] - z[i]
        outside[i] = abs(s[i]) / g.phi[i]
        u2 = g.k[i] * sigma[i]
        u1 = g.rho[i] * min(max(s[i] / g.phi[i], -1.0), 1.0)
        tau[i] = g.m_hat[i] * (u1 + u2) + feedforward[i]
        z[i] = min(max(z[i] - g.period[i] * u2, sigma[i] - g.clamp[i]), sigma[i] + g.clamp[i])
    limit_effort(tau, g.effort, outside, tau_limited, saturation)
