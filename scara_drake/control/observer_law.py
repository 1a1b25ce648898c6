"""The law of `observer_sliding_mode` on the estimates of its observer, as kernels."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.layout import Rows
from scara_drake.control import ismc_law as ismc
from scara_drake.control.controller import release
from scara_drake.control.ismc_law import (
    gains_of,
    ismc_law,
    sliding_surface,
)
from scara_drake.control.perturbation_observer import OBSERVER_GAINS, lag_step, observer_step

Array = NDArray[np.float64]


class Gains(NamedTuple):
    """Gains of the law and of its observer.

    Attributes:
        law: (8, n), see `ismc_law`.
        observer: (4, n), see `observer_gains`.
        acceleration_feedforward: (n,), 1 or 0.
    """

    law: Array
    observer: Array
    acceleration_feedforward: Array


class Estimates(NamedTuple):
    """Memory of the law and of its observer, each row (n,).

    Attributes:
        x1: estimate of the position [m, rad].
        x2: of the velocity [m/s, rad/s].
        psi: of the perturbation [m/s², rad/s²].
        lag_x1: x1 of `lag_step`.
        lag_x2: x2 of `lag_step`.
        lagged: effort, as old as psi [N, N m].
        z: of `ismc_law` [m/s, rad/s].
        v_desired: of the sample before [m/s, rad/s].
    """

    x1: Array
    x2: Array
    psi: Array
    lag_x1: Array
    lag_x2: Array
    lagged: Array
    z: Array
    v_desired: Array


GAINS = Rows(Gains, law=ismc.GAINS.size, observer=OBSERVER_GAINS.size)
ESTIMATES = Rows(Estimates)
observer_law_gains_of = GAINS.reader()
estimates_of = ESTIMATES.reader()


@njit(cache=True)
def observe(state: Array, gains: Array, actuation: Array, memory: Array) -> None:
    """Advance the estimates by one period.

    Args:
        state: measured (2n,); only the positions are looked at.
        gains: see `Gains`.
        actuation: effort within the limits that acted during the past period (n,) [N, N m].
        memory: see `Estimates`, in place.
    """
    g, m = observer_law_gains_of(gains), estimates_of(memory)
    law = gains_of(g.law)
    n, period = m.psi.size, law.period[0]
    observer_step(state[:n], actuation / law.m_hat, g.observer, period, m.x1, m.x2, m.psi)
    lag_step(actuation, g.observer, period, m.lag_x1, m.lag_x2, m.lagged)


@njit(cache=True)
def compare(state_desired: Array, gains: Array, lead: float, memory: Array, sigma: Array) -> None:
    """Write sigma^ (n,), with the reference carried `lead` [s] along its velocity."""
    m = estimates_of(memory)
    c = gains_of(observer_law_gains_of(gains).law).c
    sliding_surface(state_desired, np.concatenate((m.x1, m.x2)), c, lead, sigma)


@njit(cache=True)
def cancel(
    state_desired: Array, gains: Array, acceleration: Array, memory: Array, feedforward: Array
) -> None:
    """Write the effort (n,) that cancels c e^' and Psi^, and gives the reference's acceleration."""
    m = estimates_of(memory)
    law = gains_of(observer_law_gains_of(gains).law)
    n = m.psi.size
    for i in range(n):
        rate = state_desired[n + i] - m.x2[i]
        feedforward[i] = law.m_hat[i] * (law.c[i] * rate - m.psi[i] + acceleration[i])
        m.v_desired[i] = state_desired[n + i]


@njit(cache=True)
def observer_begin(
    state_desired: Array,
    state: Array,
    gains: Array,
    memory: Array,
    sliding_variable: Array,
    actuation_commanded: Array,
    actuation: Array,
    saturation: Array,
) -> None:
    """Observe, and apply the law with z = sigma^, at s^ = 0; both states are of one instant."""
    m = estimates_of(memory)
    n = m.psi.size
    observe(state, gains, actuation, memory)
    sigma, feedforward = np.empty(n), np.empty(n)
    compare(state_desired, gains, 0.0, memory, sigma)
    m.z[:] = sigma
    cancel(state_desired, gains, np.zeros(n), memory, feedforward)
    ismc_law(
        sigma, observer_law_gains_of(gains).law, feedforward, m.z,
        sliding_variable, actuation_commanded, actuation, saturation,
    )  # fmt: skip


@njit(cache=True)
def place(state: Array, memory: Array, actuation: Array) -> None:
    """Forget everything; then all stands still in the measured position, without an effort."""
    memory[:] = 0.0
    m = estimates_of(memory)
    m.x1[:] = state[: m.x1.size]
    actuation[:] = 0.0


@njit(cache=True)
def observer_initialize(
    state_desired: Array,
    state: Array,
    gains: Array,
    memory: Array,
    sliding_variable: Array,
    actuation_commanded: Array,
    actuation: Array,
    saturation: Array,
) -> None:
    """Begin at rest in the measured position."""
    place(state, memory, actuation)
    observer_begin(
        state_desired, state, gains, memory,
        sliding_variable, actuation_commanded, actuation, saturation,
    )  # fmt: skip


@njit(cache=True)
def observer_law(
    state_desired: Array,
    state: Array,
    gains: Array,
    memory: Array,
    sliding_variable: Array,
    actuation_commanded: Array,
    actuation: Array,
    saturation: Array,
) -> None:
    """Observe one sample and apply the law to the estimates, n joints.

    The observer takes the effort that acted during the past period from `actuation`, before the law
    overwrites it: so it knows of the drives' limits.

    Args:
        state_desired: q, v references (2n,), one period old.
        state: measured (2n,); only the positions are looked at.
        gains: see `Gains`.
        memory: see `Estimates`, in place.
        sliding_variable: s^ (n,), written.
        actuation_commanded: effort before the limits (n,) [N, N m], written.
        actuation: effort within the limits, in place.
        saturation: see `limit_effort`, written.
    """
    g, m = observer_law_gains_of(gains), estimates_of(memory)
    n, period = m.psi.size, gains_of(g.law).period[0]
    observe(state, gains, actuation, memory)
    sigma, acceleration, feedforward = np.empty(n), np.zeros(n), np.empty(n)
    compare(state_desired, gains, period, memory, sigma)
    for i in range(n):
        if g.acceleration_feedforward[i] > 0.0:
            acceleration[i] = (state_desired[n + i] - m.v_desired[i]) / period
    cancel(state_desired, gains, acceleration, memory, feedforward)
    ismc_law(
        sigma, g.law, feedforward, m.z,
        sliding_variable, actuation_commanded, actuation, saturation,
    )  # fmt: skip


@njit(cache=True)
def observer_rest(
    state_desired: Array,
    state: Array,
    gains: Array,
    memory: Array,
    sliding_variable: Array,
    actuation_commanded: Array,
    actuation: Array,
    saturation: Array,
) -> None:
    """Observe, and stay on the sliding surface without an effort; the reference is a period old."""
    m = estimates_of(memory)
    n = m.psi.size
    observe(state, gains, actuation, memory)
    period = gains_of(observer_law_gains_of(gains).law).period[0]
    compare(state_desired, gains, period, memory, m.z)
    m.v_desired[:] = state_desired[n:]
    sliding_variable[:] = 0.0
    release(actuation_commanded, actuation, saturation)


@njit(cache=True)
def observer_rest_initialize(
    state_desired: Array,
    state: Array,
    gains: Array,
    memory: Array,
    sliding_variable: Array,
    actuation_commanded: Array,
    actuation: Array,
    saturation: Array,
) -> None:
    """Begin at rest in the measured position, with the drives off."""
    place(state, memory, actuation)
    observer_rest(
        state_desired, state, gains, memory,
        sliding_variable, actuation_commanded, actuation, saturation,
    )  # fmt: skip


@njit(cache=True)
def show_velocity(memory: Array, velocity_estimate: Array) -> None:
    """Write the estimate of the velocity (n,) [m/s, rad/s]."""
    velocity_estimate[:] = estimates_of(memory).x2


@njit(cache=True)
def show_perturbation(memory: Array, perturbation_estimate: Array) -> None:
    """Write Psi^ (n,) [m/s², rad/s²]."""
    perturbation_estimate[:] = estimates_of(memory).psi


@njit(cache=True)
def show_lagged(memory: Array, actuation_lagged: Array) -> None:
    """Write the effort as old as Psi^ (n,) [N, N m]."""
    actuation_lagged[:] = estimates_of(memory).lagged
