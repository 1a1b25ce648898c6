"""Figures of merit of recordings: pure functions, dims in, dims out.

Each reduces the dim `time` [s] and keeps the others. NaN samples: means, percentiles, peaks and
shares leave them out; integrals, and all that is read off a curve (rise, settling, overshoot,
variation, lag), are NaN where there is one. Times count from the first sample.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

Array = NDArray[np.float64]
# A number, or one for each entry of the dims that are kept.
Value = xr.DataArray | float


def tracking_error(recording: xr.Dataset) -> xr.DataArray:
    """Joint error e = q_desired - q_measured (time, joint) [m, rad]."""
    return recording.q_desired - recording.q_measured


def tool_error(recording: xr.Dataset) -> xr.DataArray:
    """Distance |p_desired - p_measured| of the tool (time) [m]."""
    offset = recording.p_WE_desired - recording.p_WE_measured
    return (offset**2).sum("axis", skipna=False) ** 0.5


def contact_force(recording: xr.Dataset) -> xr.DataArray:
    """Magnitude |f| of the contact force (time) [N]; NaN where the Diagram has no surface."""
    return (recording.f_env_on_tool_W**2).sum("axis", skipna=False) ** 0.5


def rmse(error: xr.DataArray) -> xr.DataArray:
    """Root of the mean square over time, sqrt(mean(e²)); NaN left out."""
    return (error**2).mean("time") ** 0.5


def peak(error: xr.DataArray) -> xr.DataArray:
    """Largest magnitude over time, max |e|; NaN left out."""
    return abs(error).max("time")


def percentile95(error: xr.DataArray) -> xr.DataArray:
    """Magnitude that 95 % of the samples stay within, the quantile 0.95 of |e|; NaN left out."""
    return abs(error).quantile(0.95, "time").drop_vars("quantile")


def iae(error: xr.DataArray) -> xr.DataArray:
    """Integral of the absolute error, ∫ |e| dt by the trapezoidal rule [unit s]; NaN stays."""
    return abs(error).integrate("time")


def ise(error: xr.DataArray) -> xr.DataArray:
    """Integral of the squared error, ∫ e² dt by the trapezoidal rule [unit² s]; NaN stays."""
    return (error**2).integrate("time")


def itae(error: xr.DataArray) -> xr.DataArray:
    """∫ t |e| dt by the trapezoidal rule, with t from the first sample [unit s²]; NaN stays."""
    return (_elapsed(error) * abs(error)).integrate("time")


def steady_state(error: xr.DataArray, last: float = 0.1) -> xr.DataArray:
    """Mean of e over the last fraction `last` of the time; NaN left out."""
    t = _elapsed(error)
    return error.where(t >= (1.0 - last) * t[-1]).mean("time")


def chatter(effort: xr.DataArray) -> xr.DataArray:
    """Mean change from sample to sample, mean |u_k - u_(k-1)|, in the unit of the effort.

    Changes from or to a NaN are left out.
    """
    return abs(effort.diff("time")).mean("time")


def total_variation(effort: xr.DataArray) -> xr.DataArray:
    """Total variation a second, sum |u_k - u_(k-1)| / T [unit/s]; NaN stays."""
    return abs(effort.diff("time")).sum("time", skipna=False) / float(_elapsed(effort)[-1])


def outside_layer(sliding_variable: xr.DataArray, phi: Value) -> xr.DataArray:
    """Share of the samples outside the boundary layer, mean(|s| > phi); NaN left out."""
    outside = (abs(sliding_variable) > phi).where(sliding_variable.notnull())
    return outside.mean("time")


def energy(effort: xr.DataArray, rate: xr.DataArray) -> xr.DataArray:
    """Energy that passes either way, ∫ |tau v| dt by the trapezoidal rule [J]; NaN stays."""
    return abs(effort * rate).integrate("time")


def work(effort: xr.DataArray, rate: xr.DataArray) -> xr.DataArray:
    """Work done, ∫ tau v dt by the trapezoidal rule [J]: negative where it brakes; NaN stays."""
    return (effort * rate).integrate("time")


def rise_time(
    response: xr.DataArray,
    start: Value = 0.0,
    target: Value = 1.0,
    fractions: tuple[float, float] = (0.0, 0.9),
) -> xr.DataArray:
    """Time between two fractions of the way, t_high - t_low [s].

    With y = (x - start) / (target - start), t_low and t_high are the first instants at which y
    reaches the fractions, interpolated between samples.

    Args:
        response: x.
        start: x before the step.
        target: x after it.
        fractions: low and high; often (0.1, 0.9).

    Returns:
        NaN where y does not reach the higher fraction, or has a NaN.
    """
    way = (response - start) / (target - start)
    low, high = fractions
    return _reached(way, high) - _reached(way, low)


def settling_time(
    response: xr.DataArray, start: Value = 0.0, target: Value = 1.0, band: float = 0.01
) -> xr.DataArray:
    """Time after which the response stays in its band [s].

    The last instant with |x - target| > band |target - start|, interpolated between samples.

    Args:
        response: x.
        start: x before the step.
        target: x after it.
        band: half its width, as a share of the step.

    Returns:
        Zero where x never leaves the band; NaN where the last sample is outside, or one is NaN.
    """
    off = (response - start) / (target - start) - 1.0
    t = _elapsed(response)
    outside = abs(off) > band
    last = (outside.sizes["time"] - 1) - outside.isel(time=slice(None, None, -1)).argmax("time")
    following = (last + 1).clip(max=outside.sizes["time"] - 1)
    before, after = off.isel(time=last), off.isel(time=following)
    side = np.sign(before)  # where it is overshot, the crossing is of the side that it comes from
    share = (side * before - band) / (side * (before - after))
    crossing = t.isel(time=last) + share * (t.isel(time=following) - t.isel(time=last))
    settled = xr.where(outside.any("time"), crossing.drop_vars("time", errors="ignore"), 0.0)
    return settled.where(off.notnull().all("time") & ~outside.isel(time=-1, drop=True))


def overshoot(response: xr.DataArray, start: Value = 0.0, target: Value = 1.0) -> xr.DataArray:
    """Largest excess over the target as a share of the step, max(0, max(y) - 1).

    y = (x - start) / (target - start); NaN where there is one.
    """
    way = (response - start) / (target - start)
    return (way.max("time", skipna=False) - 1.0).clip(min=0.0)


def lag(response: xr.DataArray, reference: xr.DataArray, largest: float) -> xr.DataArray:
    """Delay of a response behind its reference by cross-correlation [s]; negative where it leads.

    The shift n that makes the correlation of response(t_k) with reference(t_(k-n)) largest, both
    without their means over the window, and a parabola through the best three for the rest between
    samples. The window is all of the response but `largest` at both ends, so that each shift
    compares as many samples. A gain or an offset of the response does not change it.

    Args:
        response: evenly sampled.
        reference: at the same times.
        largest: [s], the shifts go from minus to plus this.

    Returns:
        NaN where a signal is constant or has a NaN, or where the largest correlation is at an end.

    Raises:
        ValueError: the samples are not even, or too few for the shifts.
    """
    t = response.time.values
    period = float(t[-1] - t[0]) / (t.size - 1) if t.size > 1 else np.nan
    if not np.allclose(np.diff(t), period, rtol=1e-3, atol=0.0):
        raise ValueError("time: not even, allowed samples with one period")
    shifts = int(np.ceil(largest / period))
    if t.size < 2 * shifts + 3:
        raise ValueError(
            f"largest: {largest:g} s, allowed below half of the {t[-1] - t[0]:.6g} s there are"
        )
    found = xr.apply_ufunc(
        _best_shift,
        response,
        reference,
        shifts,
        input_core_dims=[["time"], ["time"], []],
        vectorize=True,
        output_dtypes=[np.float64],
    )
    return period * found


def _elapsed(signal: xr.DataArray) -> xr.DataArray:
    return signal.time - signal.time[0]


def _reached(way: xr.DataArray, fraction: float) -> xr.DataArray:
    """First instant at which `way` reaches a fraction, interpolated; NaN where it does not."""
    t = _elapsed(way)
    reached = way >= fraction
    first = reached.argmax("time")
    previous = (first - 1).clip(min=0)
    before, after = way.isel(time=previous), way.isel(time=first)
    share = ((fraction - before) / (after - before)).where(first > 0, 0.0)
    instant = t.isel(time=previous) + share * (t.isel(time=first) - t.isel(time=previous))
    instant = instant.drop_vars("time", errors="ignore")
    return instant.where(reached.any("time") & way.notnull().all("time"))


def _best_shift(response: Array, reference: Array, shifts: int) -> float:
    """Shift in samples, between -shifts and shifts, of the largest correlation; see `lag`."""
    window = response[shifts : response.size - shifts]
    window = window - window.mean()
    reference = reference - reference.mean()
    n = window.size
    # Entry i has the reference from sample i on: a shift of shifts - i.
    product = np.correlate(reference, window, "valid")
    sums = np.concatenate([[0.0], np.cumsum(reference)])
    squares = np.concatenate([[0.0], np.cumsum(reference**2)])
    mean = (sums[n:] - sums[:-n]) / n
    spread = (squares[n:] - squares[:-n]) / n - mean**2
    if not (spread > 1e-12 * squares[-1] / n).all() or not window.any():
        return np.nan
    correlation = product / np.sqrt(spread)
    best = int(np.argmax(correlation))
    if not np.isfinite(correlation).all() or best in (0, correlation.size - 1):
        return np.nan
    left, top, right = correlation[best - 1 : best + 2]
    return shifts - best - 0.5 * (left - right) / (left - 2.0 * top + right)
