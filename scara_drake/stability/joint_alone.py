"""A joint alone under one of the laws: the smallest loop in which they work.

The plant is M x'' = u + M d(t). The law sees x and x' at each sample, as they are or through an
encoder; its effort is held from there on, or from a delay later on; d is held over a share of a
period. Under held forces a double integrator moves exactly, so no integrator comes between the laws
and their closed forms.
"""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from scara_drake.common import checks
from scara_drake.common.layout import Rows
from scara_drake.control import ismc_law as ismc
from scara_drake.control import observer_law as observed
from scara_drake.control import sliding_mode as smc
from scara_drake.control.governor import BOUNDS, bounds_of, govern
from scara_drake.control.ismc_law import gains_of, ismc_law, sliding_surface
from scara_drake.control.observer_law import (
    estimates_of,
    observer_begin,
    observer_law,
    observer_law_gains_of,
)
from scara_drake.control.sliding_mode import gains_of as smc_gains_of
from scara_drake.control.sliding_mode import smc_law

Array = NDArray[np.float64]

ISMC, SMC, OBSERVER = range(3)
LAWS: Final = {"ISMC": ISMC, "SMC": SMC, "ISMC + SPO": OBSERVER}
ESTIMATES_ROWS: Final = observed.ESTIMATES.size
GAINS: Final[dict[str, Rows[Any]]] = {
    "ISMC": ismc.GAINS,
    "SMC": smc.GAINS,
    "ISMC + SPO": observed.GAINS,
}


class Rig(NamedTuple):
    """What the loop of each joint is like besides its law, each row (n,).

    Attributes:
        inertia: M [kg, kg m²]; in units of m_hat where that is 1.
        lead: along which a law carries the reference, for one that is older than the state [s].
        delay: of the effort [s].
        resolution: of the encoder [m, rad]; 0 shows the state itself.
        bandwidth: of the derivative of what the encoder shows [rad/s].
        bounds: of a governor's return (2, n), see `govern`; 0 for none.
    """

    inertia: Array
    lead: Array
    delay: Array
    resolution: Array
    bandwidth: Array
    bounds: Array


class Track(NamedTuple):
    """What the joints do at each sample.

    Attributes:
        x: (..., n) [m, rad].
        v: (..., n) [m/s, rad/s].
        sigma: e' + c e, of what was measured (..., n) [m/s, rad/s].
        s: of the law, sigma where it has no integral (..., n).
        u: effort within its limits (..., n) [N, N m].
    """

    x: Array
    v: Array
    sigma: Array
    s: Array
    u: Array


RIG = Rows(Rig, bounds=BOUNDS.size)
TRACK = Rows(Track)
rig_of = RIG.reader()
track_of = TRACK.reader()


def make_rig(**values: ArrayLike) -> Array:
    """Return a rig of an ideal joint with M = 1, but for the values by name; see `Rig`.

    Each is a number or (n,).
    """
    ideal: dict[str, ArrayLike] = dict.fromkeys(Rig._fields, 0.0)
    return RIG.pack(**(ideal | {"inertia": 1.0} | values))


@njit(cache=True)
def measure(
    x: Array, v: Array, noise: Array, rig: Array, period: float, first: bool, measured: Array
) -> None:
    """Write what is measured of the state (2n,), from what it was at the sample before."""
    r = rig_of(rig)
    n = x.size
    for i in range(n):
        before = measured[i]
        shown = x[i] + noise[i]
        if r.resolution[i] > 0.0:
            shown = r.resolution[i] * np.rint(shown / r.resolution[i])
        measured[i] = shown
        if r.resolution[i] == 0.0 or first:
            measured[n + i] = v[i]
        else:
            slope = (shown - before) / period
            decay = np.exp(-r.bandwidth[i] * period)
            measured[n + i] = slope + decay * (measured[n + i] - slope)


@njit(cache=True)
def surface_and_period(law: int, gains: Array) -> tuple[Array, float]:
    """Return the c (n,) [1/s] of a law and its T_s [s]."""
    if law == SMC:
        g = smc_gains_of(gains)
        return g.c, g.period[0]
    if law == OBSERVER:
        inner = gains_of(observer_law_gains_of(gains).law)
        return inner.c, inner.period[0]
    own = gains_of(gains)
    return own.c, own.period[0]


@njit(cache=True)
def advance(
    x: Array, v: Array, efforts: Array, disturbance: Array, rig: Array, period: float
) -> None:
    """Move the joints over a period, in place.

    Args:
        x: (n,) [m, rad].
        v: (n,) [m/s, rad/s].
        efforts: of this sample and of those before it, latest first (samples, n) [N, N m].
        disturbance: (shares, n) [m/s², rad/s²], each held for its share of the period.
        rig: see `Rig`.
        period: T_s [s].
    """
    r = rig_of(rig)
    for i in range(x.size):
        whole = int(np.floor(r.delay[i] / period))
        late = r.delay[i] - whole * period
        h = period / disturbance.shape[0]
        for share, d in enumerate(disturbance[:, i]):
            # Until `late` the effort of one period before acts.
            until = min(max(late - share * h, 0.0), h)
            for length, effort in (
                (until, efforts[whole + 1, i]),
                (h - until, efforts[whole, i]),
            ):
                acceleration = effort / r.inertia[i] + d
                x[i] += length * (v[i] + 0.5 * length * acceleration)
                v[i] += length * acceleration


@njit(cache=True)
def run(
    law: int,
    gains: Array,
    rig: Array,
    reference: Array,
    disturbance: Array,
    noise: Array,
    state: Array,
    track: Array,
) -> None:
    """Run n joints, one a column, and write what they do at each sample; see `simulate`.

    Args:
        law: ISMC, SMC or OBSERVER.
        gains: as the law takes them (rows, n).
        rig: see `Rig`.
        reference: (samples, 2n).
        disturbance: (samples, shares, n).
        noise: (samples, n).
        state: x and v at the first sample (2, n); at the end on return.
        track: (samples, 5 n), written, see `Track`.
    """
    x, v = state[0], state[1]
    n = x.size
    r = rig_of(rig)
    (c, period), lead = surface_and_period(law, gains), r.lead[0]
    governed = bounds_of(r.bounds).speed[0] > 0.0
    m_hat = gains_of(gains).m_hat if governed else r.inertia
    measured, offset, lost, none = np.zeros(2 * n), np.zeros(2 * n), np.zeros(n), np.zeros(n)
    z, u, limited, saturation = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n)
    memory = np.zeros(ESTIMATES_ROWS * n)
    estimates_of(memory).x1[:] = x
    efforts = np.zeros((int(np.floor((r.delay / period).max())) + 2, n))
    for sample in range(track.shape[0]):
        now = track_of(track[sample])
        now.x[:], now.v[:] = x, v
        measure(x, v, noise[sample], rig, period, sample == 0, measured)
        desired = reference[sample] + offset
        sliding_surface(desired, measured, c, lead, now.sigma)
        if law == OBSERVER and sample == 0:
            observer_begin(desired, measured, gains, memory, now.s, u, limited, saturation)
        elif law == OBSERVER:
            observer_law(desired, measured, gains, memory, now.s, u, limited, saturation)
        elif law == SMC:
            now.s[:] = now.sigma
            smc_law(now.sigma, gains, u, limited, saturation)
        else:
            if sample == 0:
                z[:] = now.sigma
            ismc_law(now.sigma, gains, none, z, now.s, u, limited, saturation)
        now.u[:] = limited
        for row in range(efforts.shape[0] - 1, 0, -1):
            efforts[row] = efforts[row - 1]
        efforts[0] = limited
        advance(x, v, efforts, disturbance[sample], rig, period)
        if governed:
            for i in range(n):
                lost[i] = (limited[i] - u[i]) / m_hat[i]
            govern(lost, r.bounds, period, offset)


def check_gains(law: str, gains: Array, n: int) -> float:
    """Return the period [s] of the gains of n joints.

    Raises:
        ValueError: no such law, or gains that are not its own.
    """
    checks.choice("law", law, LAWS)
    rows = GAINS[law].size
    if gains.ndim != 2 or gains.shape[0] != rows or gains.shape[1] not in (1, n):
        raise ValueError(f"gains: shape {gains.shape}, allowed ({rows}, 1) or ({rows}, {n})")
    return float(surface_and_period(LAWS[law], np.ascontiguousarray(gains))[1])


def simulate(
    law: str,
    gains: Array,
    rig: Array,
    reference: Array,
    disturbance: Array | None = None,
    noise: Array | None = None,
    start: ArrayLike = 0.0,
    start_rate: ArrayLike = 0.0,
) -> Track:
    """Run n joints that share nothing but the law's kind and the times of their samples.

    Args:
        law: "ISMC", "SMC" or "ISMC + SPO".
        gains: as the law takes them, one column or one a joint; the period is in them.
        rig: of `make_rig`, one column or one a joint. Its first column tells the lead, and whether
            there is a governor; that takes ISMC.
        reference: x_d and its rate at each sample (samples, 2, n) [m, rad, m/s, rad/s].
        disturbance: d (samples, shares, n) [m/s², rad/s²], each held for its share of the period;
            None is zero.
        noise: added to the measured position (samples, n) [m, rad]; None is zero.
        start: x at the first sample, a number or (n,) [m, rad].
        start_rate: v likewise [m/s, rad/s].

    Returns:
        A track of arrays (samples, n).

    Raises:
        ValueError: no such law, or gains that are not its own.
    """
    samples, _, n = reference.shape
    check_gains(law, gains, n)
    state = np.empty((2, n))
    state[0], state[1] = start, start_rate
    track = np.empty((samples, TRACK.size * n))
    run(
        LAWS[law],
        _columns(gains, n),
        _columns(rig, n),
        np.ascontiguousarray(reference.reshape(samples, 2 * n)),
        np.zeros((samples, 1, n)) if disturbance is None else disturbance,
        np.zeros((samples, n)) if noise is None else noise,
        state,
        track,
    )
    return Track(*np.moveaxis(track.reshape(samples, TRACK.size, n), 1, 0))


def _columns(table: Any, n: int) -> Array:
    return np.ascontiguousarray(np.broadcast_to(table, (table.shape[0], n)))
