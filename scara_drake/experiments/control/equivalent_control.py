"""Equations (31) and (38) to (42): the reaching of SMC, and the equivalent control of ISMC.

The plant is that of Table 10, x'' = u + d, after a step of the reference. With e = x_d - x equation
(30), sigma' = Psi - u, has Psi = c e' - d, which is known here at every sample without a look at
the law. So u1 can be compared with Psi, equation (39), and sigma with sigma(0) exp(-k t), (42).
With sat(s / phi) u1 follows Psi by a lag of phi / rho; hence several layers.
"""

from __future__ import annotations

from typing import Final

import numpy as np
import xarray as xr

from scara_drake.experiments.claim import Claim, Criterion, Experiment
from scara_drake.experiments.control.second_order import Disturbance, ismc_gains, respond, smc_gains
from scara_drake.experiments.quantity import quantity
from scara_drake.recordings.labels import labelled

C, K, RHO = 1.0, 50.0, 50.0  # [1/s], [1/s], [m/s²], as in Table 10
PERIOD = 2e-4  # [s], so that the thinnest layer is free of chatter and sigma' is close
LAYERS: Final = (1.0, 0.1, 0.02)  # phi [m/s]
WITHIN: Final = {
    "none": lambda t: 0.0,
    "constant": lambda t: -10.0,
    "slow sine": lambda t: 10.0 * np.sin(2.0 * t),
    "fast sine": lambda t: 10.0 * np.sin(20.0 * t),
}
BEYOND: Final = "beyond rho"
DISTURBANCES: Final[dict[str, Disturbance]] = {**WITHIN, BEYOND: lambda t: -2.0 * RHO}
CLOSE = 0.05  # of the largest Psi, of sigma(0)
STARTED = 10  # lags phi / rho, after which u1 has come up to Psi


def run(seed: int = 0, duration: float = 3.0) -> Experiment:
    """Simulate the unit step by both laws, for each layer and disturbance.

    Args:
        seed: nothing is random.
        duration: [s].
    """
    smc: list[xr.Dataset] = []
    ismc: list[xr.Dataset] = []
    names = list(DISTURBANCES)
    for phi in LAYERS:
        for law, runs, gains in (
            ("SMC", smc, smc_gains(C, RHO, phi, period=PERIOD)),
            ("ISMC", ismc, ismc_gains(C, K, RHO, phi, anti_windup=False, period=PERIOD)),
        ):
            runs.append(respond(law, gains, list(DISTURBANCES.values()), duration))
    t = smc[0].time.values
    middle = t + 0.5 * PERIOD
    d = np.stack([np.broadcast_to(f(middle), t.shape) for f in DISTURBANCES.values()], axis=-1)
    both = [np.stack([run[name].values for run in ismc]) for name in ("v", "u", "sigma", "s")]
    v, u, sigma, s = both
    psi = -C * (v + 0.5 * PERIOD * (u + d)) - d  # e' = -v, in the middle of the period
    dims = ("phi", "time", "disturbance")
    data = xr.Dataset(
        {
            "sigma_smc": labelled(
                dims, np.stack([run["sigma"].values for run in smc]), "m/s", "sigma of SMC"
            ),
            "sigma": labelled(dims, sigma, "m/s", "sigma of ISMC"),
            "s": labelled(dims, s, "m/s", "s of ISMC"),
            "u1": labelled(dims, u - K * sigma, "m/s^2", "u1 of ISMC"),
            "psi": labelled(dims, psi, "m/s^2", "Psi of equation (30)"),
        },
        coords={
            "phi": ("phi", list(LAYERS), {"units": "m/s"}),
            "disturbance": names,
            "time": ("time", t, {"units": "s"}),
        },
        attrs={"seed": seed, "c": C, "k": K, "rho": RHO},
    )
    return Experiment("Equations (31) and (38) to (42)", data, claims(data))


def falling(data: xr.Dataset, outside: bool) -> xr.DataArray:
    """Share (phi, disturbance) of SMC's samples, all or outside, with sigma sigma' <= 0."""
    sigma = data.sigma_smc
    before, after = (
        sigma.isel(time=slice(None, -1)).drop_vars("time"),
        sigma.isel(time=slice(1, None)).drop_vars("time"),
    )
    counted = (abs(before) >= before.phi) if outside else (before != 0.0)
    falls = (before * (after - before) <= 0.0) & counted
    return falls.sum("time") / counted.sum("time").clip(min=1)


def apart(data: xr.Dataset) -> xr.DataArray:
    """Largest |u1 - Psi| (phi, disturbance) over the largest |Psi|, once u1 has come up."""
    ready = data.time >= STARTED * data.phi / RHO
    gap = abs(data.u1 - data.psi).where(ready).max("time")
    return gap / abs(data.psi).where(ready).max("time").clip(min=1e-9)


def undershot(data: xr.Dataset) -> xr.DataArray:
    """Largest |sigma - sigma(0) exp(-k t)| (phi, disturbance), over |sigma(0)|."""
    start = data.sigma.isel(time=0)
    return abs(data.sigma - start * np.exp(-K * data.time)).max("time") / abs(start).clip(min=1e-9)


def claims(data: xr.Dataset) -> list[Claim]:
    """Judge the equations; see `run` for the data."""
    within = data.sel(disturbance=[name for name in WITHIN if name in data.disturbance.values])
    return [_reaches(data, within), _equivalent(within), _decays(within), _bounded(data)]


def _reaches(data: xr.Dataset, within: xr.Dataset) -> Claim:
    outside, every = falling(within, True), falling(within, False)
    return Claim(
        "With SMC sigma sigma' <= 0 (31)",
        "sigma sigma' <= 0",
        (
            quantity(100 * float(outside.min()), "%", "of the samples outside the layer, at least"),
            quantity(100 * float(every.min()), "%", "of all, at least"),
        ),
        Criterion(
            "in every sample under every disturbance below rho (in kind: in every one outside the "
            "layer)",
            float(every.min()) == 1.0,
            float(outside.min()) == 1.0,
        ),
        "Inside the layer sat gives less than rho, and sigma follows Psi up and down. Under "
        f"{2.0 * RHO:g} m/s², beyond rho = {RHO:g}, it holds in "
        f"{100 * float(falling(data, True).sel(disturbance=BEYOND).max()):.0f} % of the samples "
        "outside.",
    )


def _equivalent(within: xr.Dataset) -> Claim:
    gap = apart(within).max("disturbance")
    return Claim(
        "On s = 0 the equivalent control is the perturbation, u1_eq = Psi (38), (39)",
        "u1_eq = Psi",
        quantity({f"phi = {phi:g}": 100 * float(gap.sel(phi=phi)) for phi in LAYERS}, "%", "apart"),
        Criterion(
            f"u1 within {100 * CLOSE:g} % of the largest Psi in the thinnest layer, and nearer the "
            "thinner it is (in kind: nearer); the share is ours",
            float(gap.sel(phi=LAYERS[-1])) <= CLOSE and _falls(gap),
            _falls(gap),
        ),
        "u1 follows Psi by phi / rho, which is "
        + ", ".join(f"{1e3 * phi / RHO:g}" for phi in LAYERS)
        + " ms.",
    )


def _decays(within: xr.Dataset) -> Claim:
    off = undershot(within).max("disturbance")
    return Claim(
        "Then sigma' = -u2 = -k sigma (40) to (42)",
        "sigma' = -k sigma",
        quantity({f"phi = {phi:g}": 100 * float(off.sel(phi=phi)) for phi in LAYERS}, "%", "off"),
        Criterion(
            f"sigma within {100 * CLOSE:g} % of sigma(0) of sigma(0) exp(-k t) in the thinnest "
            "layer, and nearer the thinner it is (in kind: nearer); the share is ours",
            float(off.sel(phi=LAYERS[-1])) <= CLOSE and _falls(off),
            _falls(off),
        ),
        f"|s| comes to {float(abs(within.s).sel(phi=LAYERS[-1]).max()):.2g} m/s there, to "
        f"{float(abs(within.s).sel(phi=LAYERS[0]).max()):.2g} m/s in the widest layer.",
    )


def _bounded(data: xr.Dataset) -> Claim:
    s = abs(data.s.sel(disturbance=BEYOND)).max("time") / data.phi
    below = abs(data.s.drop_sel(disturbance=BEYOND)).max(["time", "disturbance"]) / data.phi
    return Claim(
        "The control has to exceed the bound of the perturbation",
        "K > H",
        quantity({"below rho": float(below.max()), "beyond": float(s.min())}, "phi", "|s|"),
        Criterion(
            "s stays in the layer under every disturbance below rho, and leaves it beyond",
            float(below.max()) < 1.0 and float(s.min()) > 1.0,
        ),
        f"Beyond, s has gone to {float(s.max()):.0f} phi by the end of the run, without a clamp.",
    )


def _falls(values: xr.DataArray) -> bool:
    """Whether values (phi,) get smaller as the layer gets thinner."""
    return bool((values.sortby("phi").diff("phi") > 0.0).all())
