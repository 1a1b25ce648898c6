r"""The largest gains that a sampled loop bears without chatter.

A torque m_hat g per unit of sigma, held over a period T_s, changes sigma of a single joint by
-T_s g m_hat / M of itself: beyond 2 it overshoots for ever. For the arm the same holds for the
eigenvalues of T_s M(q)^-1 diag(m_hat g). When the effort flips from sample to sample the position
flips with the velocity, by T_s / 2 of it, so sigma = e' + c e counts 1 + c T_s / 2 times. Over all
postures of the robot that is simulated

.. math::

    T_s \, \max_q \lambda_{\max}
    \left( M(q)^{-1} \operatorname{diag}(\hat m\,g\,(1 + c\,T_s / 2)) \right) < 2

where g is the slope of the law, :math:`\rho / \phi + k` for integral sliding mode control. At 1 or
less the loop is well damped, and bears one tick of delay.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scara_drake.robot import RobotModel, chatter_number

Array = NDArray[np.float64]

LIMIT = 2.0
LARGEST_LAYER = 1e6  # [m/s, rad/s], times the layer given


@dataclass(frozen=True)
class Slopes:
    """What the effort of a law does per unit of sigma and of e', all (6,).

    Attributes:
        m_hat: effort per acceleration [kg, kg m²].
        c: slope of the sliding surface [1/s].
        k: slope beside the boundary layer [1/s].
        rho: [m/s², rad/s²].
        phi: boundary layer [m/s, rad/s].
        beside: slope over e' beside that over sigma [1/s].
        unit: that in which the user writes phi [m, rad].
    """

    m_hat: Array
    c: Array
    k: Array
    rho: Array
    phi: Array
    beside: Array | float = 0.0
    unit: Array | float = 1.0

    def gain(self, period: float, factor: float = 1.0) -> Array:
        """Effort per unit of sigma where it flips at each period [s], for `factor` times phi."""
        slope = self.rho / (factor * self.phi) + self.k
        return self.m_hat * (slope * (1.0 + 0.5 * period * self.c) + self.beside)


def smallest_layer(slopes: Slopes, period: float, model: RobotModel | None = None) -> float:
    """Factor by which phi has to be multiplied to meet the rule; infinite if none would do."""

    def breaks(factor: float) -> bool:
        return not chatter_number(slopes.gain(period, factor), period, model) < LIMIT

    if breaks(LARGEST_LAYER):
        return np.inf
    low, high = 1e-6, LARGEST_LAYER
    while high / low > 1.0 + 1e-4:
        middle = np.sqrt(low * high)
        low, high = (middle, high) if breaks(middle) else (low, middle)
    return float(high)


def check_chatter(
    name: str, slopes: Slopes, period: float, model: RobotModel | None = None
) -> None:
    """Accept the gains of a law.

    Args:
        name: of the controller, such as "controller".
        slopes: of the law.
        period: T_s [s].
        model: of the robot; None is the nominal one.

    Raises:
        ValueError: the rule is broken; gives the number and the smallest phi that would do.
    """
    number = chatter_number(slopes.gain(period), period, model)
    if number < LIMIT:
        return
    factor = smallest_layer(slopes, period, model)
    if np.isinf(factor):
        remedy = "no phi would do, lower c, the gains beside phi or the time step"
    else:
        phi = _up(factor * slopes.phi / slopes.unit)
        remedy = f"the smallest phi that would do is [{', '.join(phi)}]"
    raise ValueError(
        f"{name}: chatters, T_s max lambda(M^-1 m_hat (rho / phi + k) (1 + c T_s / 2)) = "
        f"{number:.3g} at T_s = {period:g} s, allowed below 2: {remedy} (or set "
        f"{name}.allow_chatter)"
    )


def _up(values: Array) -> list[str]:
    """Values as text, rounded up to three digits."""
    digits = 10.0 ** (np.floor(np.log10(values)) - 2)
    return [f"{value:.4g}" for value in np.ceil(values / digits) * digits]
