"""What the couplings on devices that exist show, by criteria of our own."""

from __future__ import annotations

import xarray as xr

from scara_drake.experiments.claim import OURS, Claim, Criterion
from scara_drake.experiments.quantity import quantity
from scara_drake.operator.kinesthetic_devices import OWN

DIRECT, TDPA, WEAK = "direct", "TDPA", "touch"
FULL, NATURAL = "full", "natural"
FAR = 10.0  # times a limit
MOSTLY = 0.5  # share of the press
ALIKE = 0.02  # share of a force


def claims(data: xr.Dataset) -> list[Claim]:
    """Say what was found, as far as it was run; see `devices.run` for the data."""
    made = [_meters(data)]
    if TDPA in data.coupling.values:
        made = [_tdpa(data.sel(coupling=TDPA)), *made]
    if {OWN, WEAK} <= set(data.device.values):
        if DIRECT in data.coupling.values:
            made.append(_hidden(data.sel(coupling=DIRECT, scale=FULL)))
        if TDPA in data.coupling.values:
            made.append(_cut(data.sel(coupling=TDPA)))
    return made


def _tdpa(data: xr.Dataset) -> Claim:
    return Claim(
        "TDPA is stable on every device, at full scale and at the device's own",
        None,
        (
            quantity(int(data.stable.sum()), f"of {data.stable.size} presses", "stable"),
            quantity(1e3 * data.energy_margin.min(), "mJ", "left of the reserve, at least"),
        ),
        Criterion(
            "stable in every press, and no more energy given out than its reserve and what the "
            "counts of the encoders can hide",
            bool(data.stable.all()) and bool((data.energy_margin >= -data.meter_bound).all()),
        ),
        "It is told what went through the device's port, whatever device that is. A light one "
        "with a coarse encoder buzzes first, and that uses up most of the reserve.",
        OURS,
    )


def _meters(data: xr.Dataset) -> Claim:
    coarse = data.where(data.meter_bound > 0.0, drop=True)
    return Claim(
        "The energy that is metered by counts is that of the true motion, but for half a count "
        "times all that the force changes by",
        None,
        (
            quantity(1e3 * data.meter_error.max(), "mJ", "apart, at most"),
            quantity(1e3 * data.meter_bound.max(), "mJ", "largest bound"),
        ),
        Criterion(
            "within the bound in every run on a device with encoders",
            coarse.meter_error.size > 0
            and bool((data.meter_error <= data.meter_bound * (1.0 + 1e-9)).all()),
        ),
        "By parts the sum of f (e' - e), e the rounding, is one of e (f' - f).",
        OURS,
    )


def _hidden(data: xr.Dataset) -> Claim:
    own, weak = data.sel(device=OWN), data.sel(device=WEAK)
    thrown = ~own.stable.astype(bool)
    return Claim(
        "A weak device hides that a coupling is unstable: it cannot push the hand away",
        None,
        (
            quantity(int(thrown.sum()), f"of {thrown.size}", "unstable on the own device"),
            quantity(weak.asked.min(), "N", "asked of the Touch at rest, at least"),
            quantity(weak.felt.max(), "N", "that it has", "up to"),
        ),
        Criterion(
            "position up and force down is unstable on the device of 40 N and comes to rest on the "
            f"Touch, over every channel, where it is asked for more than {FAR:g} times its limit",
            bool(thrown.all())
            and bool(weak.stable.all())
            and bool((weak.asked > FAR * weak.felt).all()),
        ),
        "Its actuators are at their limit nearly all the time, so the loop is open.",
        OURS,
    )


def _cut(data: xr.Dataset) -> Claim:
    full, natural = data.sel(scale=FULL), data.sel(scale=NATURAL)
    weak = full.sel(device=WEAK)
    return Claim(
        "What 40 N hide: at full scale a Touch is at its limit, at its own scale it is not",
        None,
        (
            quantity(1e2 * weak.cut.max(), "%", "of the press the Touch is at its limit", "up to"),
            quantity(1e2 * full.sel(device=OWN).cut.max(), "%", "the own device", "up to"),
            quantity(1e2 * natural.cut.max(), "%", "any device at its own scale", "up to"),
        ),
        Criterion(
            f"TDPA at full scale has the Touch at its limit in more than {1e2 * MOSTLY:g} % of the "
            "press over some channel and never the own device; at its own scale no device is cut, "
            f"and each feels the tool within {1e2 * ALIKE:g} %",
            bool((weak.cut > MOSTLY).any())
            and not bool(full.sel(device=OWN).cut.any())
            and not bool(natural.cut.any())
            and bool((abs(natural.felt / natural.tool - 1.0) < ALIKE).all()),
        ),
        "A hand of 150 N/m over 4 cm presses with up to 6 N, and a Touch has 3.3 N.",
        OURS,
    )
