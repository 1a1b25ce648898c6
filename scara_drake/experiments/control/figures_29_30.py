"""Figures 29 and 30: joint 2 with the control-process delay, by ISMC and by SMC.

The paper gives zeta(t) = 100 sin t and d(t) = 100 cos t without unit or place; `process_delay` has
the three readings. Each runs here on the whole arm. Read as a perturbation (B) its peak of 141 is
just below rho = 150, but asks more than three times the effort of joint 2's drive; so it also runs
with its peak at the same share of that effort ("B reduced"), and on a joint alone without a limit.
"""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from scara_drake import robot
from scara_drake.control.integral_sliding_mode import IntegralSlidingMode
from scara_drake.control.ismc_law import GAINS
from scara_drake.control.process_delay import (
    CONTROL_DELAY_READINGS,
    perturbation_reading,
)
from scara_drake.experiments.claim import Claim, Experiment
from scara_drake.experiments.control import figures_29_30_claims
from scara_drake.experiments.control.figures_29_30_claims import (
    ALONE,
    HARD,
    HIGH,
    INDEX,
    JOINT,
    PEAK,
    PLAIN,
    REDUCED,
    REDUCED_AMPLITUDE,
    RHO,
    SINE,
)
from scara_drake.experiments.reading import OpenQuestion
from scara_drake.recordings.labels import labelled
from scara_drake.scenario import load_scenario
from scara_drake.simulation import run as simulation
from scara_drake.stability.joint_alone import make_rig, simulate

Array = NDArray[np.float64]

TABLE_12 = IntegralSlidingMode()
C, K = TABLE_12.c[INDEX], TABLE_12.k[INDEX]
CONTROLLERS: Final = {PLAIN: (K, RHO), "SMC": (0.0, RHO), HARD: (0.0, HIGH)}

READINGS: Final[dict[str, dict[str, Any]]] = {
    "none": {},
    "A": CONTROL_DELAY_READINGS["A"],
    "B": perturbation_reading(JOINT),
    REDUCED: perturbation_reading(JOINT, REDUCED_AMPLITUDE),
    "C": CONTROL_DELAY_READINGS["C"],
}
SHARES = 10  # of a period, each with a perturbation of its own

START = 1.0  # [s]: before it the drives take up the weight of the arm
WINDOW = (2.7, 4.8)  # [s], where the paper reports the errors


def joint_alone(k: float, rho: float, times: Array) -> Array:
    """Return q_desired, q and u (n, 3) of a joint x'' = u + PEAK sin(t + pi / 4).

    Args:
        k: [1/s]; with 0 the law is plain sliding mode control.
        rho: [rad/s²].
        times: of the samples (n,) [s].
    """
    amplitude, frequency = SINE
    period = float(times[1] - times[0])
    clamp = 2.0 if k else np.inf
    gains = GAINS.pack(
        c=C, k=k, rho=rho, phi=1.0, m_hat=1.0, effort=np.inf, clamp=clamp, period=period
    )
    q = amplitude * np.sin(frequency * times)
    rate = amplitude * frequency * np.cos(frequency * times)
    reference = np.stack([q, rate], axis=1)[:, :, np.newaxis]
    shares = period / SHARES * (np.arange(SHARES) + 0.5)
    disturbance = PEAK * np.sin(times[:, np.newaxis] + shares + np.pi / 4)
    track = simulate(
        "ISMC", gains, make_rig(), reference, disturbance[:, :, np.newaxis], start_rate=rate[0]
    )
    return np.stack([q, track.x[:, 0], track.u[:, 0]], axis=-1)


def run(seed: int = 0, duration: float = 7.0) -> Experiment:
    """Simulate joint_sine with each reading and controller, and the joint alone.

    Args:
        seed: of the scenario; nothing in it is random.
        duration: [s]; the paper's window ends at 4.8 s.
    """
    runs: dict[str, list[Array]] = {reading: [] for reading in READINGS}
    for reading, overrides in READINGS.items():
        for name in CONTROLLERS:
            recording = simulation.simulate(
                load_scenario("joint_sine", {**overrides, **_controller(name), "seed": seed}),
                duration=duration,
            ).sel(joint=JOINT)
            columns = [recording.q_desired, recording.q_measured, recording.tau_applied]
            runs[reading].append(np.stack(columns, axis=-1))
    times = recording.time.values
    runs[ALONE] = []
    for k, rho in CONTROLLERS.values():
        track = joint_alone(k, rho, times)
        track[:, 2] *= robot.nominal_inertias()[INDEX]
        runs[ALONE].append(track)
    values = np.array(list(runs.values()))
    dims = ("reading", "controller", "time")
    data = xr.Dataset(
        {
            "q_desired": labelled(("time",), values[0, 0, :, 0], "rad", "reference of joint 2"),
            "q_measured": labelled(dims, values[..., 1], "rad", "joint 2 of the plant"),
            "tau": labelled(dims, values[..., 2], "N m", "effort of joint 2, within its limits"),
        },
        coords={
            "reading": list(runs),
            "controller": list(CONTROLLERS),
            "time": ("time", times, {"units": "s"}),
        },
        attrs={
            "seed": seed,
            "scenario": "joint_sine",
            "joint": JOINT,
            "amplitude_reduced": REDUCED_AMPLITUDE,
        },
    )
    return Experiment("Figures 29 and 30", data, claims(data), questions(data))


def _controller(name: str) -> dict[str, Any]:
    """Return the overrides that choose a controller; all other joints keep Table 12."""
    if name == "ISMC":
        return {"controller": "!IntegralSlidingMode {}"}
    rho = list(TABLE_12.rho)
    rho[INDEX] = CONTROLLERS[name][1]
    return {"controller": {"_tag": "!SlidingMode", "c": list(TABLE_12.c), "rho": rho}}


def largest_error(data: xr.Dataset) -> xr.DataArray:
    """Largest |e| of joint 2 after the start (reading, controller) [rad]."""
    return _error(data).max("time")


def error_in_window(data: xr.Dataset) -> xr.DataArray:
    """Largest |e| within the paper's window over that outside of it (reading, controller)."""
    error = _error(data)
    inside = (error.time >= WINDOW[0]) & (error.time <= WINDOW[1])
    return error.where(inside).max("time") / error.where(~inside).max("time")


def lag(data: xr.Dataset) -> xr.DataArray:
    """Delay [s] of the reference, up to 0.3 s, that fits the response best."""
    late = data.sel(time=slice(START, None))
    period = float(data.time[1] - data.time[0])
    shifts = np.arange(round(0.3 / period) + 1)
    first, desired = data.sizes["time"] - late.sizes["time"], data.q_desired.values
    measured = late.q_measured.transpose(..., "time")
    misfit = [
        np.mean((measured.values - desired[first - n : desired.size - n]) ** 2, axis=-1)
        for n in shifts
    ]
    dims = measured.isel(time=0, drop=True)
    return dims.copy(data=period * np.argmin(misfit, axis=0))


def undershoot(data: xr.Dataset) -> xr.DataArray:
    """Largest lack at the turns of the reference, as a share of its amplitude."""
    turns = np.arange(np.pi / 2, SINE[1] * float(data.time[-1]), np.pi) / SINE[1]
    at = data.sel(time=turns[turns > START], method="nearest")
    lack = (at.q_desired - at.q_measured) * np.sign(at.q_desired) / SINE[0]
    return lack.max("time").clip(min=0.0)


def _error(data: xr.Dataset) -> xr.DataArray:
    return abs(data.q_desired - data.q_measured).sel(time=slice(START, None))


def claims(data: xr.Dataset) -> list[Claim]:
    """Judge each statement by the readings that suit it; see `run` for the data."""
    return figures_29_30_claims.claims(figures_of_merit(data))


def questions(data: xr.Dataset) -> tuple[OpenQuestion, ...]:
    """Show what each reading makes of the statements; see `run` for the data."""
    return (figures_29_30_claims.question(figures_of_merit(data)),)


def figures_of_merit(data: xr.Dataset) -> xr.Dataset:
    """What the statements are judged by (reading, controller); see `run` for the data."""
    alone = data.sel(reading=ALONE, controller=PLAIN, time=slice(START, None))
    error = alone.q_desired - alone.q_measured
    waves = {"size_correlation": np.sin, "rate_correlation": np.cos}  # of a perturbation
    return xr.Dataset(
        {
            "largest": largest_error(data),
            "share": error_in_window(data),
            "lag": lag(data),
            "undershoot": undershoot(data),
            **{n: abs(xr.corr(error, wave(alone.time + math.pi / 4))) for n, wave in waves.items()},
        }
    )
