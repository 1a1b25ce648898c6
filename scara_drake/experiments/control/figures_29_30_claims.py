"""What the readings of Figures 29 and 30 show, judged by the paper's statements."""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import Final

import xarray as xr

from scara_drake import joints, robot
from scara_drake.control.integral_sliding_mode import IntegralSlidingMode
from scara_drake.control.process_delay import AMPLITUDE
from scara_drake.experiments.claim import Claim, Criterion
from scara_drake.experiments.quantity import Quantity, quantity
from scara_drake.experiments.reading import OpenQuestion, Reading

JOINT: Final = "theta2"
INDEX = joints.JOINT_NAMES.index(JOINT)
PLAIN, HARD = "ISMC", "SMC, high gain"
HIGH = 700.0  # gain of the SMC in Table 10
ALONE = "B alone"
AS_PUBLISHED = ("A", "B", "C")  # readings with the paper's numbers, on the whole arm
SINE = (0.7854, 1.25)  # of the reference of joint 2 in joint_sine [rad], [rad/s]
PEAK = math.sqrt(2.0) * AMPLITUDE
RHO = IntegralSlidingMode().rho[INDEX]  # Table 12
REDUCED: Final = "B reduced"
# The peak at the share of the drive's largest u that it has of rho.
REDUCED_AMPLITUDE = AMPLITUDE / RHO * joints.EFFORT[INDEX] / float(robot.nominal_inertias()[INDEX])
# What each does, and the peak of the perturbation that it is [rad/s²].
MEANINGS: Final = {
    "A": ("delays of the loop, zeta of the effort and d of the state, in samples of 1 ms", 0.0),
    "B": ("a perturbation of the whole arm, zeta + d in the units of u", PEAK),
    REDUCED: (
        "the same, its peak at the share of the drive that it has of rho",
        math.sqrt(2.0) * REDUCED_AMPLITUDE,
    ),
    ALONE: ("the same as B on a joint without arm and without a limit of effort", PEAK),
    "C": ("a delay zeta of the command on its way to the controller, in samples of 1 ms", 0.0),
}

SATISFACTORY = 0.01  # of the amplitude of the reference
TIMES_WORSE = 2.0
LAG = 0.01  # [s], a delay of the response that a figure shows
UNDERSHOOT = 0.02  # of the amplitude


def claims(data: xr.Dataset, only: Collection[str] | None = None) -> list[Claim]:
    """Judge each statement by the readings that suit it.

    A reading in which the error grows beyond the amplitude of the reference is lost: it has no
    response to speak of, and meets no criterion.

    Args:
        data: largest error [rad], its share inside the window, lag [s] and undershoot of each
            reading and controller; correlation of the error of a joint alone with the size and
            with the rate of the perturbation.
        only: the readings to judge by; None is all.
    """
    names = [str(name) for name in data.reading.values if name != "none"]
    names = [name for name in names if only is None or name in only]
    largest = data.largest
    lost = _where(largest.max("controller") > SINE[0], names)
    readings = [name for name in names if name not in lost]
    error = largest.sel(controller=PLAIN)
    good = _where(error <= SATISFACTORY * SINE[0], readings)
    ratio = largest.sel(controller=HARD) / error
    worse = _where(ratio >= TIMES_WORSE, readings)
    dragged, alike = _dragged(data, readings)
    share = data.share.sel(controller=PLAIN)
    seen = _where((share >= TIMES_WORSE) & (error >= 1e-3 * SINE[0]), readings)
    met = {name: sum(name in x for x in (good, worse, dragged, seen)) for name in names}
    return [
        _satisfactory(_listed(error, readings, "rad", "largest error"), good, lost, largest),
        _errs_more(
            _listed(ratio, readings, "", f"SMC with {HIGH:g} over ISMC"),
            good,
            worse,
            _listed(largest.sel(controller="SMC"), readings, "rad"),
        ),
        _lags(data, readings, dragged, alike),
        _window(data, _listed(share, readings, "", "error inside over outside"), seen),
        Claim(
            "The place and the unit of zeta(t) and d(t)",
            None,
            quantity(met, "of 4 criteria"),
            None,
            "So many of the criteria above suit each reading; the paper has no statement to "
            "compare with.",
        ),
    ]


def question(data: xr.Dataset) -> OpenQuestion:
    """Show what each reading by itself makes of the statements; see `claims` for the data."""
    readings = []
    for name, (meaning, peak) in MEANINGS.items():
        judged = claims(data, [name])
        share = peak * float(robot.nominal_inertias()[INDEX]) / joints.EFFORT[INDEX]
        asked = (quantity(peak / RHO, "rho"), quantity(share, "of the drive"))
        error = data.largest.sel(reading=name)
        late = data.lag.sel(reading=name, controller=HARD).where(error.max() <= SINE[0])
        found = {
            "peak of the perturbation": asked[: 1 if name == ALONE else 2] if peak else "none",
            "error of ISMC": quantity(1e3 * error.sel(controller=PLAIN), "mrad"),
            f"error of SMC, gain {HIGH:g}": quantity(1e3 * error.sel(controller=HARD), "mrad"),
            "lag of SMC": quantity(1e3 * late, "ms", missing="lost"),
            "SMC errs more": judged[1].verdict,
            "SMC lags": judged[2].verdict,
            "the window": judged[3].verdict,
        }
        readings.append(Reading(name, meaning, found, judged[0].verdict, name == REDUCED))
    return OpenQuestion(
        "What are zeta(t) = 100 sin t and d(t) = 100 cos t, and where do they act?",
        judged[0].statement,
        tuple(readings),
    )


def _satisfactory(
    errors: Quantity, good: list[str], lost: list[str], largest: xr.DataArray
) -> Claim:
    allowed = 1e3 * SATISFACTORY * SINE[0]
    needed = PEAK * float(robot.nominal_inertias()[INDEX])
    delayed = float(largest.sel(reading="A", controller=PLAIN))
    return Claim(
        "ISMC stays satisfactory under zeta(t) and d(t)",
        "satisfactory",
        (errors, f"within: {_names(good)}", f"lost: {_names(lost)}"),
        Criterion(
            f"within {allowed:.1f} mrad, {100 * SATISFACTORY:g} % of the amplitude, by one of the "
            "readings with the paper's numbers on the arm (in kind: by any); the share is ours",
            _published(good),
            bool(good),
        ),
        f"With the paper's numbers the arm errs by {_published_errors(largest)}. A puts up "
        f"to {AMPLITUDE:g} ms into the loop, where the error reaches {delayed:.2g} rad. "
        f"B asks {1e-3 * needed:.0f} kN m of a drive of {1e-3 * joints.EFFORT[INDEX]:.0f} kN m.",
    )


def _errs_more(ratios: Quantity, good: list[str], worse: list[str], soft: Quantity) -> Claim:
    return Claim(
        "SMC errs more than ISMC, even with a high gain",
        "higher errors",
        (ratios, f"at least {TIMES_WORSE:g} times: {_names(worse)}"),
        Criterion(
            f"at least {TIMES_WORSE:g} times the error where ISMC is satisfactory, by a reading "
            "with the paper's numbers on the arm (in kind: by any); the factor is ours",
            _published([name for name in worse if name in good]),
            bool(worse),
        ),
        f"SMC with the gain of ISMC errs by: {soft}.",
    )


def _dragged(data: xr.Dataset, readings: list[str]) -> tuple[list[str], list[str]]:
    """Readings in which SMC lags and undershoots and ISMC does not, and where SMC does either."""
    late, lack = data.lag >= LAG, data.undershoot >= UNDERSHOOT
    drags = _where((late & lack).sel(controller=HARD), readings)
    free = _where(~(late | lack).sel(controller=PLAIN), readings)
    alike = _where((late | lack).sel(controller=HARD), readings)
    return [name for name in drags if name in free], alike


def _lags(data: xr.Dataset, readings: list[str], dragged: list[str], alike: list[str]) -> Claim:
    late, lack = 1e3 * data.lag, 1e2 * data.undershoot
    return Claim(
        "SMC lags and undershoots",
        "significant delays, undershoots",
        (
            _listed(late.sel(controller=HARD), readings, "ms", f"lag, gain {HIGH:g}"),
            _listed(lack.sel(controller=HARD), readings, "%", "undershoot"),
            f"both, and ISMC neither: {_names(dragged)}",
            f"one of them: {_names(alike)}",
        ),
        Criterion(
            f"a lag of {1e3 * LAG:.0f} ms and an undershoot of {1e2 * UNDERSHOOT:.0f} % that ISMC "
            "has not, by a reading with the paper's numbers on the arm (in kind: one of them, by "
            "any reading, and ISMC may have it too); both bounds are ours",
            _published(dragged),
            bool(alike),
        ),
        "There ISMC lags by "
        f"{quantity(late.sel(controller=PLAIN, reading=readings), 'ms')} and undershoots by "
        f"{quantity(lack.sel(controller=PLAIN, reading=readings), '%')}.",
    )


def _window(data: xr.Dataset, shares: Quantity, seen: list[str]) -> Claim:
    trough, first, second = (math.pi * n for n in (1.25, 0.25, 2.25))
    return Claim(
        "ISMC errs and chatters from 2.7 to 4.8 s",
        "certain errors in that window",
        (shares, f"in that window: {_names(seen)}"),
        Criterion(
            f"at least {TIMES_WORSE:g} times as large inside, and above 0.1 % of the amplitude, by "
            "a reading with the paper's numbers on the arm (in kind: by any); both bounds are ours",
            _published(seen),
            bool(seen),
        ),
        f"zeta + d has its trough of -{PEAK:.0f} at {trough:.2f} s, but a peak of {PEAK:.0f} at "
        f"{first:.2f} s and {second:.2f} s too; and on a joint alone the error of ISMC correlates "
        f"by {float(data.size_correlation):.2f} with the perturbation, by "
        f"{float(data.rate_correlation):.2f} with its rate.",
    )


def _published(readings: list[str]) -> bool:
    return any(name in AS_PUBLISHED for name in readings)


def _published_errors(largest: xr.DataArray) -> Quantity:
    own = largest.sel(controller=PLAIN)
    known = [name for name in AS_PUBLISHED if name in own.reading.values]
    return _listed(own, known, "rad")


def _listed(values: xr.DataArray, readings: list[str], unit: str, label: str = "") -> Quantity:
    return quantity({name: float(values.sel(reading=name)) for name in readings}, unit, label)


def _where(condition: xr.DataArray, readings: list[str]) -> list[str]:
    return [name for name in readings if bool(condition.sel(reading=name))]


def _names(readings: list[str]) -> str:
    return " and ".join(readings) or "none"
