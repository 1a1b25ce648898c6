"""What Ferrell, and Hannaford and Kim, say of operators under delay, and what became of it here."""

from __future__ import annotations

from typing import Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from scara_drake.experiments.claim import OURS, Claim, Criterion, within
from scara_drake.experiments.quantity import Quantity

Array = NDArray[np.float64]

DRAWS: Final = 2000  # of the bootstrap
LEVEL: Final = (2.5, 97.5)  # [%], of its intervals
STRAIGHT: Final = 0.95  # share of the variance of the means over the delay that a line explains


def claims(data: xr.Dataset) -> list[Claim]:
    """Return the claims on the data of `operators_under_delay.run`."""
    return [
        *(_law(data, kind) for kind in data.reach_kind.values),
        _accuracy(data),
        *(_straight(data, field) for field in ("seconds", "squared_force")),
        *(_compliance(data, field) for field in ("seconds", "squared_force")),
        _following(data),
    ]


def slopes(delays: Array, values: Array) -> Array:
    """Return the slope of values (..., delay) over the delay, least squares, each (...)."""
    apart = delays - delays.mean()
    return np.asarray(values @ apart / (apart @ apart))


def interval(values: Array, seed: int = 0) -> tuple[float, float]:
    """Return the 95 % interval of the mean of values (person,), by the bootstrap."""
    drawn = np.random.default_rng(seed).integers(values.size, size=(DRAWS, values.size))
    low, high = np.percentile(values[drawn].mean(axis=1), LEVEL)
    return float(low), float(high)


def straightness(delays: Array, means: Array) -> float:
    """Return the share of the variance of means (delay,) that a straight line explains."""
    line = np.polyval(np.polyfit(delays, means, 1), delays)
    spread = float(((means - means.mean()) ** 2).sum())
    return 1.0 - float(((means - line) ** 2).sum()) / spread if spread > 0.0 else 0.0


def _names(delays: Array) -> tuple[str, ...]:
    return tuple(f"{delay:g} s" for delay in delays)


def _law(data: xr.Dataset, kind: str) -> Claim:
    delays = data.reach_delay.values
    seconds = data.reach_seconds.sel(reach_kind=kind).values
    moves = float(data.reach_moves.sel(reach_kind=kind, reach_delay=0.0).mean())
    measured = seconds.mean(axis=1)
    law = measured[0] + moves * delays[1:]
    found, names = slopes(delays, seconds.T), _names(delays[1:])
    low, high = interval(found)
    took = Quantity(tuple(measured[1:]), "s", names=names)
    return Claim(
        f"Ferrell: T = T_0 + N (reaction + delay), N and T_0 from the run without a delay ({kind} "
        "places)",
        Quantity(tuple(law), "s", "Ferrell's law", names=names),
        took,
        Criterion(
            "every time within 10 %, ours; in kind: within 25 %, ours",
            within(took, 0.10),
            within(took, 0.25),
        ),
        f"Without a delay {moves:.2f} moves were made in {measured[0]:.1f} s, a reaction each "
        f"among them; the time grows by {found.mean():.2f} s for a second of delay, 95 % interval "
        f"{low:.2f} to {high:.2f}. Nearly by construction: who moves and waits takes a delay "
        "more a move. The person's numbers are those without a delay, the waiting rule is not; "
        "tested is that the work needs no more moves, and a wait no more than the delay.",
        OURS,
    )


def _accuracy(data: xr.Dataset) -> Claim:
    moves = data.reach_moves.sel(reach_delay=0.0)
    more = moves.sel(reach_kind="fine").values - moves.sel(reach_kind="coarse").values
    low, high = interval(more)
    means = tuple(float(moves.sel(reach_kind=kind).mean()) for kind in ("coarse", "fine"))
    return Claim(
        "Ferrell: the finer the places, the more moves",
        None,
        Quantity(means, "moves", names=("coarse", "fine")),
        Criterion(
            "the interval of the difference is above zero", low > 0.0, float(more.mean()) > 0.0
        ),
        f"The aim scatters with the way; {more.mean():.2f} moves more for a tolerance of 3 mm "
        f"in place of 8 mm, 95 % interval {low:.2f} to {high:.2f}.",
        OURS,
    )


LAWS: Final = {
    "seconds": ("completion time", "s of work a second of delay"),
    "squared_force": ("the sum of squared force", "N² s a second of delay"),
}


def _slope_text(found: Array, unit: str) -> str:
    low, high = interval(found)
    return f"{found.mean():.1f} {unit}, 95 % interval {low:.1f} to {high:.1f}"


def _straight(data: xr.Dataset, field: str) -> Claim:
    delays, (name, unit) = data.press_delay.values, LAWS[field]
    values = data[f"press_{field}"].sel(press_kind="stiff").values
    found, line = slopes(delays, values.T), straightness(delays, values.mean(axis=1))
    low, _ = interval(found)
    done = bool(np.isfinite(data.press_seconds.sel(press_kind="stiff")).all())
    begun = data.press_moves.sel(press_kind="stiff").values
    moves, first = float(slopes(delays, begun.T).mean()), float(begun[0].mean())
    return Claim(
        f"Hannaford and Kim: {name} grows about linearly with the delay",
        None,
        Quantity((line,), "", "share of the variance of the means that a line explains"),
        Criterion(
            "all have done their work, the interval of the slope is above zero, and a line "
            "explains 95 %, over our delays, ours; in kind: the slope is above zero",
            done and low > 0.0 and line >= STRAIGHT,
            low > 0.0,
        ),
        f"The slope is {_slope_text(found, unit)}. Only a part of it is the waiting: with a second "
        f"of delay {moves:.1f} moves come to the {first:.1f} without one, and the force comes by "
        "waves, which swing with periods that grow with the delay: that part is the coupling's. "
        "While a delay is a part of the reaction it hides in the waits that are made anyway.",
        OURS,
    )


def _compliance(data: xr.Dataset, field: str) -> Claim:
    delays, (name, unit) = data.press_delay.values, LAWS[field]
    found = {
        kind: slopes(delays, data[f"press_{field}"].sel(press_kind=kind).values.T)
        for kind in ("stiff", "compliant")
    }
    less = found["stiff"] - found["compliant"]
    low, high = interval(less)
    means = tuple(float(values.mean()) for values in found.values())
    moves = {
        kind: float(slopes(delays, data.press_moves.sel(press_kind=kind).values.T).mean())
        for kind in found
    }
    return Claim(
        f"Hannaford and Kim: {name} has a smaller slope where the robot yields",
        None,
        Quantity(means, unit, names=tuple(found)),
        Criterion(
            "the interval of the difference is above zero; in kind: its mean is",
            low > 0.0,
            float(less.mean()) > 0.0,
        ),
        f"It is smaller by {less.mean():.1f}, 95 % interval {low:.1f} to {high:.1f}. Where the "
        f"robot yields, {moves['compliant']:.1f} moves come to the work with a second of delay, "
        f"in place of {moves['stiff']:.1f}: what a move is off by makes less force.",
        OURS,
    )


def _following(data: xr.Dataset) -> Claim:
    delays, seconds = data.follow_delay.values, data.follow_seconds.values[0]
    shares = 100.0 * np.isfinite(seconds).mean(axis=1)
    waiting = float(data.reach_seconds.sel(reach_kind="coarse", reach_delay=0.0).mean())
    first = float(np.nanmean(seconds[0])) if np.isfinite(seconds[0]).any() else np.inf
    return Claim(
        "Who follows without a pause is quicker without a delay, and does not come to an end with "
        "a long one; people then move and wait",
        None,
        Quantity(tuple(shares), "% done", names=_names(delays)),
        Criterion(
            "without a delay all are done, and sooner; with the longest none",
            bool(shares[0] == 100.0 and first < waiting and shares[-1] == 0.0),
            bool(shares[-1] < shares[0]),
        ),
        f"Without a delay it takes {first:.1f} s in place of {waiting:.1f} s. A gain of 2.5/s "
        "bears a quarter of its period, about 0.6 s, reaction included; beyond, the hand swings. A "
        "place counts once it is seen to be near, in passing too, which some swings come to.",
        OURS,
    )
