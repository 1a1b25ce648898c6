"""What the table of the couplings shows, by criteria of our own."""

from __future__ import annotations

import xarray as xr

from scara_drake.experiments.claim import OURS, Claim, Criterion
from scara_drake.experiments.quantity import quantity
from scara_drake.experiments.teleoperation.ideal_slave import stable_delay
from scara_drake.scenario import load_scenario
from scara_drake.wiring.bilateral import own_latency

DIRECT, FULL, TENTH, MODEL = "direct", "TDPA", "TDPA, force x 0.1", "model-mediated"
WAVES = "wave variables"
SCENARIO = "bilateral"
HELD, APART = 1.0, 0.2  # [s], and share of the force
PEAK = {FULL: 40.0, TENTH: 10.0}  # [N]
DRIFT = 1e-3  # [m]
# Figures that tell what a coupling costs: unit, its scale, and what it is.
COSTS = {
    "energy_margin": ("J", 1.0, "energy left"),
    "position_error": ("mm", 1e3, "position error while pressing"),
    "shown": ("N", 1.0, "force shown while pressing"),
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
    if MODEL in names:
        made.append(_model(data))
    if FULL in names and MODEL in names:
        made.append(_cost(data))
    if WAVES in names and FULL in names:
        made += _jitter(data)
    return made


def _jitter(data: xr.Dataset) -> list[Claim]:
    """What jitter costs the waves, and what a buffer gives back."""
    error = 1e3 * data.delayed_position_error
    short, long, jittery, behind = (error.sel(coupling=WAVES, delays=name) for name in data.delays)
    tdpa = error.sel(coupling=FULL)
    spread = float(tdpa.max() - tdpa.min())
    made = [
        Claim(
            "Half a millisecond of jitter costs the waves more than twenty more of delay, and "
            "TDPA nothing",
            None,
            tuple(
                quantity(
                    {
                        str(n): float(e)
                        for n, e in zip(data.delays.values, error.sel(coupling=c), strict=True)
                    },
                    "mm",
                    f"tool from master, {c}",
                )
                for c in (WAVES, FULL)
            ),
            Criterion(
                "the waves' error while pressing grows more from the jitter than from the delay, "
                "through a buffer by less than a tenth of that; TDPA's differs by less than 0.1 mm",
                bool(jittery - short > long - short > 0.0)
                and bool(abs(behind - short) < 0.1 * (jittery - short))
                and spread < 0.1,
            ),
            "A wave that is overtaken is never played. What it leaves the term against drift "
            "spends at once, so a tick without a packet is one without motion; see drift_gain of "
            "`WaveVariables`. TDPA sends positions, of which the newest is enough.",
            OURS,
        )
    ]
    return made + _buffer(data)


def _buffer(data: xr.Dataset) -> list[Claim]:
    known = data.sel(coupling=WAVES).dropna("preset", subset=["buffered_contact"])
    if not known.preset.size:
        return []
    wall = known.sel(case="wall")
    off = abs(known.buffered_transparency_error / known.buffered_closed_form - 1.0)
    return [
        Claim(
            "Through the buffer that is recommended the waves keep in contact",
            None,
            (
                quantity(_by_preset(1e2 * wall.contact), "%", "in contact without a buffer"),
                quantity(_by_preset(1e2 * wall.buffered_contact), "%", "and through it"),
                quantity(_by_preset(1e3 * wall.position_error), "mm", "error without a buffer"),
                quantity(_by_preset(1e3 * wall.buffered_position_error), "mm", "and through it"),
                quantity(1e2 * off, "%", "impedance from its closed form, through it", missing="-"),
            ),
            Criterion(
                "in contact all the time and with a smaller error over each channel with jitter, "
                "where its impedance was swept within 5 % of the closed form",
                bool((wall.buffered_contact > 0.999).all())
                and bool((wall.buffered_position_error < wall.position_error).all())
                and bool((off.isnull() | (off < 0.05)).all()),
            ),
            "Behind a buffer jitter is delay.",
            OURS,
        )
    ]


def _by_preset(values: xr.DataArray) -> dict[str, float]:
    return {str(n): float(v) for n, v in zip(values.preset.values, values.values, strict=True)}


def _direct(data: xr.Dataset) -> Claim:
    seen = _pressed(data).sel(coupling=DIRECT)
    unstable = ~seen.stable.astype(bool)
    bears = stable_delay()
    scenario = load_scenario(SCENARIO)
    own = own_latency(scenario)
    return Claim(
        "Position up, force down, at full scale: unstable against the wall over every channel, and "
        "with our arm over none as well",
        None,
        (
            quantity(int(unstable.sum()), f"of {unstable.size} presses", "unstable"),
            quantity(seen.peak, "N", "peak at the master"),
            quantity(1e3 * own, "ms", "own latency of the loop, without a channel"),
            quantity(1e3 * bears, "ms", "there and back that an ideal slave bears"),
        ),
        Criterion(
            "unstable in every press, that is, while the hand rests the device has more energy of "
            "motion than the hand's spring could give, or the force ripples by more than a quarter "
            "of what the hand could press with; and an ideal slave, which is where the device is, "
            "bears less than the loop's own latency, but more than none",
            bool(unstable.all()) and unstable.size > 0 and 0.0 < bears < own,
        ),
        "The force comes back late, and pushes the device on the way out as on the way in. Without "
        "any delay the coupling is just stable: the arm, its limiter and the ticks are what makes "
        "it late here.",
        OURS,
    )


def _model(data: xr.Dataset) -> Claim:
    pressed = _pressed(data).sel(coupling=MODEL)
    steady = pressed.where(pressed.age_p99.max("case") < HELD, drop=True)
    off = abs(steady.felt / steady.shown - 1.0)
    return Claim(
        "Model-mediated: the tool presses with what is shown",
        None,
        (
            quantity(steady.shown, "N", "shown, in the steady part of the press"),
            quantity(steady.felt, "N", "at the tool"),
            quantity(1e2 * off.max(), "%", "apart", "up to"),
        ),
        Criterion(
            f"within {1e2 * APART:g} % in every press over a channel whose information is no older "
            f"than {HELD:g} s, so that the hold is longer than the way there and back",
            bool((off < APART).all()) and off.size > 0,
        ),
        "The tool is pushed with the force that the master shows while something touches it.",
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
