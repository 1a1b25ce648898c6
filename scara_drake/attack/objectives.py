"""What counts as harm: figures of a run, each with a threshold above which it is a breach."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from scara_drake import metrics
from scara_drake.common import checks
from scara_drake.coupling.tdpa import Tdpa
from scara_drake.metrics import bilateral, hand_press
from scara_drake.scenario import Scenario

Array = NDArray[np.float64]

LAST: Final = 0.1  # [s], end of the run, in which a drift is left
# Of sums of some thousand products of some joules.
ROUNDING: Final = 1e-9  # [J]


@dataclass(frozen=True)
class Objective:
    """A figure of a run that an attack makes large.

    Attributes:
        unit: of it.
        meaning: what it is.
        of: the figure of a scenario and its recording; a ValueError says why there is none.
        threshold: of a scenario; what is above it is a breach.
        check: raises a ValueError for a scenario that can have no such figure.
    """

    unit: str
    meaning: str
    of: Callable[[Scenario, xr.Dataset], float]
    threshold: Callable[[Scenario], float]
    check: Callable[[Scenario], None] = lambda scenario: None

    def shown(self, value: float) -> str:
        """Return a value of it with its unit."""
        return f"{value:.4g} {self.unit}".removesuffix(" 1")


def energy_made(scenario: Scenario, recording: xr.Dataset) -> float:
    """Energy [J] that coupling and channel have made beyond the reserves, of the worst axis."""
    coupling: Any = scenario.coupling
    return -bilateral.energy_margin(recording, coupling.reserves())


def peak(scenario: Scenario, recording: xr.Dataset) -> float:
    """Largest force [N] that the device is asked for."""
    return bilateral.peak_force(recording)


def drift_left(scenario: Scenario, recording: xr.Dataset) -> float:
    """Distance [m] of the tool from the master in the end, where the hand is at rest.

    Raises:
        ValueError: the run was cut, or the hand is not at rest by then.
    """
    master: Any = scenario.operator
    end = float(recording.time[-1])
    if end < scenario.duration - scenario.time_step or master.times[-1] > end - LAST:
        raise ValueError("the run ends before the hand has let go")
    return hand_press.drift_left(recording, end, scenario.coupling.position_scale, LAST)


def press_error(scenario: Scenario, recording: xr.Dataset) -> float:
    """Distance [m] of the tool from the master, delay removed, rms of the steady press.

    Raises:
        ValueError: the hand does not press and let go.
    """
    master: Any = scenario.operator
    held = hand_press.steady(recording, master)
    error = bilateral.position_error(recording, scenario.coupling.position_scale)
    return float(metrics.rmse(error.sel(time=held.time)))


def unrest(scenario: Scenario, recording: xr.Dataset) -> float:
    """Ripple of the force in the steady press, over the largest of a press that is stable.

    Raises:
        ValueError: the hand does not press and let go.
    """
    master: Any = scenario.operator
    ripple = bilateral.force_ripple(hand_press.steady(recording, master))
    way = float(np.linalg.norm(master.targets[1]))
    return ripple / (bilateral.SWING * master.hand_stiffness * way)


def invariant_breach(scenario: Scenario, recording: xr.Dataset) -> float:
    """Energy [J] beyond what TDPA promises, of the worst tick, axis and end; negative is less.

    That is what an end gave out, less its reserve, less what came in at the other end as the packet
    in use says it.

    Raises:
        ValueError: the coupling promises none, or the samples are not at the ticks.
    """
    check_invariant(scenario)
    coupling: Any = scenario.coupling
    beyond = [spent - told for spent, told in energy_accounts(recording, scenario.time_step)]
    return float(np.max(beyond)) - coupling.reserve


def check_invariant(scenario: Scenario) -> None:
    """Check that a scenario has an invariant, and shows it at every tick.

    Raises:
        ValueError: it has not.
    """
    kind, period = type(scenario.coupling), scenario.logging.period
    if not issubclass(kind, Tdpa):
        raise ValueError(f"coupling: !{kind.__name__}, allowed !Tdpa with the objective invariant")
    if period != scenario.time_step:
        raise ValueError(
            f"time_step: {scenario.time_step:g} s, allowed {period:g} s, that of the samples, with "
            "the objective invariant"
        )


def energy_accounts(recording: xr.Dataset, period: float) -> list[tuple[Array, Array]]:
    """Return, for the slave and the master, (spent, told), each (time, axis) [J].

    Spent is what an end gave out; told what came in at the other end by the packet in use. A sample
    is of before the updates of its tick, so sample n of a meter was written at tick n - 1, with the
    packet that was on the port then. That is the one of sample n - 1, whose age counts to tick
    n - 2. It was sent with the meter of the sample of that tick.
    """
    accounts = []
    for end, other, link in (("slave", "master", "up"), ("master", "slave", "down")):
        spent = recording[f"energy_{end}_out"].transpose("time", "axis").values
        came_in = recording[f"energy_{other}_in"].transpose("time", "axis").values
        age = np.rint(recording[f"age_{link}"].values / period).astype(int)
        tick = np.arange(len(age))
        sent = np.concatenate([[0], tick[1:] - 2 - age[:-1]]).clip(min=0)
        accounts.append((spent, came_in[sent]))
    return accounts


OBJECTIVES: Final[dict[str, Objective]] = {
    "energy": Objective(
        "J", "energy that coupling and channel make beyond the reserves", energy_made,
        lambda scenario: 1e-3,
    ),
    "peak": Objective(
        "N", "largest force that the device is asked for", peak,
        lambda scenario: scenario.operator.hardware().force,  # type: ignore[union-attr]
    ),
    "drift": Objective(
        "m", "tool from master when the hand is at rest in the end", drift_left,
        lambda scenario: 1e-3,
    ),
    "press": Objective(
        "m", "tool from master while the hand presses, delay removed, rms", press_error,
        lambda scenario: 0.015,
    ),
    "unrest": Objective(
        "1", "ripple of the force while the hand presses, over that of a press that is stable",
        unrest, lambda scenario: 1.0,
    ),
    "invariant": Objective(
        "J", "energy that an end of TDPA gives out beyond its bound, at any tick", invariant_breach,
        lambda scenario: ROUNDING, check_invariant,
    ),
}  # fmt: skip


def promise_broken(scenario: Scenario, recording: xr.Dataset) -> str:
    """Return why a run is outside what its coupling promises, or "".

    The bounds of TDPA and of wave variables are for a device whose velocity changes by no more
    than `turn`.
    """
    turn = getattr(scenario.coupling, "turn", np.inf)
    speeds = recording.v_master.transpose("time", "axis").values
    if len(speeds) < 2:
        return ""
    fastest = np.abs(np.diff(speeds, axis=0)).max() / scenario.logging.period
    return f"the device turns at {fastest:.3g} m/s², above turn" if fastest > turn else ""


def thresholds_of(
    scenario: Scenario, names: Sequence[str], changed: Sequence[str] = ()
) -> dict[str, float]:
    """Return the threshold of each objective, with some changed by texts such as "drift=0.002".

    Raises:
        ValueError: there is no such objective, or a text is no NAME=NUMBER.
    """
    for name in names:
        checks.choice("--objective", name, OBJECTIVES)
    found = {name: OBJECTIVES[name].threshold(scenario) for name in dict.fromkeys(names)}
    for text in changed:
        name, _, value = text.partition("=")
        checks.choice("--threshold", name, found)
        try:
            number = float(value)
        except ValueError:
            raise ValueError(
                f"--threshold: {checks.shown(text)}, allowed NAME=NUMBER in {OBJECTIVES[name].unit}"
            ) from None
        checks.number(f"--threshold {name}", number, checks.ABOVE_ZERO)
        found[name] = number
    return found
