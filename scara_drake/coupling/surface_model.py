r"""Model of a surface on one axis: fitted from what is felt, and rendered without a step of force.

Equation (52), f = K (x - x_e) + B v, is fitted by recursive least squares with forgetting (Xu et
al., 2016)

.. math::

    \theta \leftarrow \theta + \frac{P \varphi\,(f - \varphi^\top \theta)}
    {\lambda + \varphi^\top P \varphi}, \quad \varphi = (x, v, 1)
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.layout import Cell, Layout

Array = NDArray[np.float64]

# Units of the regressors, which make the three parameters alike: mm, dm/s, and 1.
UNITS = (1e-3, 0.1, 1.0)
FIRST_COVARIANCE, LARGEST_COVARIANCE = 1e3, 1e6
ENOUGH = 40.0  # samples, before a model is sent


class Model(NamedTuple):
    """Model of a surface, on one axis.

    Attributes:
        stiffness: K [N/m].
        damping: B [N s/m].
        x: where the surface begins [m].
        side: 1 or -1 where the surface resists motion in that direction, 0 without a model.
    """

    stiffness: Cell
    damping: Cell
    x: Cell
    side: Cell


class Fit(NamedTuple):
    """Memory of a fit, on one axis.

    Attributes:
        origin: of the position, where the fit began [m].
        samples: how many there were.
        theta: parameters (3,), in `UNITS`.
        P: their covariance (3, 3).
    """

    origin: Cell
    samples: Cell
    theta: Array
    P: Array


MODEL = Layout(Model, stiffness=(), damping=(), x=(), side=())
FIT = Layout(Fit, origin=(), samples=(), theta=3, P=(3, 3))
model_of, fit_of = MODEL.reader(), FIT.reader()


@njit(cache=True)
def fit_surface(x: float, v: float, f: float, forgetting: float, fit: Array) -> None:
    """One step of recursive least squares of f = K (x - x_e) + B v, in place.

    Args:
        x: [m].
        v: [m/s].
        f: [N].
        forgetting: lambda; 1 while the covariance is at its bound, so that it cannot blow up.
        fit: (14,), see `Fit`; zero at first.
    """
    m = fit_of(fit)
    theta, P = m.theta, m.P
    if m.samples[()] == 0.0:
        m.origin[()] = x
        for i in range(3):
            P[i, i] = FIRST_COVARIANCE
    m.samples[()] += 1.0
    phi = np.empty(3)
    phi[0], phi[1], phi[2] = (x - m.origin[()]) / UNITS[0], v / UNITS[1], 1.0
    gain = np.zeros(3)
    for i in range(3):
        for j in range(3):
            gain[i] += P[i, j] * phi[j]
    if P[0, 0] + P[1, 1] + P[2, 2] > LARGEST_COVARIANCE:
        forgetting = 1.0
    scale = forgetting
    error = f
    for i in range(3):
        scale += phi[i] * gain[i]
        error -= phi[i] * theta[i]
    for i in range(3):
        theta[i] += gain[i] * error / scale
        for j in range(3):
            P[i, j] = (P[i, j] - gain[i] * gain[j] / scale) / forgetting


@njit(cache=True)
def read_surface(fit: Array, f: float, model: Array) -> None:
    """Write the model (4,) of a fit, if it is one; the force [N] tells the side."""
    m, seen = fit_of(fit), model_of(model)
    stiffness = m.theta[0] / UNITS[0]
    if m.samples[()] < ENOUGH or not stiffness > 0.0:
        return
    seen.stiffness[()] = stiffness
    seen.damping[()] = max(m.theta[1] / UNITS[1], 0.0)
    seen.x[()] = m.origin[()] - m.theta[2] / stiffness
    seen.side[()] = math.copysign(1.0, f)


@njit(cache=True)
def render(
    model: Array,
    x: float,
    v: float,
    rest: float,
    period: float,
    largest: float,
    power: float,
    most_damping: float = math.inf,
) -> tuple[float, float]:
    """Return the force [N] of a model (4,) and the rest position [m] from which it is rendered.

    The rest position is that of the model, or nearer to the hand where its spring would otherwise
    hold more energy than before plus `power` times the period. Stiffness and damping are bounded,
    by `largest` and `most_damping`, but the damping is at least what a spring needs that is
    sampled, and shown one to two periods late (Colgate).
    """
    m = model_of(model)
    side, surface = m.side[()], m.x[()]
    if side == 0.0:
        return 0.0, x
    stiffness = min(m.stiffness[()], largest)
    held = max(side * (x - rest), 0.0)
    depth = side * (x - surface)
    if depth <= 0.0:
        return 0.0, surface
    depth = min(depth, math.sqrt(held * held + 2.0 * power * period / stiffness))
    damping = max(min(m.damping[()], most_damping), 2.5 * period * stiffness)
    return side * max(stiffness * depth + damping * side * v, 0.0), x - side * depth
