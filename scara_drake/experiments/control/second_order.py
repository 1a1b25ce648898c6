"""A second-order plant under sampled sliding mode control: responses to a reference.

The plant is x'' = b u + d(t), and the law sees e = x_d - x, sigma = e' + c e at each sample, see
`joint_alone`. The disturbance is held over a tenth of a period.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from scara_drake.control import ismc_law, sliding_mode
from scara_drake.recordings.labels import labelled
from scara_drake.stability.joint_alone import check_gains, make_rig, simulate

Array = NDArray[np.float64]
Disturbance = Callable[[Array], ArrayLike]  # of times (m,) [s], gives (m,) or a number [m/s²]
Reference = Callable[[Array], tuple[ArrayLike, ArrayLike]]  # gives x_d [m] and its rate [m/s]

SUB_STEPS = 10  # of the disturbance in a period
M_HAT = 1.0  # a law's u is the plant's effort


def ismc_gains(
    c: ArrayLike,
    k: ArrayLike,
    rho: ArrayLike,
    phi: ArrayLike,
    effort: ArrayLike = np.inf,
    anti_windup: bool = True,
    period: float = 1e-3,
) -> Array:
    """Return gains (8, n) for `respond`, with m_hat = 1.

    Args:
        c: [1/s], like the others a number or (n,).
        k: [1/s].
        rho: [m/s²].
        phi: [m/s].
        effort: limit of u [m/s²].
        anti_windup: |s| is clamped to 2 phi, as in `IntegralSlidingMode`.
        period: T_s [s].
    """
    clamp = 2.0 * np.asarray(phi, float) if anti_windup else np.inf
    return ismc_law.GAINS.pack(
        c=c, k=k, rho=rho, phi=phi, m_hat=M_HAT, effort=effort, clamp=clamp, period=period
    )


def smc_gains(
    c: ArrayLike,
    rho: ArrayLike,
    phi: ArrayLike,
    effort: ArrayLike = np.inf,
    period: float = 1e-3,
) -> Array:
    """Return gains (6, n) for `respond`, with m_hat = 1; see `ismc_gains`."""
    return sliding_mode.GAINS.pack(c=c, rho=rho, phi=phi, m_hat=M_HAT, effort=effort, period=period)


def unit_step(t: Array) -> tuple[Array, Array]:
    """Reference that is 1 m from the first sample on."""
    return np.ones_like(t), np.zeros_like(t)


def respond(
    law: str,
    gains: Array,
    disturbances: Sequence[Disturbance],
    duration: float,
    reference: Reference = unit_step,
    b: ArrayLike = 1.0,
    start: ArrayLike = 0.0,
    start_rate: ArrayLike = 0.0,
) -> xr.Dataset:
    """Simulate a loop for each disturbance; they share the reference.

    Args:
        law: "ISMC" or "SMC".
        gains: of that law, from `ismc_gains` or `smc_gains`; one column, or one a disturbance. The
            period of the samples is in them.
        disturbances: d(t) [m/s²], n functions of an array of times.
        duration: [s].
        reference: x_d(t) [m] and its rate [m/s].
        b: of the plant, a number or (n,).
        start: x(0) [m], a number or (n,).
        start_rate: v(0) [m/s], a number or (n,).

    Returns:
        x, v, sigma, s, u (time, case) and x_d (time); the first sample is at 0.

    Raises:
        ValueError: no such law, or gains that are not its own.
    """
    n = len(disturbances)
    period = check_gains(law, gains, n)
    samples = round(duration / period) + 1
    t = period * np.arange(samples, dtype=np.float64)
    middles = period / SUB_STEPS * (np.arange(SUB_STEPS, dtype=np.float64) + 0.5)
    between = (t[:, None] + middles).ravel()
    d = np.empty((samples, SUB_STEPS, n))
    for case, disturbance in enumerate(disturbances):
        d[:, :, case] = np.broadcast_to(disturbance(between), between.shape).reshape(t.size, -1)
    desired = np.empty((samples, 2, n))
    for column, values in enumerate(reference(t)):
        desired[:, column] = np.broadcast_to(values, t.shape)[:, None]
    rig = make_rig(inertia=1.0 / np.broadcast_to(b, n))
    track = simulate(law, gains, rig, desired, d, start=start, start_rate=start_rate)
    dims = ("time", "case")
    return xr.Dataset(
        {
            "x": labelled(dims, track.x, "m", "position"),
            "v": labelled(dims, track.v, "m/s", "velocity"),
            "sigma": labelled(dims, track.sigma, "m/s", "e' + c e"),
            "s": labelled(dims, track.s, "m/s", "sliding variable"),
            "u": labelled(dims, track.u, "m/s^2", "effort within its limit"),
            "x_desired": labelled(("time",), desired[:, 0, 0], "m", "reference"),
        },
        coords={"time": ("time", t, {"units": "s"})},
    )
