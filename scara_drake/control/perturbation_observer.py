r"""Sliding perturbation observer of joints whose positions alone are measured.

The plant of a joint is x1' = x2, x2' = u + Psi with u = tau / m_hat: what the nominal inertia does
not explain is the perturbation Psi [m/s², rad/s²]. With the error x~1 = x1 - x1^ the observer of
Moura, Elmali and Olgac (1997) is, after its third state is replaced by the estimate of Psi,

.. math::

    \dot{\hat x}_1  &= \hat x_2 + k_1 \operatorname{sat}(\tilde x_1 / \varepsilon) \\
    \dot{\hat x}_2  &= u + \hat\Psi + k_2 \operatorname{sat}(\tilde x_1 / \varepsilon) \\
    \dot{\hat\Psi}  &= a_3^2\,k_2 \operatorname{sat}(\tilde x_1 / \varepsilon)

Within the layer :math:`\varepsilon` its error obeys :math:`\lambda^3 + (k_1 / \varepsilon)\lambda^2
+ (k_2 / \varepsilon)\lambda + a_3^2 k_2 / \varepsilon = 0`. A triple pole at -p asks for :math:`k_1
= 3 p \varepsilon`, :math:`k_2 = p\,k_1`, :math:`a_3 = \sqrt{p / 3}`: there it is a linear extended
state observer of bandwidth p. Outside the layer the correction is bounded: a wild sample moves the
estimates no further than an error of eps does.

Here it is sampled. The effort is held between samples, so the step from one to the next is the
exact zero-order-hold solution of the plant, for a constant Psi. Each measured position then
corrects it with the gains that put the poles of the sampled error at exp(-p T_s), those of the
continuous observer (Miklosovic, Radke and Gao, 2006), with :math:`b = e^{-p T_s}`

.. math::

    1 - b^3, \quad \frac{3}{2} (1 - b)^2 (1 + b) / T_s, \quad (1 - b)^3 / T_s^2

So it is stable at every period, and of a constant perturbation it has no error in the end. A
perturbation that grows by r per second is seen 3 r / p late. The noise of Psi^ grows with p³.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from scara_drake.common.layout import Rows

Array = NDArray[np.float64]


class ObserverGains(NamedTuple):
    """What an error in the position corrects, each row (n,).

    Attributes:
        position: [1].
        velocity: [1/s].
        perturbation: [1/s²].
        eps: layer [m, rad].
    """

    position: Array
    velocity: Array
    perturbation: Array
    eps: Array


OBSERVER_GAINS = Rows(ObserverGains)
observer_gains_of = OBSERVER_GAINS.reader()


def observer_gains(pole: ArrayLike, eps: ArrayLike, period: float) -> Array:
    """Return the gains (4, n) of `observer_step` for a triple pole per joint.

    Args:
        pole: p (n,), the bandwidth [1/s].
        eps: layer (n,) [m, rad].
        period: T_s [s].
    """
    decay = np.exp(-period * np.asarray(pole, dtype=np.float64))
    # -expm1 is 1 - b without the loss of digits where p T_s is small.
    step = -np.expm1(-period * np.asarray(pole, dtype=np.float64))
    return OBSERVER_GAINS.pack(
        position=step * (1.0 + decay + decay**2),
        velocity=1.5 * step**2 * (1.0 + decay) / period,
        perturbation=step**3 / period**2,
        eps=eps,
    )


@njit(cache=True)
def observer_step(
    position: Array, u: Array, gains: Array, period: float, x1: Array, x2: Array, psi: Array
) -> None:
    """Advance the estimates by one period, in place; all arrays (n,) but the gains.

    Args:
        position: measured at the end of the period [m, rad].
        u: effort over m_hat, held during the period [m/s², rad/s²].
        gains: (4, n), see `observer_gains`.
        period: T_s [s].
        x1: estimate of the position [m, rad].
        x2: of the velocity [m/s, rad/s].
        psi: of the perturbation [m/s², rad/s²].
    """
    g = observer_gains_of(gains)
    for i in range(psi.size):
        acceleration = u[i] + psi[i]
        predicted = x1[i] + period * (x2[i] + 0.5 * period * acceleration)
        error = min(max(position[i] - predicted, -g.eps[i]), g.eps[i])  # eps sat(x~1/eps)
        x1[i] = predicted + g.position[i] * error
        x2[i] += period * acceleration + g.velocity[i] * error
        psi[i] += g.perturbation[i] * error


@njit(cache=True)
def lag_step(u: Array, gains: Array, period: float, x1: Array, x2: Array, lagged: Array) -> None:
    """Advance F(u) by one period, in place, where F is the lag of Psi^ = F(Psi); all arrays (n,).

    Of a joint that is held at rest by the effort -u the observer says that the perturbation is
    F(u). So F(u) + Psi^ = F(u + Psi): an effort as old as Psi^, to compare with it.

    Args:
        u: held during the period, in any unit.
        gains: (4, n), see `observer_gains`; there is no layer here.
        period: T_s [s].
        x1: memory.
        x2: memory.
        lagged: F(u).
    """
    g = observer_gains_of(gains)
    for i in range(u.size):
        change = lagged[i] - u[i]
        predicted = x1[i] + period * (x2[i] + 0.5 * period * change)
        x1[i] = predicted - g.position[i] * predicted
        x2[i] += period * change - g.velocity[i] * predicted
        lagged[i] -= g.perturbation[i] * predicted
