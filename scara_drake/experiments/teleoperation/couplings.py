"""The couplings of a bilateral teleoperation, over the named channels. Not in the paper.

A hand on a simulated device presses 3 cm into the wall of Table 4 and lets go (scenario
`bilateral`): free, without the wall; wall; and loss, the wall with a tenth of the packets lost
beside what the channel loses. A sweep of the hand, pressed and free, then gives the impedance that
is felt. Over a channel with jitter the wall is pressed and swept again through the playout buffer
that is recommended for it. Its figures are of `metrics.bilateral`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np
import xarray as xr
from rich.console import Console
from rich.progress import track

from scara_drake.common import checks
from scara_drake.common.parallel import side_by_side
from scara_drake.experiments.claim import Experiment
from scara_drake.experiments.teleoperation.couplings_claims import claims
from scara_drake.experiments.teleoperation.couplings_runs import (
    BUFFERED,
    BUFFERED_COUPLINGS,
    CASES,
    COUPLINGS,
    DELAYED_COUPLINGS,
    DELAYS,
    FIGURES,
    LINKS,
    LOSS,
    PRESS,
    SCENARIO,
    SWEPT,
    Job,
    figures,
    has_jitter,
)
from scara_drake.recordings.labels import labelled

__all__ = ["BUFFERED", "CASES", "COUPLINGS", "LINKS", "claims", "run"]


def run(
    seed: int = 0,
    couplings: Sequence[str] = tuple(COUPLINGS),
    presets: Sequence[str] = tuple(LINKS),
    cases: Sequence[str] = CASES,
    times: Sequence[float] = PRESS,
    duration: float = 12.0,
    sweep_duration: float = 30.0,
    jobs: int | None = None,
) -> Experiment:
    """Simulate each coupling over each channel in each case, and sweep those that are stable.

    On a terminal a bar shows how far it is.

    Raises:
        ValueError: the run ends before the press is over.

    Args:
        seed: of jitter and loss.
        couplings: of `COUPLINGS`.
        presets: of `LINKS`.
        cases: of `CASES`.
        times: of the press: it starts, is there, is given up, is over [s].
        duration: of a run [s].
        sweep_duration: [s]; 0 for no sweeps.
        jobs: runs side by side; all cores if None.
    """
    checks.number("duration", duration, times[-1])
    shape = (len(couplings), len(presets), len(cases))
    cells = [(c, p, case) for c in couplings for p in presets for case in cases]
    presses = [Job(*cell, seed, tuple(times), duration) for cell in cells]
    results = list(_work(presses, jobs, "presses"))
    data = {
        name: labelled(
            ("coupling", "preset", "case"),
            np.reshape([result[name] for result in results], shape),
            *FIGURES[name],
        )
        for name in FIGURES
    }
    stable = np.array([result["stable"] for result in results]).reshape(shape)
    data["stable"] = labelled(
        ("coupling", "preset", "case"),
        stable,
        "1",
        "the force rests in the steady part, and nothing but the hand moves the device",
    )
    data |= _transparency(couplings, presets, np.all(stable, axis=2), seed, sweep_duration, jobs)
    walls = [job for job in presses if job.case == "wall"]
    data |= _through_buffers(walls, couplings, presets, sweep_duration, jobs)
    data |= _with_jitter(walls, couplings, jobs)
    coordinates = {"coupling": list(couplings), "preset": list(presets), "case": list(cases)}
    coordinates["delays"] = list(DELAYS)
    attributes = {"seed": seed, "scenario": SCENARIO, "loss": LOSS}
    dataset = xr.Dataset(data, coords=coordinates, attrs=attributes)
    return Experiment("Couplings", dataset, claims(dataset))


def _transparency(
    couplings: Sequence[str],
    presets: Sequence[str],
    stable: np.ndarray,
    seed: int,
    duration: float,
    jobs: int | None,
) -> dict[str, xr.Variable]:
    """Figures of `SWEPT` (coupling, preset); NaN where not `stable`."""
    found = {name: np.full(stable.shape, np.nan) for name in SWEPT}
    if duration > 0.0:
        where = np.argwhere(stable)
        sweeps = [
            Job(couplings[i], presets[j], "wall", seed, PRESS[:2], duration, sweep=True)
            for i, j in where
        ]
        for (i, j), result in zip(where, _work(sweeps, jobs, "sweeps"), strict=True):
            for name in SWEPT:
                found[name][i, j] = result[name]
    return {name: labelled(("coupling", "preset"), found[name], *SWEPT[name]) for name in SWEPT}


def _through_buffers(
    walls: Sequence[Job],
    couplings: Sequence[str],
    presets: Sequence[str],
    duration: float,
    jobs: int | None,
) -> dict[str, xr.Variable]:
    """`BUFFERED`, "buffered_" before its names (coupling, preset); NaN without jitter or sweep."""
    todo = [
        dataclasses.replace(job, buffered=True)
        for job in walls
        if has_jitter(job.preset) and job.coupling in BUFFERED_COUPLINGS
    ]
    sweeps = [
        dataclasses.replace(job, times=PRESS[:2], duration=duration, sweep=True) for job in todo
    ]
    todo += sweeps if duration > 0.0 else []
    found = {name: np.full((len(couplings), len(presets)), np.nan) for name in BUFFERED}
    for job, result in zip(todo, _work(todo, jobs, "buffers"), strict=True):
        place = couplings.index(job.coupling), presets.index(job.preset)
        for name in BUFFERED.keys() & result.keys():
            found[name][place] = result[name]
    return {
        f"buffered_{name}": labelled(("coupling", "preset"), found[name], *BUFFERED[name])
        for name in BUFFERED
    }


def _with_jitter(
    walls: Sequence[Job], couplings: Sequence[str], jobs: int | None
) -> dict[str, xr.Variable]:
    """Contact and position error of a press over `DELAYS`, "delayed_" before (coupling, delays)."""
    names = ("contact", "position_error")
    found = {name: np.full((len(couplings), len(DELAYS)), np.nan) for name in names}
    todo = [
        dataclasses.replace(job, preset=preset)
        for job in {job.coupling: job for job in walls}.values()
        if job.coupling in DELAYED_COUPLINGS
        for preset in DELAYS
    ]
    for job, result in zip(todo, _work(todo, jobs, "jitter"), strict=True):
        for name in names:
            found[name][couplings.index(job.coupling), list(DELAYS).index(job.preset)] = result[
                name
            ]
    return {
        f"delayed_{name}": labelled(("coupling", "delays"), found[name], *FIGURES[name])
        for name in names
    }


def _work(todo: Sequence[Job], jobs: int | None, title: str) -> Iterator[dict[str, float | bool]]:
    """Yield the figures of each job, in order."""

    def watched(results: Iterable[Any]) -> Iterator[Any]:
        console = Console(stderr=True)
        yield from track(
            results, title, len(todo), console=console, disable=not console.is_terminal
        )

    yield from watched(side_by_side(figures, todo, jobs))
