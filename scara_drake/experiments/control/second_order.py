"""A second-order plant under sampled sliding mode control: the smallest loop the laws work in.

The plant is x'' = b u + d(t), and the law sees e = x_d - x, sigma = e' + c e at each sample. The
effort is held between samples and the disturbance over a tenth of one, and under held forces a
double integrator moves exactly, so no integrator comes between the laws and their closed forms.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

import numpy as np
import xarray as xr
from numba import njit
from numpy.typing import ArrayLike, NDArray

from scara_drake.common import checks
from scara_drake.control.integral_sliding_mode import ismc_law
from scara_drake.control.sliding_mode import smc_law
from scara_drake.recordings.labels import labelled

Array = NDArray[np.float64]
Disturbance = Callable[[Array], ArrayLike]  # of times (m,) [s], gives (m,) or a number [m/s²]
Reference = Callable[[Array], tuple[ArrayLike, ArrayLike]]  # gives x_d [m] and its rate [m/s]

LAWS: Final = ("ISMC", "SMC")
SUB_STEPS = 10  # of the disturbance in a period
M_HAT = 1.0  # a law's u is the plant's effort


@njit(cache=True)
def closed_loop(
    integral: bool,
    gains: Array,
    b: Array,
    period: float,
    reference: Array,
    disturbance: Array,
    state: Array,
    track: Array,
) -> None:
    """Simulate n loops, one a column, and write what they do at each sample.

    Args:
        integral: the law is `ismc_law`, or else `smc_law`.
        gains: (7, n) or (5, n), as the law takes them.
        b: of the plants (n,).
        period: of the samples [s].
        reference: x_d and its rate at the samples (m, 2) [m, m/s].
        disturbance: (m, sub-steps, n) [m/s²], each held for its share of the period.
        state: x and v at the first sample (2, n) [m, m/s]; at the end on return.
        track: (m, 5, n), written: x, v, sigma, s (sigma where the law has no integral), u limited.
    """
    n = b.size
    c = gains[0]  # of both laws
    x, v = state[0], state[1]
    sigma, s, z, none = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n)
    u, limited, saturation = np.zeros(n), np.zeros(n), np.zeros(n)
    h = period / disturbance.shape[1]
    for sample in range(track.shape[0]):
        for i in range(n):
            e, e_dot = reference[sample, 0] - x[i], reference[sample, 1] - v[i]
            sigma[i] = e_dot + c[i] * e
            if sample == 0:
                z[i] = sigma[i]
        if integral:
            ismc_law(sigma, gains, period, none, z, s, u, limited, saturation)
        else:
            s[:] = sigma
            smc_law(sigma, gains, u, limited, saturation)
        for i in range(n):
            track[sample, 0, i], track[sample, 1, i] = x[i], v[i]
            track[sample, 2, i], track[sample, 3, i] = sigma[i], s[i]
            track[sample, 4, i] = limited[i]
            for d in disturbance[sample, :, i]:
                acceleration = b[i] * limited[i] + d
                x[i] += h * (v[i] + 0.5 * h * acceleration)
                v[i] += h * acceleration


def ismc_gains(
    c: ArrayLike,
    k: ArrayLike,
    rho: ArrayLike,
    phi: ArrayLike,
    effort: ArrayLike = np.inf,
    anti_windup: bool = True,
) -> Array:
    """Return gains (7, n) for `respond`, with m_hat = 1.

    Args:
        c: [1/s], like the others a number or (n,).
        k: [1/s].
        rho: [m/s²].
        phi: [m/s].
        effort: limit of u [m/s²].
        anti_windup: |s| is clamped to 2 phi, as in `IntegralSlidingMode`.
    """
    clamp = 2.0 * np.asarray(phi, float) if anti_windup else np.inf
    return _columns(c, k, rho, phi, M_HAT, effort, clamp)


def smc_gains(c: ArrayLike, rho: ArrayLike, phi: ArrayLike, effort: ArrayLike = np.inf) -> Array:
    """Return gains (5, n) for `respond`, with m_hat = 1; see `ismc_gains`."""
    return _columns(c, rho, phi, M_HAT, effort)


def _columns(*rows: ArrayLike) -> Array:
    return np.array(np.broadcast_arrays(*np.atleast_1d(*rows)), dtype=np.float64)


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
    period: float = 1e-3,
) -> xr.Dataset:
    """Simulate a loop for each disturbance; they share the reference.

    Args:
        law: "ISMC" or "SMC".
        gains: of that law, from `ismc_gains` or `smc_gains`; one column, or one a disturbance.
        disturbances: d(t) [m/s²], n functions of an array of times.
        duration: [s].
        reference: x_d(t) [m] and its rate [m/s].
        b: of the plant, a number or (n,).
        start: x(0) [m], a number or (n,).
        start_rate: v(0) [m/s], a number or (n,).
        period: T_s [s].

    Returns:
        x, v, sigma, s, u (time, case) and x_d (time); the first sample is at 0.

    Raises:
        ValueError: no such law, or gains that are not its own.
    """
    checks.choice("law", law, LAWS)
    n, rows = len(disturbances), 7 if law == "ISMC" else 5
    if gains.ndim != 2 or gains.shape[0] != rows or gains.shape[1] not in (1, n):
        raise ValueError(f"gains: shape {gains.shape}, allowed ({rows}, 1) or ({rows}, {n})")
    samples = round(duration / period) + 1
    t = period * np.arange(samples, dtype=np.float64)
    middles = period / SUB_STEPS * (np.arange(SUB_STEPS, dtype=np.float64) + 0.5)
    between = (t[:, None] + middles).ravel()
    d = np.empty((samples, SUB_STEPS, n))
    for case, disturbance in enumerate(disturbances):
        d[:, :, case] = np.broadcast_to(disturbance(between), between.shape).reshape(t.size, -1)
    desired = np.empty((samples, 2))
    desired[:, 0], desired[:, 1] = reference(t)
    state = np.empty((2, n))
    state[0], state[1] = start, start_rate
    track = np.empty((samples, 5, n))
    columns = np.ascontiguousarray(np.broadcast_to(gains, (rows, n)))
    inputs = np.array(np.broadcast_to(b, n), dtype=np.float64)
    closed_loop(law == "ISMC", columns, inputs, period, desired, d, state, track)
    dims = ("time", "case")
    return xr.Dataset(
        {
            "x": labelled(dims, track[:, 0], "m", "position"),
            "v": labelled(dims, track[:, 1], "m/s", "velocity"),
            "sigma": labelled(dims, track[:, 2], "m/s", "e' + c e"),
            "s": labelled(dims, track[:, 3], "m/s", "sliding variable"),
            "u": labelled(dims, track[:, 4], "m/s^2", "effort within its limit"),
            "x_desired": labelled(("time",), desired[:, 0], "m", "reference"),
        },
        coords={"time": ("time", t, {"units": "s"})},
    )
