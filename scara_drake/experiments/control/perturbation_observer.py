"""The perturbation observer that the paper names as future work: where it pays, where it does not.

On one joint alone x'' = u m_hat / M + 30 sin 3t, by integral sliding mode control (ISMC) on the
measured velocity and by the same law on an observer (ISMC + SPO). On the whole arm: the contact
force of `teleoperation` without a force sensor. The paper has no number for any of it; the criteria
are our own.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from scara_drake.control import ismc_law as ismc
from scara_drake.control import observer_law as observed
from scara_drake.control.integral_sliding_mode import IntegralSlidingMode
from scara_drake.control.observer_sliding_mode import ObserverSlidingMode
from scara_drake.control.perturbation_observer import observer_gains
from scara_drake.experiments.claim import OURS, Claim, Criterion, Experiment
from scara_drake.experiments.quantity import quantity
from scara_drake.recordings.labels import labelled
from scara_drake.scenario import load_scenario
from scara_drake.simulation.run import simulate
from scara_drake.stability import joint_alone as joint

Array = NDArray[np.float64]

PLAIN: Final = "ISMC"
OBSERVER: Final = "ISMC + SPO"
LAWS: Final = (PLAIN, OBSERVER)

PERIOD = 1e-3  # [s]
START = 1.0  # [s]: before it both laws take up the perturbation
PERTURBATION = (30.0, 3.0)  # [rad/s²], [rad/s]
REFERENCE = (0.5, 1.0)  # sine [rad], [rad/s]
POLE, EPS = ObserverSlidingMode().pole[1], ObserverSlidingMode().eps[1]  # [1/s], [rad]
BANDWIDTH = 1000.0  # of the derivative that gives ISMC its velocity from an encoder [rad/s]
COUNT = 2.0 * np.pi / 2**19  # [rad]
TABLE_12 = IntegralSlidingMode()

TIMES_BETTER = 5.0
CONTACT_ERROR = 0.1  # of the force
STEADY = 0.5  # [s] without a change of the force beyond `CONTACT_ERROR`


@dataclass(frozen=True)
class Case:
    """One joint alone.

    Attributes:
        c: [1/s].
        k: [1/s].
        rho: of ISMC and of ISMC + SPO [rad/s²].
        inertia: M over m_hat.
        resolution: of the encoder [rad]; 0 measures the state itself.
        noise: of the encoder, standard deviation [rad].
        pole: of the observer [1/s].
    """

    c: float
    k: float
    rho: tuple[float, float]
    inertia: float = 1.0
    resolution: float = 0.0
    noise: float = 0.0
    pole: float = POLE


_WEAK = (10.0, 10.0, (20.0, 5.0))
_STRONG = (TABLE_12.c[1], TABLE_12.k[1], (TABLE_12.rho[1], 0.1 * TABLE_12.rho[1]))
CASES: Final[dict[str, Case]] = {
    "weak": Case(*_WEAK),
    "weak, 3 m_hat": Case(*_WEAK, inertia=3.0),
    "weak, m_hat / 3": Case(*_WEAK, inertia=1.0 / 3.0),
    "weak, 19 bit": Case(*_WEAK, inertia=3.0, resolution=COUNT),
    "weak, noise": Case(*_WEAK, inertia=3.0, resolution=COUNT, noise=1e-4),
    "weak, noise, pole 500": Case(*_WEAK, inertia=3.0, resolution=COUNT, noise=1e-4, pole=500.0),
    "Table 12": Case(*_STRONG),
    "Table 12, 3 m_hat": Case(*_STRONG, inertia=3.0),
    "Table 12, 19 bit": Case(*_STRONG, resolution=COUNT),
    "Table 12, noise": Case(*_STRONG, resolution=COUNT, noise=1e-4),
}
REQUIRED: Final = "weak, 3 m_hat"


def joint_alone(law: str, case: Case, unit_noise: Array) -> tuple[Array, Array]:
    """Return the error and u (n,) of a joint under one of the laws.

    As in the Diagram the reference is a period older than the state.

    Args:
        law: of `LAWS`.
        case: of the joint.
        unit_noise: of each sample of the encoder (n,), of variance one.
    """
    gains = ismc.GAINS.pack(
        c=case.c,
        k=case.k,
        rho=case.rho[LAWS.index(law)],
        phi=1.0,
        m_hat=1.0,
        effort=np.inf,
        clamp=2.0,
        period=PERIOD,
    )
    if law == OBSERVER:
        gains = observed.GAINS.pack(
            law=gains,
            observer=observer_gains([case.pole], [EPS], PERIOD),
            acceleration_feedforward=0.0,
        )
    rig = joint.make_rig(
        inertia=case.inertia, lead=PERIOD, resolution=case.resolution, bandwidth=BANDWIDTH
    )
    amplitude, frequency = REFERENCE
    peak, rate = PERTURBATION
    t = PERIOD * np.arange(unit_noise.size)
    late = frequency * (t - PERIOD)
    desired = [amplitude * np.sin(late), amplitude * frequency * np.cos(late)]
    track = joint.simulate(
        law,
        gains,
        rig,
        np.stack(desired, axis=1)[:, :, np.newaxis],
        peak * np.sin(rate * t)[:, np.newaxis, np.newaxis],
        (case.noise * unit_noise)[:, np.newaxis],
        start_rate=amplitude * frequency,
    )
    return amplitude * np.sin(frequency * t) - track.x[:, 0], track.u[:, 0]


def run(seed: int = 0, duration: float = 10.0, contact_duration: float = 30.0) -> Experiment:
    """Simulate the joint alone in each case under each law, and `teleoperation` with the observer.

    Args:
        seed: of the encoder's noise, and of the scenario.
        duration: of the joint alone [s].
        contact_duration: of the scenario [s]; its contact begins after 17 s.
    """
    samples = round(duration / PERIOD)
    unit_noise = np.random.default_rng(seed).normal(size=samples)
    tracks = np.array(
        [[joint_alone(law, case, unit_noise) for law in LAWS] for case in CASES.values()]
    )
    late = tracks[..., round(START / PERIOD) :]
    rmse = np.sqrt(np.mean(late[:, :, 0] ** 2, axis=-1))
    variation = np.abs(np.diff(late[:, :, 1], axis=-1)).sum(axis=-1) / (duration - START)

    scenario = load_scenario("teleoperation", {"seed": seed})
    scenario.controller = ObserverSlidingMode()
    contact = simulate(scenario, duration=contact_duration).isel(time=slice(None, None, 10))
    data = xr.Dataset(
        {
            "rmse": labelled(("case", "law"), rmse, "rad", "root of the mean square error"),
            "total_variation": labelled(
                ("case", "law"), variation, "rad/s^2 per s", "sum of |u_k - u_(k-1)| per second"
            ),
            "force": labelled(
                ("time", "axis"), contact.f_env_on_tool_W.values, "N", "force of the walls"
            ),
            "force_estimated": labelled(
                ("time", "axis"), contact.f_estimated_W.values, "N", "that force without a sensor"
            ),
        },
        coords={
            "case": list(CASES),
            "law": list(LAWS),
            "axis": contact.axis.values,
            "time": ("time", contact.time.values, {"units": "s"}),
        },
        attrs={"seed": seed, "scenario": "teleoperation"},
    )
    return Experiment("Perturbation observer", data, claims(data))


def steady(data: xr.Dataset) -> xr.DataArray:
    """Whether the tool has pressed for `STEADY` with a force that changes by less than 10 %."""
    force = (data.force**2).sum("axis") ** 0.5
    samples = round(STEADY / float(data.time[1] - data.time[0]))
    window = force.rolling(time=samples)
    low, high = window.min(), window.max()
    return (low > 1.0) & (high - low < CONTACT_ERROR * high)


def contact_error(data: xr.Dataset) -> xr.DataArray:
    """Error of the estimated force over the force, in steady pressing (time); else NaN."""
    error = ((data.force_estimated - data.force) ** 2).sum("axis") ** 0.5
    return (error / (data.force**2).sum("axis") ** 0.5).where(steady(data))


def free_error(data: xr.Dataset) -> float:
    """Root of the mean square of the force that is estimated where there is none [N]."""
    free = (data.force == 0.0).all("axis")
    return float(((data.force_estimated**2).sum("axis").where(free).mean()) ** 0.5)


def claims(data: xr.Dataset) -> list[Claim]:
    """Say what the observer brings and what it costs; the paper has nothing to compare with."""
    gain = data.rmse.sel(law=PLAIN) / data.rmse.sel(law=OBSERVER)
    variation = data.total_variation.sel(law=OBSERVER) / data.total_variation.sel(law=PLAIN)
    pays, rougher = _above_one(gain), _above_one(variation)
    return [
        _smaller_gain(float(gain.sel(case=REQUIRED))),
        Claim(
            "Where the observer pays (future work)",
            None,
            quantity(_by_case(gain), "", "RMSE of ISMC over that with the observer"),
            None,
            f"Lower error in {pays}. A stiff law on a good velocity leaves the observer nothing to "
            "do, and its lag is an error of its own.",
        ),
        Claim(
            "An observer would remove the chatter (future work)",
            None,
            quantity(_by_case(variation), "", "total variation of u over that of ISMC"),
            None,
            f"Rougher in {rougher}. The observer adds the noise of its estimate, which grows with "
            "the cube of its pole, and a smaller rho takes some away.",
        ),
        _contact(data),
    ]


def _smaller_gain(required: float) -> Claim:
    plain, observed = CASES[REQUIRED].rho
    return Claim(
        "An observer would allow a smaller switching gain (future work)",
        None,
        quantity(required, "times lower RMSE"),
        Criterion(
            f"{TIMES_BETTER:g} times lower with rho {observed:g} than ISMC with rho {plain:g}, "
            f"weak gains, {CASES[REQUIRED].inertia:g} times the nominal inertia",
            required >= TIMES_BETTER,
        ),
        f"The perturbation of {PERTURBATION[0]:g} rad/s² is larger than either rho.",
        OURS,
    )


def _contact(data: xr.Dataset) -> Claim:
    error = contact_error(data)
    count = int(error.notnull().sum())
    top = 100 * float(error.max()) if count else np.nan
    free = quantity(free_error(data), "N", "in free motion")
    pressed = quantity(top, "%", f"of the force, {count} samples of steady pressing", "at most")
    return Claim(
        "The estimate tells the contact force without a sensor (future work)",
        None,
        (pressed if count else "no steady contact", free),
        Criterion(
            f"within {100 * CONTACT_ERROR:.0f} % of the force in steady pressing",
            bool(count and float(error.max()) <= CONTACT_ERROR),
        ),
        "The model is the nominal robot; friction and payload would be taken for a contact.",
        OURS,
    )


def _by_case(values: xr.DataArray) -> dict[str, float]:
    return {str(name): float(values.sel(case=name)) for name in values.case.values}


def _above_one(values: xr.DataArray) -> str:
    names = [name for name, value in _by_case(values).items() if value > 1.0]
    return "; ".join(names) or "no case"
