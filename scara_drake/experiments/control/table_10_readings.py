"""What Table 10 becomes under each disturbance by itself, and with other c and k."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

import numpy as np
import xarray as xr

from scara_drake import metrics
from scara_drake.experiments.claim import Claim, Criterion, ordered
from scara_drake.experiments.control.second_order import Disturbance, ismc_gains, respond
from scara_drake.experiments.quantity import Quantity, Value, quantity
from scara_drake.experiments.reading import OpenQuestion, Reading
from scara_drake.recordings.labels import labelled

Judge = Callable[..., Claim]

ALL: Final = "each of them"
MEANINGS: Final = {
    ALL: "all but none: the claims are judged under every one",
    "none": "no disturbance, both laws slide alike",
    "constant, light": "-3.75 m/s², chosen so that SMC has its times of the paper",
    "constant": "-10 m/s²",
    "slow sine": "10 sin 2t m/s²",
    "fast sine": "10 sin 20t m/s²",
    "step": "-10 m/s² from 3 s on",
}
# c and k [1/s]; the first are those that the claims are judged by.
GAINS: Final = ((1.0, 50.0), (1.0, 1.0), (1.0, 5.0), (1.0, 20.0), (1.0, 150.0), (0.5, 50.0),
                (2.0, 50.0))  # fmt: skip


def other_gains(
    disturbances: Mapping[str, Disturbance], rho: float, phi: float, band: float, duration: float
) -> xr.Dataset:
    """Return the times of ISMC (pair, disturbance) with each of GAINS.

    Args:
        disturbances: by name.
        rho: [m/s²].
        phi: [m/s].
        band: into which it settles, a share of the step.
        duration: [s].
    """
    runs = [
        respond("ISMC", ismc_gains(c, k, rho, phi), list(disturbances.values()), duration).x
        for c, k in GAINS
    ]
    times = [(metrics.rise_time(x), metrics.settling_time(x, band=band)) for x in runs]
    rise, settling = (
        np.stack([np.asarray(one) for one in row]) for row in zip(*times, strict=True)
    )
    dims = ("pair", "disturbance")
    return xr.Dataset(
        {
            "pair_rise_time": labelled(dims, rise, "s", "0 to 90 %, ISMC"),
            "pair_settling_time": labelled(dims, settling, "s", "into 1 %, ISMC; NaN: never"),
        },
        coords={
            "pair": [f"c = {c:g}, k = {k:g}" for c, k in GAINS],
            "disturbance": list(disturbances),
        },
    )


def disturbance(data: xr.Dataset, first: Claim, paper: Quantity) -> OpenQuestion:
    """Show the times under each disturbance, and whether ISMC settles first.

    Args:
        data: of `table_10.run`.
        first: the claim that it does, judged under each of them.
        paper: its settling times.
    """
    times = data.settling_time.fillna(np.inf)
    readings = []
    for name in (ALL, *map(str, data.disturbance.values)):
        some = [n for n in data.disturbance.values if n != "none"] if name == ALL else [name]
        found = {
            f"{law} {what}": _seconds(values.sel(law=law, disturbance=some))
            for law in data.law.values
            for what, values in (("rises", data.rise_time), ("settles", data.settling_time))
        }
        verdict = first.verdict
        if name != ALL:
            alone = times.sel(disturbance=name)
            pair = {str(law): float(alone.sel(law=law)) for law in alone.law.values}
            verdict = Criterion("", ordered(quantity(pair, "s"))).verdict(paper)
        readings.append(Reading(name, MEANINGS[name], found, verdict, name == ALL))
    return OpenQuestion("Which external disturbance?", first.statement, tuple(readings))


def _seconds(times: xr.DataArray) -> Value:
    """Return times, and how many there are not."""
    never, known = int(times.isnull().sum()), quantity(times, "s", missing="never")
    return (known, f"never under {never}") if 0 < never < times.size else known


def gains(data: xr.Dataset, rises: Judge, settles: Judge) -> OpenQuestion:
    """Show what other c and k make of the times of ISMC.

    Args:
        data: of `table_10.run`.
        rises: makes the claim about the rise, of times (disturbance).
        settles: makes the claim about the settling.
    """
    readings = []
    for pair, (c, k) in zip(data.pair.values, GAINS, strict=True):
        rise, settling = (data[f"pair_{n}_time"].sel(pair=pair) for n in ("rise", "settling"))
        up, into = rises(rise), settles(settling)
        plain = {"disturbance": "none"}
        found: dict[str, Value] = {
            "rises, undisturbed": quantity(rise.sel(plain), "s", missing="never"),
            "settles, undisturbed": quantity(settling.sel(plain), "s", missing="never"),
            "sliding motion, ln 10 / c and ln 100 / c": quantity(
                {"rise": np.log(10.0) / c, "settling": np.log(100.0) / c}, "s"
            ),
            "rises in 2.31 s": up.verdict,
        }
        meaning = f"slope {c:g} of the surface, gain {k:g} of u2"
        readings.append(Reading(str(pair), meaning, found, into.verdict, (c, k) == GAINS[0]))
    return OpenQuestion("What are c and k?", into.statement, tuple(readings))
