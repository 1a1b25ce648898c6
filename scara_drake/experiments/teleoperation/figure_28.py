"""Figure 28: what the operator feels with and without the varying delay."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import xarray as xr

from scara_drake import metrics
from scara_drake.experiments.claim import Claim, Criterion, Experiment, within
from scara_drake.experiments.quantity import Value, quantity
from scara_drake.experiments.reading import OpenQuestion, Reading
from scara_drake.experiments.teleoperation.delay_readings import DELAYS
from scara_drake.recordings.labels import labelled
from scara_drake.scenario import load_scenario
from scara_drake.simulation.run import simulate

SCENARIO = "teleoperation"
# The first is the reference; the others are the readings of 0.2 sin t, "0-2 s".
CHANNELS: Final[dict[str, dict[str, Any]]] = {
    "none": {"channel.preset": "none"},
    **{name: reading.overrides for name, reading in DELAYS.items()},
}
FORMULA = "paper"  # 0.2 sin t as it stands
PAPER_LONGEST = quantity(2.0, "s", bound="from 0 to")
TOUCH = 5.0  # [N], from which the force is felt
SAMPLE = 1e-3  # [s]


def run(seed: int = 0, duration: float = 30.0) -> Experiment:
    """Simulate the recorded operator, who presses a wall from 16 s on, over each channel.

    Args:
        seed: of the scenario.
        duration: [s].
    """
    runs = [
        simulate(load_scenario(SCENARIO, {**channel, "seed": seed}), duration=duration)
        for channel in CHANNELS.values()
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
    return Experiment("Figure 28", data, claims(data), questions(data))


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
    delayed = list(DELAYS)
    peak = data.force.max("time")
    return [
        _lags(data, float(peak.max())),
        _later(data, {name: late(data, name) for name in delayed}),
        _range(data),
        Claim(
            "The delay does not destabilise the haptic loop",
            "not said; shown by the figure",
            quantity(peak, "N", "largest force over all channels"),
            None,
            "The operator is a recording and vibration does not move the stick, so no loop is "
            "closed that could lose its stability, and the paper does not speak of it.",
        ),
    ]


def questions(data: xr.Dataset) -> tuple[OpenQuestion, ...]:
    """Show what the delay's readings make of the claims; see `run` for the data."""
    readings = []
    for name, reading in DELAYS.items():
        delay, lags = data.delay.sel(channel=name), late(data, name)
        claim = _range(data, name)
        found: dict[str, Value] = {
            "delay each way": quantity(delay.round(6), "s"),
            "no delay": quantity(100 * float((delay == 0.0).mean()), "% of the time"),
            "touch and release felt later by": quantity(lags, "s", missing="not in time"),
            "force felt, off by": quantity(
                float(abs(data.force_felt.sel(channel=name) - data.force.sel(channel=name)).max()),
                "N",
                "from the force at the tool",
                "up to",
            ),
            "felt later": _later(data, {name: lags}).verdict,
        }
        readings.append(
            Reading(reading.name, reading.meaning, found, claim.verdict, name == FORMULA)
        )
    question = "Which delay is t_d = 0.2 sin t, called 0 to 2 s, and of which way?"
    return (OpenQuestion(question, claim.statement, tuple(readings)),)


def _range(data: xr.Dataset, name: str = FORMULA) -> Claim:
    longest = quantity(data.delay.sel(channel=name).max(), "s", name)
    spans = (quantity(data.delay.sel(channel=one), "s", one) for one in DELAYS)
    return Claim(
        "t_d = 0.2 sin t changes from 0 to 2 s",
        PAPER_LONGEST,
        tuple(spans),
        Criterion(
            "the longest delay of the formula within 10 % of it, a share of ours",
            within(longest, 0.1),
        ),
        "0.2 sin t is within ±0.2 s and a delay is not negative: the formula and the range that "
        "the paper gives it cannot both hold. 0 to 2 s is 1 + sin t.",
    )


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
            "within 5 % of the largest force, a share of ours, at every sample, over each channel",
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
            "no touch or release is felt earlier, and one is felt 50 ms later, which is ours",
            all(v.size and float(v.max()) > 0.05 and float(v.min()) >= 0.0 for v in lags.values()),
        ),
        "It is late by the delays of both ways, that of the command and that of the force; where "
        "0.2 sin t is negative, and cut to zero, there is no delay.",
    )
