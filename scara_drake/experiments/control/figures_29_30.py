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

from scara_drake import joints, robot
from scara_drake.control.integral_sliding_mode import IntegralSlidingMode
from scara_drake.control.ismc_law import GAINS
from scara_drake.control.process_delay import (
    AMPLITUDE,
    CONTROL_DELAY_READINGS,
    perturbation_reading,
)
from scara_drake.experiments.claim import NOT_COMPARABLE, Claim, Experiment, judge, variable
from scara_drake.scenario import load_scenario
from scara_drake.simulation import run as simulation
from scara_drake.stability.joint_alone import make_rig, simulate

Array = NDArray[np.float64]

JOINT: Final = "theta2"
INDEX = joints.JOINT_NAMES.index(JOINT)
TABLE_12 = IntegralSlidingMode()
C, K, RHO = TABLE_12.c[INDEX], TABLE_12.k[INDEX], TABLE_12.rho[INDEX]
HIGH = 700.0  # gain of the SMC in Table 10
CONTROLLERS: Final = {"ISMC": (K, RHO), "SMC": (0.0, RHO), "SMC, high gain": (0.0, HIGH)}

SINE = (0.7854, 1.25)  # of the reference of joint 2 in joint_sine [rad], [rad/s]
PEAK = math.sqrt(2.0) * AMPLITUDE
# The peak at the share of the drive's largest u that it has of rho.
REDUCED = AMPLITUDE / RHO * joints.EFFORT[INDEX] / float(robot.nominal_inertias()[INDEX])
READINGS: Final[dict[str, dict[str, Any]]] = {
    "none": {},
    "A": CONTROL_DELAY_READINGS["A"],
    "B": perturbation_reading(JOINT),
    "B reduced": perturbation_reading(JOINT, REDUCED),
    "C": CONTROL_DELAY_READINGS["C"],
}
ALONE = "B alone"
SHARES = 10  # of a period, each with a perturbation of its own

START = 1.0  # [s]: before it the drives take up the weight of the arm
WINDOW = (2.7, 4.8)  # [s], where the paper reports the errors
SATISFACTORY = 0.01  # of the amplitude of the reference
TIMES_WORSE = 2.0
LAG = 0.01  # [s], a delay of the response that a figure shows
UNDERSHOOT = 0.02  # of the amplitude


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
            "q_desired": variable(("time",), values[0, 0, :, 0], "rad", "reference of joint 2"),
            "q_measured": variable(dims, values[..., 1], "rad", "joint 2 of the plant"),
            "tau": variable(dims, values[..., 2], "N m", "effort of joint 2, within its limits"),
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
            "amplitude_reduced": REDUCED,
        },
    )
    return Experiment("Figures 29 and 30", data, claims(data))


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
    shifts = range(round(0.3 / period) + 1)
    misfit = [
        ((late.q_measured - data.q_desired.shift(time=n).sel(time=late.time)) ** 2).mean("time")
        for n in shifts
    ]
    best = xr.concat(misfit, xr.Variable(("lag",), [n * period for n in shifts]))
    return best.assign_coords(lag=[n * period for n in shifts]).idxmin("lag")


def undershoot(data: xr.Dataset) -> xr.DataArray:
    """Largest lack at the turns of the reference, as a share of its amplitude."""
    turns = np.arange(np.pi / 2, SINE[1] * float(data.time[-1]), np.pi) / SINE[1]
    at = data.sel(time=turns[turns > START], method="nearest")
    lack = (at.q_desired - at.q_measured) * np.sign(at.q_desired) / SINE[0]
    return lack.max("time").clip(min=0.0)


def _error(data: xr.Dataset) -> xr.DataArray:
    return abs(data.q_desired - data.q_measured).sel(time=slice(START, None))


def claims(data: xr.Dataset) -> list[Claim]:
    """Judge each statement by the readings that suit it; see `run` for the data.

    A reading in which the error grows beyond the amplitude of the reference is lost: it has no
    response to speak of, and meets no criterion.
    """
    names = [str(name) for name in data.reading.values if name != "none"]
    largest = largest_error(data)
    lost = _where(largest.max("controller") > SINE[0], names)
    readings = [name for name in names if name not in lost]
    ismc, smc = "ISMC", "SMC, high gain"

    error = largest.sel(controller=ismc)
    allowed = SATISFACTORY * SINE[0]
    good = _where(error <= allowed, readings)
    ratio = largest.sel(controller=smc) / error
    worse = _where(ratio >= TIMES_WORSE, readings)
    late, lack = lag(data) >= LAG, undershoot(data) >= UNDERSHOOT
    drags = _where((late & lack).sel(controller=smc), readings)
    free = _where(~(late | lack).sel(controller=ismc), readings)
    alike = _where((late | lack).sel(controller=smc), readings)
    share = error_in_window(data).sel(controller=ismc)
    seen = _where((share >= TIMES_WORSE) & (error >= 1e-3 * SINE[0]), readings)
    dragged = [name for name in drags if name in free]
    met = {name: sum(name in x for x in (good, worse, dragged, seen)) for name in names}
    needed = PEAK * float(robot.nominal_inertias()[INDEX])

    def listed(values: xr.DataArray, form: str) -> str:
        return ", ".join(f"'{n}' {form.format(float(values.sel(reading=n)))}" for n in readings)

    return [
        Claim(
            "ISMC stays satisfactory under zeta(t) and d(t)",
            "satisfactory",
            f"largest error {listed(error, '{:.2g} rad')}; lost: {_names(lost)}",
            judge(bool(good)),
            f"Criterion: within {1e3 * allowed:.1f} mrad, 1 % of the amplitude, by one of the "
            f"readings; met by {_names(good)}. A puts 100 ms into a loop that bears 2 ms. B asks "
            f"{1e-3 * needed:.0f} kN m of a drive of {1e-3 * joints.EFFORT[INDEX]:.0f} kN m.",
        ),
        Claim(
            "SMC errs more than ISMC, even with a high gain",
            "higher errors",
            f"SMC with {HIGH:g} over ISMC {listed(ratio, '{:.2g}')}",
            judge(any(name in good for name in worse), bool(worse)),
            f"Criterion: at least twice the error where ISMC is satisfactory (in kind: anywhere); "
            f"met by {_names(worse)}. SMC with the gain of ISMC errs by "
            f"{listed(largest.sel(controller='SMC'), '{:.2g} rad')}.",
        ),
        Claim(
            "SMC lags and undershoots",
            "significant delays, undershoots",
            f"lag {listed(1e3 * lag(data).sel(controller=smc), '{:.0f} ms')}; undershoot "
            f"{listed(1e2 * undershoot(data).sel(controller=smc), '{:.2g} %')} (gain {HIGH:g})",
            judge(bool(dragged), bool(alike)),
            f"Criterion: a lag of {1e3 * LAG:.0f} ms and an undershoot of {1e2 * UNDERSHOOT:.0f} % "
            "that ISMC has not (in kind: one of them, and ISMC may have it too); met by "
            f"{_names(dragged)}, in kind by {_names(alike)}.",
        ),
        Claim(
            "ISMC errs and chatters from 2.7 to 4.8 s",
            "certain errors in that window",
            f"largest error inside over outside {listed(share, '{:.2g}')}",
            judge(bool(seen)),
            "Criterion: at least twice as large inside, and above 0.1 % of the amplitude; met by "
            f"{_names(seen)}. zeta + d has its trough of -141 at 3.93 s, but a peak of 141 at "
            "0.79 s and 7.07 s too; and inside the boundary layer the error of ISMC follows the "
            "rate of a perturbation, not its size.",
        ),
        Claim(
            "The place and the unit of zeta(t) and d(t)",
            "not given",
            ", ".join(f"'{name}' {count} of 4" for name, count in met.items()),
            NOT_COMPARABLE,
            "Criteria above that each reading meets; the paper has no statement to compare with.",
        ),
    ]


def _where(condition: xr.DataArray, readings: list[str]) -> list[str]:
    return [name for name in readings if bool(condition.sel(reading=name))]


def _names(readings: list[str]) -> str:
    return " and ".join(readings) or "none"
