r"""Effective time and value offset (ETVO): how late a signal is shown, and how wrong, at each time.

Kroep, Gokhale, Verburg and Venkatesha Prasad (arXiv 2107.05343, after 2001.01770) take a signal
that was sent, x, and the one that was shown, y, and split what is between them into an offset in
time and one in value, both over time, by dynamic programming as in dynamic time warping (DTW) but
with a cost on jumps in time. Of their algorithm only that description was at hand. What is
minimised here is ours,

.. math::

    \int w(t)\,\| y(t) - c - x(t - \tau(t)) \| \,dt + \lambda \int |d\tau|, \quad
    0 \le \tau \le \tau_{\text{max}}, \quad d\tau \le dt,

so nothing is shown before it was sent, and what was sent first is shown first. The least is exact,
on the grid of the samples. The value offset is :math:`y - x(t - \tau)`, with the constant c in it,
which is found beside :math:`\tau`: else a signal that is too high by a constant would seem to be
early on its way up.

A change of the time offset is seen if the signal goes on by more than :math:`2 \lambda` while it
lasts; a smaller one, and noise of that size, shows in the value. Where x rests, :math:`\tau` is
what it was. While something touches the tool, its place says nothing of the time (w = 0, ours).
"""

from __future__ import annotations

from typing import Final

import numpy as np
import xarray as xr
from numba import njit
from numpy.typing import ArrayLike, NDArray

from scara_drake.common import checks
from scara_drake.metrics.bilateral import age_of_information, resisting_force, tool_way

Array = NDArray[np.float64]
Lags = NDArray[np.int64]

STIFFNESS: Final = 0.1  # lambda over the range of what was sent
CELLS: Final = 20_000_000  # samples times lags; beyond it every second sample is taken, and so on
PASSES: Final = 5  # of finding tau for a constant, and the constant for tau
MARGIN: Final = 0.5  # [s] that the window is longer than the oldest information


def offsets(
    sent: xr.DataArray,
    shown: xr.DataArray,
    window: float,
    weight: ArrayLike = 1.0,
    stiffness: float = STIFFNESS,
) -> xr.Dataset:
    """Return `time_offset` (time) [s] and `value_offset` (time, axis) of a signal that was shown.

    Args:
        sent: (time, axis), evenly sampled; before its start it was what it is there.
        shown: (time, axis), at the same times, in the same unit.
        window: longest time offset [s].
        weight: of each sample of `shown` (time,) in finding the time offset, 0 to 1.
        stiffness: lambda over the range of `sent`.

    Returns:
        Curves at the times of `sent`, or of each `step`-th of them (an attribute) where samples
        times lags are more than `CELLS`.

    Raises:
        ValueError: fewer than two samples, not as many of both, or a number out of its bounds.
    """
    x, y = (each.transpose("time", "axis").values for each in (sent, shown))
    if len(x) < 2 or len(x) != len(y):
        raise ValueError(f"shown: {len(y)} samples, allowed as many as sent ({len(x)}), at least 2")
    t = sent.time.values
    period = float(t[-1] - t[0]) / (len(t) - 1)
    checks.number("window", window, 0.0, float(t[-1] - t[0]))
    checks.number("stiffness", stiffness, 0.0, 1e6)
    step = max(1, int(np.ceil(np.sqrt(len(x) * (window / period + 1.0) / CELLS))))
    x, y, t = (np.ascontiguousarray(each[::step]) for each in (x, y, t))
    weights = np.broadcast_to(np.asarray(weight, dtype=np.float64), sent.time.shape)[::step].copy()
    longest = min(int(np.ceil(window / (step * period) - 1e-9)), len(x) - 1)
    penalty = stiffness * float(np.linalg.norm(np.ptp(x, axis=0)))
    lag = lags(x, y, weights, longest, penalty)
    late = x[np.maximum(np.arange(len(x)) - lag, 0)]
    made = {
        "time_offset": ("time", step * period * lag, {"units": "s"}),
        "value_offset": (("time", "axis"), y - late, dict(shown.attrs)),
    }
    return xr.Dataset(made, {"time": t, "axis": sent.axis}, {"step": step})


def lags(sent: Array, shown: Array, weight: Array, longest: int, penalty: float) -> Lags:
    """Return the time offset (n,) in samples that costs least, see the module.

    Args:
        sent: (n, axes).
        shown: (n, axes).
        weight: (n,).
        longest: lag, in samples.
        penalty: lambda.
    """
    constant = _typical(sent, shown, weight, _even_lag(sent, shown, weight, longest))
    found = best_lags(sent, shown - constant, weight, longest, penalty)
    for _ in range(PASSES - 1):
        constant = _typical(sent, shown, weight, found)
        last, found = found, best_lags(sent, shown - constant, weight, longest, penalty)
        if np.array_equal(last, found):
            break
    return found


def tool_offsets(recording: xr.Dataset, position_scale: float = 1.0) -> xr.Dataset:
    """Return the offsets [s], [m] of the tool's way from the master's, in the master's units."""
    sent, shown = recording.x_master, tool_way(recording, position_scale)
    free = ~(recording.f_env_on_tool_W.fillna(0.0) != 0.0).any("axis")
    return offsets(sent, shown, _window(recording, "up"), free.values)


def force_offsets(recording: xr.Dataset, force_scale: float = 1.0) -> xr.Dataset:
    """Return the offsets [s], [N] of the force at the master from that at the tool."""
    sent = resisting_force(recording, force_scale)
    return offsets(sent, recording.f_master, _window(recording, "down"))


def delay_derivative(time_offset: xr.DataArray) -> float:
    """Mean size of the rate at which a time offset (time) changes [s/s]."""
    t = time_offset.time.values
    return float(np.abs(np.diff(time_offset.values)).sum() / (t[-1] - t[0]))


def _window(recording: xr.Dataset, link: str) -> float:
    """Longest time offset [s]: what the link's age explains, a quarter more, and `MARGIN`."""
    age = float(age_of_information(recording, link).max())
    return min(1.25 * age + MARGIN, float(recording.time[-1] - recording.time[0]))


def _typical(sent: Array, shown: Array, weight: Array, lag: Lags | int) -> Array:
    """Return the median (axes,) of what is left in value."""
    late = sent[np.maximum(np.arange(len(sent)) - lag, 0)]
    counted = (shown - late)[weight > 0.0]
    return np.median(counted, axis=0) if len(counted) else np.zeros(sent.shape[1])


@njit(cache=True)
def _even_lag(sent: Array, shown: Array, weight: Array, longest: int) -> int:
    """Return the one lag after which what is left in value varies least."""
    n, axes = shown.shape
    total = weight.sum()
    best, least = 0, np.inf
    for lag in range(longest + 1):
        spread = 0.0
        for axis in range(axes):
            first, second = 0.0, 0.0
            for k in range(n):
                left = shown[k, axis] - sent[max(k - lag, 0), axis]
                first += weight[k] * left
                second += weight[k] * left * left
            if total > 0.0:
                spread += second - first * first / total
        if spread < least:
            best, least = lag, spread
    return best


@njit(cache=True)
def best_lags(sent: Array, shown: Array, weight: Array, longest: int, penalty: float) -> Lags:
    """Return the lags (n,) of least cost for signals without a constant between them."""
    n, axes = shown.shape
    came_from = np.empty((n, longest + 1), np.int32)
    cost, moved = np.zeros(longest + 1), np.zeros(longest + 1)
    for k in range(n):
        # From a larger lag to any smaller one, or up by one: what was sent first is shown first.
        reached, source = np.inf, longest
        for lag in range(longest, -1, -1):
            reached += penalty
            if cost[lag] <= reached:
                reached, source = cost[lag], lag
            moved[lag], came_from[k, lag] = reached, source
            if lag > 0 and cost[lag - 1] + penalty < reached:
                moved[lag], came_from[k, lag] = cost[lag - 1] + penalty, lag - 1
        for lag in range(longest + 1):
            i = max(k - lag, 0)
            squares = 0.0
            for axis in range(axes):
                squares += (shown[k, axis] - sent[i, axis]) ** 2
            cost[lag] = moved[lag] + weight[k] * np.sqrt(squares)
    found = np.empty(n, np.int64)
    found[n - 1] = np.argmin(cost)
    for k in range(n - 1, 0, -1):
        found[k - 1] = came_from[k, found[k]]
    return found
