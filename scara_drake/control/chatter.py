"""The largest gains that a sampled loop bears without chatter.

A torque m_hat g per unit of sigma, held over a period T_s, changes sigma of a single joint by
-T_s g m_hat / M of itself: beyond 2 it overshoots for ever. For the arm the same holds for the
eigenvalues of T_s M(q)^-1 diag(m_hat g), so over all postures::

    T_s max_q lambda_max( M(q)^-1 diag(m_hat g) ) < 2

where g is the slope of the law, rho / phi + k for integral sliding mode control. At 1 or less the
loop is well damped, and bears one tick of delay.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scara_drake.robot import chatter_number

Array = NDArray[np.float64]

LIMIT = 2.0
LARGEST_LAYER = 1e6  # [m/s, rad/s], times the layer given


def smallest_layer(m_hat: Array, k: Array, rho: Array, phi: Array, period: float) -> float:
    """Factor by which phi (6,) has to be multiplied to meet the rule; infinite if none would do."""

    def breaks(factor: float) -> bool:
        return chatter_number(m_hat * (rho / (factor * phi) + k), period) >= LIMIT

    if breaks(LARGEST_LAYER):
        return np.inf
    low, high = 1e-6, LARGEST_LAYER
    while high / low > 1.0 + 1e-4:
        middle = np.sqrt(low * high)
        low, high = (middle, high) if breaks(middle) else (low, middle)
    return float(high)


def check_chatter(
    name: str,
    m_hat: Array,
    k: Array,
    rho: Array,
    phi: Array,
    period: float,
    unit: Array | float = 1.0,
) -> None:
    """Accept the gains of a law with the slope rho / phi + k, all (6,).

    Args:
        name: of the controller, such as "controller".
        m_hat: effort per acceleration [kg, kg m²].
        k: slope beside the boundary layer [1/s].
        rho: [m/s², rad/s²].
        phi: boundary layer [m/s, rad/s].
        period: T_s [s].
        unit: that in which the user writes phi (6,) [m, rad].

    Raises:
        ValueError: the rule is broken; gives the number and the smallest phi that would do.
    """
    number = chatter_number(m_hat * (rho / phi + k), period)
    if number < LIMIT:
        return
    factor = smallest_layer(m_hat, k, rho, phi, period)
    if np.isinf(factor):
        remedy = "no phi would do, lower the gains beside it or the time step"
    else:
        remedy = f"the smallest phi that would do is [{', '.join(_up(factor * phi / unit))}]"
    raise ValueError(
        f"{name}: chatters, T_s max lambda(M^-1 m_hat (rho / phi + k)) = {number:.3g} at "
        f"T_s = {period:g} s, allowed below 2: {remedy} (or set {name}.allow_chatter)"
    )


def _up(values: Array) -> list[str]:
    """Values as text, rounded up to three digits."""
    digits = 10.0 ** (np.floor(np.log10(values)) - 2)
    return [f"{value:.4g}" for value in np.ceil(values / digits) * digits]
