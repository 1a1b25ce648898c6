"""Figure 28: what the operator feels with and without the varying delay."""

from __future__ import annotations

import numpy as np
import xarray as xr

from scara_drake import metrics
from scara_drake.experiments.claim import Claim, Criterion, Experiment
from scara_drake.experiments.quantity import quantity
from scara_drake.recordings.labels import labelled
from scara_drake.scenario import load_scenario
from scara_drake.simulation.run import simulate

SCENARIO = "teleoperation"
# The first is the reference; the others are the readings of 0.2 sin t, "0-2 s".
CHANNELS = ("none", "paper", "paper_offset", "paper_2s")
TOUCH = 5.0  # [N], from which the force is felt
SAMPLE = 1e-3  # [s]


def run(seed: int = 0, duration: float = 30.0) -> Experiment:
    """Simulate the recorded operator, who presses a wall from 16 s on, over each channel.

    Args:
        seed: of the scenario.
        duration: [s].
    """
    runs = [
        simulate(load_scenario(SCENARIO, {"channel.preset": name, "seed": seed}), duration=duration)
        for name in CHANNELS
    ]
    signals = ("channel", "time")
    data = xr.Dataset(
        {
            "force": labelled(
                signals,
                np.stack([metrics.contact_force(r) for r in runs]),
                "N",
                "contact force at the tool",
            ),
            "force_felt": labelled(
                signals,
                np.stack([(r.f_haptic**2).sum("axis") ** 0.5 for r in runs]),
                "N",
                "that force after the channel",
            ),
            "delay": labelled(
                signals, np.stack([r.delay_down for r in runs]), "s", "delay of the force"
            ),
            "rumble": labelled(
                (*signals, "motor"),
                np.stack([r.rumble for r in runs]),
                "1",
                "strength of the motors",
            ),
        },
        coords={
            "channel": list(CHANNELS),
            "time": ("time", runs[0].time.values, {"units": "s"}),
            "motor": runs[0].motor.values,
        },
        attrs={"seed": seed, "scenario": SCENARIO},
    )
    return Experiment("Figure 28", data, claims(data))


def edges(signal: xr.DataArray) -> xr.DataArray:
    """Times at which a force begins or ends to be felt [s]."""
    felt = (signal > TOUCH).astype(int)
    return signal.time[1:][abs(felt.diff("time")).values > 0]


def late(data: xr.Dataset, channel: str) -> xr.DataArray:
    """How much later than without delay each touch and release is felt (edge) [s].

    An edge that is not felt before the end of the run is left out.
    """
    with_delay, without = (
        edges(data.force_felt.sel(channel=name)).values for name in (channel, "none")
    )
    felt = min(with_delay.size, without.size)
    return xr.DataArray(with_delay[:felt] - without[:felt], dims="edge")


def lag_error(data: xr.Dataset, channel: str) -> float:
    """Largest difference of the force felt to the force one delay ago [N]."""
    one = data.sel(channel=channel)
    t = one.time.values
    # A reader in the loop sees the block's output one sample after its delay.
    past = np.interp(t - one.delay.values - SAMPLE, t, one.force.values)
    return float(abs(one.force_felt.values - past).max())


def claims(data: xr.Dataset) -> list[Claim]:
    """Judge Figure 28; see `run` for the data."""
    delayed = CHANNELS[1:]
    peak = data.force.max("time")
    return [
        _lags(data, float(peak.max())),
        _later(data, {name: late(data, name) for name in delayed}),
        Claim(
            "t_d = 0.2 sin t changes from 0 to 2 s",
            quantity((0, 2), "s"),
            tuple(quantity(data.delay.sel(channel=name), "s", name) for name in delayed),
            None,
            "0.2 sin t is within ±0.2 s and a delay is not negative. 0 to 2 s is 1 + sin t.",
        ),
        Claim(
            "The delay does not destabilise the haptic loop",
            "not said; shown by the figure",
            quantity(peak, "N", "largest force over all channels"),
            None,
            "The operator is a recording and vibration does not move the stick, so no loop is "
            "closed that could lose its stability, and the paper does not speak of it.",
        ),
    ]


def _lags(data: xr.Dataset, top: float) -> Claim:
    errors = [lag_error(data, name) for name in CHANNELS]
    return Claim(
        "The operator feels the force late by the delay of the moment",
        "response lags by the delay",
        (
            quantity(max(errors), "N", "from the contact force of one delay ago", "within"),
            quantity(top, "N", "largest force"),
        ),
        Criterion(
            "within 5 % of the largest force at every sample, over each channel",
            max(errors) < 0.05 * top,
        ),
        "The channel passes each sample of the force on after its delay, as it was.",
    )


def _later(data: xr.Dataset, lags: dict[str, xr.DataArray]) -> Claim:
    return Claim(
        "With delay the haptic signal comes later than without (red against blue)",
        "later",
        tuple(
            quantity(values, "s", name)
            if values.size
            else f"{name}: not within {float(data.time[-1]):g} s"
            for name, values in lags.items()
        ),
        Criterion(
            "no touch or release is felt earlier, and one is felt 50 ms later",
            all(v.size and float(v.max()) > 0.05 and float(v.min()) >= 0.0 for v in lags.values()),
        ),
        "It is late by the delays of both ways, that of the command and that of the force; where "
        "0.2 sin t is negative, and cut to zero, there is no delay.",
    )
