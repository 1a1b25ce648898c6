r"""The delay that the loop bears: by formula, by the sampled loop's spectral radius, by simulation.

Inside the boundary layer the law is a PID with a = k + r, r = rho / phi, and the plant of one joint
is b / l² with b = m_hat / M. The loop transfer function is then

.. math::

    L(\lambda) = b\,(\lambda + c)\,(a\,\lambda + k\,r) / \lambda^3

Its magnitude falls from infinity to 0, so it crosses 1 once, at :math:`\omega`; the phase margin
there is :math:`\arctan(\omega / c) + \arctan(a\,\omega / (k r)) - \pi / 2`, and a delay of phase
margin :math:`/\, \omega` brings the loop to its limit. A hold of T_s takes T_s / 2 of that.
`sampled_loop` is exact instead, for one joint or for the arm, and `grows` runs the law itself.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scara_drake.control.integral_sliding_mode import IntegralSlidingMode
from scara_drake.control.ismc_law import GAINS
from scara_drake.robot import inverse_mass_matrices
from scara_drake.stability.joint_alone import make_rig, simulate

Array = NDArray[np.float64]

LONGEST = 0.05  # [s], up to which an onset is looked for
KICK = 1e-9  # [m, rad]; far inside the layer
BLOCKS, TICKS = 20, 500  # of a simulated joint, of which the largest |x| is compared


def crossover(
    c: ArrayLike, k: ArrayLike, rho: ArrayLike, phi: ArrayLike, mass_ratio: ArrayLike = 1.0
) -> Array:
    """Frequency w where |L(i w)| = 1 [rad/s].

    Args:
        c: [1/s], as all others a number or an array of one shape.
        k: [1/s].
        rho: [m/s², rad/s²].
        phi: [m/s, rad/s].
        mass_ratio: plant gain b = m_hat / M.
    """
    c, k, rho, phi, b = np.broadcast_arrays(c, k, rho, phi, mass_ratio)
    a, kr = k + rho / phi, k * rho / phi
    # w⁶ = b² (w² + c²) (a² w² + (k r)²), in w²: one change of sign, so one positive root.
    w = np.empty(c.shape)
    for i in np.ndindex(c.shape):
        b2, a2, c2, kr2 = b[i] ** 2, a[i] ** 2, c[i] ** 2, kr[i] ** 2
        roots = np.roots([1.0, -b2 * a2, -b2 * (kr2 + a2 * c2), -b2 * c2 * kr2])
        w[i] = math.sqrt(roots[roots.imag == 0.0].real.max())
    return w


def phase_margin(
    c: ArrayLike, k: ArrayLike, rho: ArrayLike, phi: ArrayLike, mass_ratio: ArrayLike = 1.0
) -> Array:
    """Phase margin of the loop in continuous time [rad]; arguments as `crossover`."""
    w = crossover(c, k, rho, phi, mass_ratio)
    c, k, rho, phi = (np.asarray(x, dtype=np.float64) for x in (c, k, rho, phi))
    return np.arctan2(w, c) + np.arctan2((k + rho / phi) * w, k * rho / phi) - 0.5 * np.pi


def delay_margin(
    c: ArrayLike,
    k: ArrayLike,
    rho: ArrayLike,
    phi: ArrayLike,
    mass_ratio: ArrayLike = 1.0,
    period: float = 0.0,
) -> Array:
    """Delay that brings a joint's loop to its limit [s]: phase margin / w - period / 2.

    A negative one means that the sampled loop is unstable without any delay. Arguments as
    `crossover`, and the `period` T_s of the hold [s], of which 0 is continuous time.
    """
    margin = phase_margin(c, k, rho, phi, mass_ratio)
    return margin / crossover(c, k, rho, phi, mass_ratio) - 0.5 * period


def sampled_loop(inverse_mass: Array, gains: Array, delay: float) -> Array:
    """Matrix of one period of the sampled loop in the layer, exact for a held effort.

    The efforts reach the plant M q'' = tau after the delay, a whole number of periods and a
    fraction. The states are q, v, z and the efforts on their way, each (n,).

    Args:
        inverse_mass: M^-1 (n, n) [1/kg, 1/(kg m²)].
        gains: (8, n), see `ismc_law`; the period is in them.
        delay: [s], 0 or more.
    """
    n = inverse_mass.shape[0]
    g = GAINS.unpack(gains)
    period = float(g.period[0])
    whole = math.floor(delay / period)
    late = delay - whole * period  # until then the effort of one period before acts
    eye = np.eye(n)
    r = g.rho / g.phi
    on_v = -np.diag(g.m_hat * (g.k + r))
    effort = np.hstack([on_v * g.c, on_v, -np.diag(g.m_hat * r)])

    size = 3 * n + n * (whole + 1)
    on_the_way = [slice((3 + i) * n, (4 + i) * n) for i in range(whole + 1)]  # latest first
    computed = np.zeros((n, size))
    computed[:, : 3 * n] = effort
    queue = [computed, *(np.eye(size)[part] for part in on_the_way)]
    first, second = queue[whole + 1], queue[whole]

    step = np.zeros((size, size))
    q, v, z = slice(0, n), slice(n, 2 * n), slice(2 * n, 3 * n)
    rest = period - late
    step[q, q], step[q, v], step[v, v], step[z, z] = eye, period * eye, eye, eye
    step[v] += inverse_mass @ (late * first + rest * second)
    step[q] += inverse_mass @ (late * (0.5 * late + rest) * first + 0.5 * rest**2 * second)
    step[z, q] = np.diag(period * g.k * g.c)
    step[z, v] = np.diag(period * g.k)
    for part, row in zip(on_the_way, queue, strict=False):
        step[part] = row
    return step


def spectral_radius(inverse_mass: Array, gains: Array, delay: float) -> float:
    """Growth of `sampled_loop` in a period; the loop is stable below 1."""
    return float(np.abs(np.linalg.eigvals(sampled_loop(inverse_mass, gains, delay))).max())


def onset(inverse_mass: Array, gains: Array) -> float:
    """Least delay [s] at which the sampled loop begins to grow, to 1 µs.

    Zero if it grows without a delay, infinite if it bears `LONGEST`. Arguments as `sampled_loop`.
    """
    period = float(GAINS.unpack(gains).period[0])

    def fails(delays: Array, _: Array) -> list[bool]:
        return [spectral_radius(inverse_mass, gains, float(delay)) > 1.0 for delay in delays]

    return float(_least(fails, 1, period)[0])


def simulated_onset(mass_ratio: ArrayLike, gains: Array) -> Array:
    """The same of joints alone (n,) by running the law, see `grows`; to 1 µs.

    Args:
        mass_ratio: plant gain b = m_hat / M, a number or (n,).
        gains: of the joints (8, n), see `ismc_law`; the period is in them.
    """
    period = float(GAINS.unpack(gains).period[0])
    n = gains.shape[1]
    ratios = np.broadcast_to(np.asarray(mass_ratio, dtype=float), n)
    return _least(lambda delays, which: grows(ratios[which], gains[:, which], delays), n, period)


def grows(mass_ratio: ArrayLike, gains: Array, delay: ArrayLike) -> NDArray[np.bool_]:
    """Whether a small kick of a joint alone grows (n,), under the law itself, its effort delayed.

    Arguments as `simulated_onset`, and the delay [s], a number or (n,).
    """
    free = gains.copy()
    g = GAINS.unpack(free)
    g.effort[:], g.clamp[:] = np.inf, np.inf
    rig = make_rig(inertia=g.m_hat / np.asarray(mass_ratio, dtype=float), delay=delay)
    at_rest = np.zeros((BLOCKS * TICKS + 1, 2, gains.shape[1]))
    x = simulate("ISMC", free, rig, at_rest, start=KICK).x[1:]
    peaks = np.abs(x).reshape(BLOCKS, TICKS, -1).max(axis=1)
    # Where it grows fast, the largest effort of u1 soon bounds it.
    grown: NDArray[np.bool_] = (peaks.max(axis=0) > 100.0 * KICK) | (peaks[-1] > peaks[1])
    return grown


def mass_ratios(controller: IntegralSlidingMode) -> tuple[Array, Array]:
    """Least and largest m_hat / M_ii(q) of each joint (6,) over the postures of `chatter`."""
    diagonal = np.linalg.inv(inverse_mass_matrices()).diagonal(axis1=1, axis2=2)
    m_hat = GAINS.unpack(controller.array()).m_hat
    return m_hat / diagonal.max(axis=0), m_hat / diagonal.min(axis=0)


def arm_onset(controller: IntegralSlidingMode, period: float, every: int = 1) -> Array:
    """Onset [s] of the whole arm, its joints coupled by M(q), over the postures of `chatter`.

    Args:
        controller: the gains.
        period: T_s [s].
        every: takes only each so many postures.
    """
    gains = controller.array(period)
    return np.array([onset(m, gains) for m in inverse_mass_matrices()[::every]])


def _least(fails: Callable[[Array, NDArray[Any]], ArrayLike], n: int, period: float) -> Array:
    """Least delays [s] (n,) at which loops fail, each found in quarters of a period, then bisected.

    Args:
        fails: whether those of some numbers fail with their delays; so all are asked at once.
        n: number of loops.
        period: T_s [s].
    """
    low, high, found = np.zeros(n), np.zeros(n), np.zeros(n, dtype=bool)
    busy = np.arange(n)
    while busy.size:
        tried = np.where(found[busy], 0.5 * (low[busy] + high[busy]), high[busy])
        failed = np.asarray(fails(tried, busy))
        beyond = ~failed & ~found[busy] & (tried >= LONGEST)
        high[busy[failed]] = tried[failed]
        low[busy[~failed]] = tried[~failed]
        ahead = busy[~failed & ~found[busy]]
        high[ahead] += 0.25 * period
        high[busy[beyond]] = math.inf
        found[busy[failed]] = True
        busy = busy[~beyond & ~(found[busy] & (high[busy] - low[busy] <= 1e-6))]
    return high
