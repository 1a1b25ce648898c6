"""What the table of the couplings shows, by criteria of our own."""

from __future__ import annotations

import xarray as xr

from scara_drake.experiments.claim import OURS, Claim, Criterion
from scara_drake.experiments.quantity import quantity

DIRECT, FULL, TENTH, MODEL = "direct", "TDPA", "TDPA, force x 0.1", "model-mediated"
DELAYED = 4.9e-3  # [s], mean age of information from which a channel counts as delayed
PEAK = {FULL: 40.0, TENTH: 10.0}  # [N]
DRIFT = 1e-3  # [m]
# Figures that tell what a coupling costs: unit, its scale, and what it is.
COSTS = {
    "energy_margin": ("J", 1.0, "energy left"),
    "position_error": ("mm", 1e3, "position error while pressing"),
    "force_error": ("N", 1.0, "force error"),
    "ripple": ("N", 1.0, "force ripple"),
    "transparency_error": ("decades", 1.0, "impedance of the wall felt wrong by"),
}


def claims(data: xr.Dataset) -> list[Claim]:
    """Say what was found, as far as its couplings were run; see `couplings.run` for the data."""
    if not _pressed(data).case.size:
        return []
    names = data.coupling.values
    made = [_direct(data)] if DIRECT in names else []
    made += [_tdpa(data, name) for name in PEAK if name in names]
    if FULL in names and MODEL in names:
        made.append(_cost(data))
    return made


def _direct(data: xr.Dataset) -> Claim:
    pressed = _pressed(data).sel(coupling=DIRECT)
    delayed = pressed.age_mean.max("case") >= DELAYED
    seen = pressed.where(delayed, drop=True)
    unstable = ~seen.stable.astype(bool)
    return Claim(
        "Position up, force down, at full scale: unstable against the wall from 5 ms on",
        None,
        (
            quantity(int(unstable.sum()), f"of {unstable.size} presses", "unstable"),
            quantity(seen.peak, "N", "peak at the master"),
        ),
        Criterion(
            "unstable in every press over a channel with 5 ms or more, that is, while the hand "
            "rests the device has more energy of motion than the hand's spring could give, or the "
            "force ripples by more than a quarter of what the hand could press with",
            bool(unstable.all()) and unstable.size > 0,
        ),
        "The force comes back late, and pushes the device on the way out as on the way in.",
        OURS,
    )


def _tdpa(data: xr.Dataset, name: str) -> Claim:
    everywhere = data.sel(coupling=name)
    pressed = _pressed(everywhere)
    stable = everywhere.stable
    worst = pressed.drift.where(pressed.drift == pressed.drift.max(), drop=True)
    return Claim(
        f"{name}: no channel makes it unstable, and it lets go without a drift",
        None,
        (
            quantity(int(stable.sum()), f"of {stable.size} runs", "stable"),
            quantity(pressed.peak.max(), "N", "peak at the master", "up to"),
            quantity(1e3 * pressed.drift.max(), "mm", "drift after the release", "up to"),
        ),
        Criterion(
            "stable in every run, and pressed with and without loss a peak below "
            f"{PEAK[name]:g} N and a drift below {1e3 * DRIFT:g} mm",
            bool(stable.all())
            and bool((pressed.peak < PEAK[name]).all())
            and bool((pressed.drift < DRIFT).all()),
        ),
        f"The largest drift is left over {worst.preset.values[0]}, in the case "
        f"{worst.case.values[0]}.",
        OURS,
    )


def _cost(data: xr.Dataset) -> Claim:
    pressed = _pressed(data)
    tdpa, model = (pressed.sel(coupling=name) for name in (FULL, MODEL))
    measured = [
        quantity(scale * one[figure], unit, f"{long_name}, {name}")
        for figure, (unit, scale, long_name) in COSTS.items()
        for name, one in ((FULL, tdpa), (MODEL, model))
        if not bool(one[figure].isnull().all())
    ]
    return Claim(
        "Passivity is not transparency: what TDPA costs",
        None,
        tuple(measured),
        Criterion(
            "TDPA makes no energy over any channel, and its tool is more than twice as far from "
            "the master as that of the model-mediated coupling over all of them",
            bool((tdpa.energy_margin > -1e-3).all())
            and bool((tdpa.position_error > 2.0 * model.position_error).all()),
        ),
        "A passive coupling gives way where it could make energy; a model at the master does not.",
        OURS,
    )


def _pressed(data: xr.Dataset) -> xr.Dataset:
    return data.sel(case=[case for case in data.case.values if case != "free"])
