"""Delay against loss of packets, after Rodriguez-Seda, Lee and Spong.

"Experimental comparison study of control architectures for bilateral teleoperators" (IEEE
Transactions on Robotics 25(6), 2009): with wave variables, Smith predictors and synchronisation,
over 8 to 1088 ms there and back and 0 to 50 % of loss, both make position errors larger and contact
less true, and loss less so than delay. Of that only the order can be checked here: their robots,
gains and rates are not ours, and of their grid its ends are what the abstract gives.

A hand presses 3 cm into the wall of Table 4 and lets go, each packet being sent at 1 kHz and lost
independently of the others. P+d stands for synchronisation; beside it are TDPA, waves that are sent
with their integral, and waves without the term that takes their drift away. The effect of a thing
is what it changes of an error, from the least to the most, where it changes most of it. What is
compared are the ends of 95 % intervals over seeds.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any, Final

import numpy as np
import xarray as xr
from scipy.stats import t as student

from scara_drake.channel.delays import ConstantDelay
from scara_drake.channel.impairments import Loss
from scara_drake.channel.links import Channel
from scara_drake.channel.packets import Packets
from scara_drake.experiments.claim import OURS, AnyOf, Claim, Criterion, Experiment, ordered
from scara_drake.experiments.quantity import Quantity, number, quantity
from scara_drake.metrics import bilateral, rmse
from scara_drake.recordings.labels import labelled
from scara_drake.scenario import Scenario, load_scenario
from scara_drake.simulation.many import Failed, each_run

SCENARIO: Final = "bilateral"
WAVES, INTEGRALS = "wave variables", "waves with integrals"
NO_DRIFT_TERM: Final = "waves without drift term"
COUPLINGS: Final = {
    # The damping that P+d needs for the longest of the delays, and a tenth more.
    "P+d": "!PositionDamping {stiffness: 100.0, damping: 60.0}",
    WAVES: "!WaveVariables {}",
    INTEGRALS: "!WaveVariables {integrals: true}",
    NO_DRIFT_TERM: "!WaveVariables {drift_gain: 0.0}",
    "TDPA": "!Tdpa {}",
}
DELAYS: Final = (0.008, 0.272, 1.088)  # [s], there and back
LOSSES: Final = (0.0, 0.25, 0.5)
SEEDS: Final = 3
TIMES: Final = (0.3, 1.0, 3.5, 4.2)  # [s] of the press, see `Master.times`
DURATION: Final = 6.0  # [s]
CONFIDENCE: Final = 0.95
RESTORED: Final = 0.25  # most of the effect of loss that a remedy may leave
REMEDIES: Final = {  # what is said of each, and why it is as it is
    INTEGRALS: (
        "Waves that are sent with their integral bear loss",
        "The integral tells of a wave that was lost, and what is left over is spent in a time and "
        "not at once, so that the last wave can be held over the next gap.",
    ),
    NO_DRIFT_TERM: (
        "What makes loss costly to waves is the term that takes their drift away",
        "That term spends at once what a lost wave has left over. Without it that energy stays, "
        "and the last wave is held over the next gap.",
    ),
}

FIGURES: Final = {
    "position": ("mm", "tool from master at the same time, rms"),
    "position_received": ("mm", "tool from master, delay removed, rms"),
    "left": ("mm", "tool from master at the end of the run"),
    "force": ("N", "force at the master from that at the tool, delay removed, rms"),
}
JUDGED: Final = ("position", "force")
RANKS: Final = quantity({"loss": 1, "delay": 2}, "in the order of its effect")


def run(
    seed: int = 0,
    couplings: Sequence[str] = tuple(COUPLINGS),
    delays: Sequence[float] = DELAYS,
    losses: Sequence[float] = LOSSES,
    seeds: int = SEEDS,
    jobs: int | None = None,
) -> Experiment:
    """Press over each delay and loss with each coupling.

    Args:
        seed: the first; of the losses.
        couplings: of `COUPLINGS`.
        delays: there and back [s].
        losses: shares of the packets.
        seeds: how many; without loss there is one run.
        jobs: runs side by side; all cores if None.

    Raises:
        RuntimeError: a run broke off.
    """
    cells = [
        cell
        for cell in product(couplings, delays, losses, range(seed, seed + seeds))
        if cell[2] > 0.0 or cell[3] == seed
    ]
    found = dict(each_run(enumerate(scenario(*cell) for cell in cells), figures, jobs))
    made: dict[Any, dict[str, float]] = {}
    for index, cell in enumerate(cells):
        result = found[index]
        if isinstance(result, Failed):
            raise RuntimeError(f"{cell}: {result.reason}")
        made[cell] = result
    shape = (len(couplings), len(delays), len(losses), seeds)
    every = [
        made[c, d, loss, s if loss > 0.0 else seed]
        for c, d, loss, s in product(couplings, delays, losses, range(seed, seed + seeds))
    ]
    data = xr.Dataset(
        {
            name: labelled(
                ("coupling", "delay", "loss", "seed"),
                np.reshape([one[name] for one in every], shape),
                unit,
                long_name,
            )
            for name, (unit, long_name) in FIGURES.items()
        },
        coords={
            "coupling": list(couplings),
            "delay": ("delay", list(delays), {"units": "s", "long_name": "there and back"}),
            "loss": ("loss", list(losses), {"units": "1", "long_name": "share of the packets"}),
            "seed": list(range(seed, seed + seeds)),
        },
        attrs={"seed": seed, "scenario": SCENARIO},
    )
    return Experiment("Delay against loss", data, claims(data))


def scenario(coupling: str, delay: float, loss: float, seed: int) -> Scenario:
    """Return the press over a delay there and back [s] and a share of lost packets."""
    made = load_scenario(SCENARIO, {"coupling": COUPLINGS[coupling], "seed": seed})
    master: Any = made.operator
    master.times = list(TIMES)
    made.duration = DURATION
    link = Packets(ConstantDelay(0.5 * delay), loss=Loss(loss))
    made.channel = Channel(up=link, down=link)
    return made


def figures(scenario: Scenario, recording: xr.Dataset) -> dict[str, float]:
    """Return `FIGURES` of a press."""
    apart = bilateral.drift(recording)
    return {
        "position": 1e3 * float(rmse(apart)),
        "position_received": 1e3 * float(rmse(bilateral.position_error(recording))),
        "left": 1e3 * float(apart[-1]),
        "force": float(rmse(bilateral.force_error(recording))),
    }


def claims(data: xr.Dataset) -> list[Claim]:
    """Judge the order for each coupling, and what is left of the effect of loss."""
    made = [_order(data.sel(coupling=name), str(name)) for name in data.coupling.values]
    names = set(data.coupling.values)
    return made + [_remedy(data, name) for name in REMEDIES if {WAVES, name} <= names]


def effects(data: xr.Dataset, figure: str) -> dict[str, tuple[float, float, float]]:
    """Mean of the largest effect of loss and of delay over the seeds, and the ends of its interval.

    Args:
        data: of one coupling.
        figure: of `FIGURES`.
    """
    values = data[figure]
    largest = {
        what: (values.max(what) - values.min(what)).max(other)
        for what, other in (("loss", "delay"), ("delay", "loss"))
    }
    return {what: _interval(each.values) for what, each in largest.items()}


def _interval(values: np.ndarray) -> tuple[float, float, float]:
    """Mean, and the ends of the interval that has the mean of all seeds in it."""
    mean, n = float(values.mean()), values.size
    if n < 2:
        return mean, mean, mean
    error = float(values.std(ddof=1)) / np.sqrt(n)
    half = float(student.ppf(0.5 + 0.5 * CONFIDENCE, n - 1)) * error
    return mean, mean - half, mean + half


def _order(data: xr.Dataset, name: str) -> Claim:
    told: list[Quantity] = []
    rules = []
    for figure in JUDGED:
        unit, _ = FIGURES[figure]
        found = effects(data, figure)
        told += [
            quantity(found[what], unit, f"effect of {what} on the {figure} error")
            for what in ("loss", "delay")
        ]
        # The interval's worse ends: most of the loss, least of the delay.
        rules.append(ordered(_ends(found, unit)))
    share = {figure: _share(effects(data, figure)) for figure in JUDGED}
    return Claim(
        f"Loss is less critical than delay: {name}",
        RANKS,
        tuple(told),
        Criterion(
            "the largest effect of delay is above the largest of loss, of both errors, even at the "
            f"ends of their {1e2 * CONFIDENCE:g} % intervals that are nearest to each other (in "
            "kind: of one of the errors)",
            tuple(rules),
            AnyOf(tuple(rules)),
        ),
        f"Loss does {number(1e2 * share['position'])} % of what delay does to the position, and "
        f"{number(1e2 * share['force'])} % of what it does to the force{_shorter(data)}.",
        OURS,
    )


def _ends(found: Mapping[str, tuple[float, float, float]], unit: str) -> Quantity:
    return quantity({"loss": found["loss"][2], "delay": found["delay"][1]}, unit)


def _share(found: Mapping[str, tuple[float, float, float]]) -> float:
    return found["loss"][0] / found["delay"][0] if found["delay"][0] > 0.0 else np.inf


def _shorter(data: xr.Dataset) -> str:
    """Say what the order hangs on: the same shares without the longest delay."""
    if data.delay.size < 3:
        return ""
    fewer = data.isel(delay=slice(None, -1))
    share = [number(1e2 * _share(effects(fewer, figure))) for figure in JUDGED]
    return f"; without the longest delay {share[0]} % and {share[1]} %"


def _remedy(data: xr.Dataset, name: str) -> Claim:
    statement, reason = REMEDIES[name]
    lost = {each: effects(data.sel(coupling=each), "position")["loss"] for each in (WAVES, name)}
    least = lost[WAVES][1]
    left = lost[name][2] / least if least > 0.0 else np.inf
    drift = data.left.sel(coupling=name).isel(delay=0)
    return Claim(
        statement,
        None,
        (
            *(quantity(each, "mm", f"effect of loss, {one}") for one, each in lost.items()),
            quantity(1e2 * left, "%", "of it is left", "up to"),
            quantity(drift.max(), "mm", "drift left, over the shortest delay", "up to"),
        ),
        Criterion(
            f"no more than {1e2 * RESTORED:g} % of the effect of loss on the position is left, "
            "between the ends of both intervals that are nearest to each other",
            bool(left <= RESTORED),
        ),
        reason,
        OURS,
    )
