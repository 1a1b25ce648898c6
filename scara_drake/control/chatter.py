"""The largest gains that a sampled loop bears without chatter.

A torque m_hat g per unit of sigma, held over a period T_s, changes sigma of a single joint by
-T_s g m_hat / M of itself: beyond 2 it overshoots for ever. For the arm the same holds for the
eigenvalues of T_s M(q)^-1 diag(m_hat g), so over all postures::

    T_s max_q lambda_max( M(q)^-1 diag(m_hat g) ) < 2

where g is the slope of the law, rho / phi + k for integral sliding mode control. At 1 or less the
loop is well damped, and bears one tick of delay.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import product

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import MultibodyPlant

from scara_drake import robot

Array = NDArray[np.float64]

LIMIT = 2.0
LARGEST_LAYER = 1e6  # [m/s, rad/s], times the layer given


@lru_cache(maxsize=1)
def inverse_mass_matrices() -> Array:
    """M(q)^-1 (n, 6, 6) of the robot over a grid of postures [1/kg, 1/(kg m²)].

    The grid spans joints 3 to 5: the matrix does not depend on the mast nor on joint 2, and on
    the roll of the tool by joint 6 to less than 0.01 kg m².
    """
    plant = MultibodyPlant(time_step=0.0)
    robot.add_scara(plant)
    plant.Finalize()
    context = plant.CreateDefaultContext()
    q = robot.HOME.copy()
    matrices = []
    axes = (np.linspace(robot.LOWER[i], robot.UPPER[i], 13) for i in (3, 4))
    for q[2], q[3], q[4] in product(np.linspace(-np.pi, np.pi, 13), *axes):
        plant.SetPositions(context, q)
        matrices.append(plant.CalcMassMatrix(context))
    inverses = np.linalg.inv(matrices)
    inverses.setflags(write=False)
    return inverses


def chatter_number(gain: Array, period: float) -> float:
    """T_s max over postures of lambda_max(M(q)^-1 diag(gain)); below 2 the loop does not chatter.

    Args:
        gain: effort per unit of sigma (6,) [N s/m, N m s/rad], m_hat (rho / phi + k).
        period: T_s [s].
    """
    # D^1/2 M^-1 D^1/2 is symmetric and has the same eigenvalues.
    root = np.sqrt(gain)
    symmetric = inverse_mass_matrices() * root * root[:, None]
    return period * float(np.linalg.eigvalsh(symmetric)[:, -1].max())


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
