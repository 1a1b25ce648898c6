"""Figures of merit of a bilateral teleoperation: pure functions of its recordings.

Positions and forces are in the master's units: the way of the tool over `position_scale`, the force
of the environment on it times `force_scale`. Where a signal has crossed the channel, its recorded
delay is taken away first, so that an error is the coupling's and not the distance's.

An impedance comes from a sweep of the hand (`master.Sweep`): the spectra of force and velocity over
that of the hand's target, so what the sweep did not cause does not count.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

Array = NDArray[np.float64]

BAND = (0.1, 10.0)  # [Hz]
BINS = 3  # neighbours that a spectrum is averaged over
STEADY = 0.25  # last share of a press, its steady part; the first is a transient
SWING = 0.25  # ripple, over the force that the hand has for all of its way, of a stable press


def age_of_information(recording: xr.Dataset, link: str) -> xr.DataArray:
    """Age (time) [s] of what is in use at the end of the link "up" or "down".

    That of the packet in use; without packets, the delay.
    """
    name = f"age_{link}"
    return recording[name] if name in recording else recording[f"delay_{link}"]


def vector_size(vector: xr.DataArray) -> xr.DataArray:
    """Size (time) of a vector (time, axis); where an entry is missing it counts as zero."""
    return (vector**2).sum("axis") ** 0.5


def as_received(signal: xr.DataArray, age: xr.DataArray) -> xr.DataArray:
    """Signal (time, axis) as it was `age` (time) [s] ago; its first value before it began."""
    t = signal.time.values
    columns = [
        np.interp(t - age.values, t, column) for column in signal.transpose("axis", "time").values
    ]
    return signal.transpose("time", "axis").copy(data=np.stack(columns, axis=-1))


def tool_way(recording: xr.Dataset, position_scale: float = 1.0) -> xr.DataArray:
    """Way of the tool from its start (time, axis) [m]."""
    return (recording.p_WE_measured - recording.p_WE_measured.isel(time=0)) / position_scale


def position_error(recording: xr.Dataset, position_scale: float = 1.0) -> xr.DataArray:
    """Distance (time) [m] of the tool from where the master was when it sent."""
    sent = as_received(recording.x_master, age_of_information(recording, "up"))
    return vector_size(tool_way(recording, position_scale) - sent)


def drift(recording: xr.Dataset, position_scale: float = 1.0) -> xr.DataArray:
    """Distance (time) [m] of the tool from the master at the same time."""
    return vector_size(tool_way(recording, position_scale) - recording.x_master)


def resisting_force(recording: xr.Dataset, force_scale: float = 1.0) -> xr.DataArray:
    """Force at the tool that resists (time, axis) [N]; zero where there is none."""
    return -force_scale * recording.f_env_on_tool_W.fillna(0.0)


def force_sent(recording: xr.Dataset, force_scale: float = 1.0) -> xr.DataArray:
    """That force (time, axis) [N] when what the master uses was sent."""
    resisting = resisting_force(recording, force_scale)
    return as_received(resisting, age_of_information(recording, "down"))


def force_error(recording: xr.Dataset, force_scale: float = 1.0) -> xr.DataArray:
    """Difference (time) [N] of the force at the master from that at the tool when it was sent."""
    return vector_size(recording.f_master - force_sent(recording, force_scale))


def peak_force(recording: xr.Dataset) -> float:
    """Largest force at the master [N], before the limit of its actuators."""
    return float(vector_size(recording.f_master).max("time"))


def mean_size(signal: xr.DataArray) -> float:
    """Mean size of a vector (time, axis) over the time; where there is none, it counts as zero."""
    return float(vector_size(signal.fillna(0.0)).mean("time"))


def force_ripple(recording: xr.Dataset) -> float:
    """Standard deviation of the force at the master [N], of all axes together."""
    return float(recording.f_master.var("time").sum("axis") ** 0.5)


def contact_share(recording: xr.Dataset) -> float:
    """Share of the time in which the tool is touched; 0 without a surface."""
    return float((vector_size(recording.f_env_on_tool_W) > 0.0).mean("time"))


def is_driven(recording: xr.Dataset, mass: float, available: float) -> bool:
    """Whether the device has more kinetic energy than the hand could have given it, at any time.

    A hand that rests and its spring have an energy; a device that moves faster than this would
    throw it is driven by the coupling. It says nothing of how calm the device is: see the ripple.

    Args:
        recording: of a hand that rests.
        mass: of the device [kg].
        available: energy of the hand, at most [J].
    """
    speed = vector_size(recording.v_master).max("time")
    return bool(0.5 * mass * speed**2 >= available)


def steady_press(recording: xr.Dataset, begin: float, end: float) -> xr.Dataset:
    """Return the steady part of a press that the hand holds from `begin` to `end` [s]."""
    return recording.sel(time=slice(end - STEADY * (end - begin), end))


def is_stable_press(
    recording: xr.Dataset, begin: float, end: float, way: float, stiffness: float, mass: float
) -> bool:
    """Whether the force rests in the steady part, and nothing but the hand moves the device.

    Args:
        recording: of a press.
        begin: when the hand has arrived [s].
        end: when it begins to let go [s].
        way: of the hand [m].
        stiffness: of the hand [N/m].
        mass: of the device [kg].
    """
    resting = recording.sel(time=slice(begin + STEADY * (end - begin), end))
    ripple = force_ripple(steady_press(recording, begin, end))
    thrown = 0.5 * stiffness * way**2
    return ripple < SWING * stiffness * way and not is_driven(resting, mass, thrown)


def energy_margin(recording: xr.Dataset, reserve: float = 0.0) -> float:
    """Least energy that coupling and channel have left [J]; negative where they made some.

    The least over time and axes of what came in at both ports less what went out, and the reserve.

    Args:
        recording: of the ports that the coupling names.
        reserve: of an axis that the coupling may give out beside [J].
    """
    came_in = recording.energy_master_in + recording.energy_slave_in
    went_out = recording.energy_master_out + recording.energy_slave_out
    return float((came_in - went_out).min()) + reserve


def impedance(
    recording: xr.Dataset, axis: str, start: float, force: str = "f_master"
) -> xr.DataArray:
    """Impedance force / v_master (frequency) [N s/m], complex, at each bin of `BAND`.

    Args:
        recording: of a sweep from `start` on that has faded out at its end.
        axis: of the sweep.
        start: of the sweep [s].
        force: "f_master" for the coupling alone, "f_hand" for what the hand feels: the device too.
    """
    frequency, inside, target, swept = _sweep(recording, axis, start)
    shown = _smooth(_spectrum(swept[force].values) * target)
    moved = _smooth(_spectrum(swept.v_master.values) * target)
    return _of_frequency(frequency[inside], shown[inside] / moved[inside])


def as_swept(
    known: Callable[[xr.DataArray], xr.DataArray], recording: xr.Dataset, axis: str, start: float
) -> xr.DataArray:
    """What `impedance` would find of a known one in the motion of a recording.

    Where an impedance is steep, the mean over neighbours that it takes is not that of the middle.

    Args:
        known: its values at frequencies [Hz].
        recording: of a sweep.
        axis: of the sweep.
        start: of the sweep [s].
    """
    frequency, inside, target, swept = _sweep(recording, axis, start)
    moved = _spectrum(swept.v_master.values) * target
    shown = np.zeros_like(moved)
    shown[1:] = known(_of_frequency(frequency, frequency).frequency[1:]).values * moved[1:]
    return _of_frequency(frequency[inside], (_smooth(shown) / _smooth(moved))[inside])


def _sweep(
    recording: xr.Dataset, axis: str, start: float
) -> tuple[Array, NDArray[np.bool_], NDArray[np.complex128], xr.Dataset]:
    """Frequencies of the bins [Hz], which are in `BAND`, the target's spectrum, and the signals."""
    swept = recording.sel(axis=axis, time=slice(start, None))
    period = float(swept.time[-1] - swept.time[0]) / (swept.sizes["time"] - 1)
    frequency = np.asarray(np.fft.rfftfreq(swept.sizes["time"], period), dtype=np.float64)
    inside = (frequency >= BAND[0]) & (frequency <= BAND[1])
    target: NDArray[np.complex128] = np.conj(_spectrum(swept.hand_target.values))
    return frequency, inside, target, swept


def _of_frequency(frequency: Array, values: NDArray[Any]) -> xr.DataArray:
    return xr.DataArray(
        values,
        coords={"frequency": ("frequency", frequency, {"units": "Hz"})},
        dims="frequency",
        attrs={"units": "N s/m"},
    )


def wall_impedance(frequency: xr.DataArray, stiffness: float, damping: float) -> xr.DataArray:
    """Impedance B + K / s of a spring and a damper (frequency) [N s/m], complex."""
    return damping + stiffness / (2j * np.pi * frequency)


def decades(impedance: xr.DataArray, other: xr.DataArray, signed: bool = False) -> float:
    """Mean of |log10 |Z / other||, or of log10 |Z / other|, over the logarithm of the frequency.

    An impedance of zero counts as infinitely small.
    """
    with np.errstate(divide="ignore"):
        ratio = np.log10(abs(impedance / other).values)
    position = np.log(impedance.frequency.values)
    total = np.trapezoid(ratio if signed else abs(ratio), position)
    return float(total / (position[-1] - position[0]))


def _spectrum(samples: Array) -> NDArray[np.complex128]:
    """Spectrum without the straight line from the first sample to the last: both are at rest."""
    line = np.linspace(samples[0], samples[-1], samples.size)
    return np.fft.rfft(samples - line)


def _smooth(spectrum: NDArray[np.complex128]) -> NDArray[np.complex128]:
    return np.convolve(spectrum, np.ones(BINS), mode="same")
