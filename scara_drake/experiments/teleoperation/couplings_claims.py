"""What the table of the couplings shows, by criteria of our own."""

from __future__ import annotations

import xarray as xr

from scara_drake.experiments.claim import NOT_COMPARABLE, Claim, span

DIRECT, FULL, TENTH, MODEL = "direct", "TDPA", "TDPA, force x 0.1", "model-mediated"
DELAYED = 4.9e-3  # [s], mean age of information from which a channel counts as delayed
PEAK = {FULL: 40.0, TENTH: 10.0}  # [N]
DRIFT = 1e-3  # [m]


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
    return _claim(
        "Position up, force down, at full scale: unstable against the wall from 5 ms on",
        f"unstable in {int(unstable.sum())} of {unstable.size} presses; peak at the master "
        f"{span(seen.peak.values.ravel(), 0)} N",
        bool(unstable.all()) and unstable.size > 0,
        "unstable in every press over a channel with 5 ms or more, that is, while the hand rests "
        "the device has more energy of motion than the hand's spring could give, or the force "
        "ripples by more than a quarter of what the hand could press with.",
    )


def _tdpa(data: xr.Dataset, name: str) -> Claim:
    everywhere = data.sel(coupling=name)
    pressed = _pressed(everywhere)
    stable = everywhere.stable
    worst = pressed.drift.where(pressed.drift == pressed.drift.max(), drop=True)
    met = bool(stable.all()) and bool((pressed.peak < PEAK[name]).all())
    met = met and bool((pressed.drift < DRIFT).all())
    return _claim(
        f"{name}: no channel makes it unstable, and it lets go without a drift",
        f"stable in {int(stable.sum())} of {stable.size} runs; peak at the master up to "
        f"{float(pressed.peak.max()):.1f} N; drift after the release up to "
        f"{1e3 * float(pressed.drift.max()):.2f} mm ({worst.preset.values[0]}, "
        f"{worst.case.values[0]})",
        met,
        f"stable in every run, and pressed with and without loss a peak below {PEAK[name]:g} N and "
        f"a drift below {1e3 * DRIFT:g} mm.",
    )


def _cost(data: xr.Dataset) -> Claim:
    pressed = _pressed(data)
    tdpa, model = (pressed.sel(coupling=name) for name in (FULL, MODEL))
    passive = bool((tdpa.energy_margin > -1e-3).all())
    behind = bool((tdpa.position_error > 2.0 * model.position_error).all())
    transparent = "" if bool(data.transparency_error.isnull().all()) else (
        "; the impedance of the wall is felt wrong by "
        f"{span(_known(tdpa.transparency_error))} decades, model-mediated by "
        f"{span(_known(model.transparency_error))}"
    )  # fmt: skip
    return _claim(
        "Passivity is not transparency: what TDPA costs",
        f"least energy left {float(tdpa.energy_margin.min()):.3f} J, model-mediated "
        f"{float(model.energy_margin.min()):.3f} J; position error while pressing "
        f"{span(tdpa.position_error.values.ravel(), 1, 1e3)} mm, model-mediated "
        f"{span(model.position_error.values.ravel(), 1, 1e3)} mm; force error "
        f"{span(tdpa.force_error.values.ravel())} N, model-mediated "
        f"{span(model.force_error.values.ravel())} N; force ripple "
        f"{span(tdpa.ripple.values.ravel())} N, model-mediated "
        f"{span(model.ripple.values.ravel())} N{transparent}",
        passive and behind,
        "TDPA makes no energy over any channel, and its tool is more than twice as far from the "
        "master as that of the model-mediated coupling over all of them.",
    )


def _pressed(data: xr.Dataset) -> xr.Dataset:
    return data.sel(case=[case for case in data.case.values if case != "free"])


def _known(values: xr.DataArray) -> list[float]:
    return [float(value) for value in values.values.ravel() if value == value]


def _claim(statement: str, ours: str, met: bool, criterion: str) -> Claim:
    verdict = "met" if met else "not met"
    reason = f"Criterion of our own, {verdict}: {criterion}"
    return Claim(statement, "not treated", ours, NOT_COMPARABLE, reason)
