"""The couplings of a bilateral teleoperation, over the named channels. Not in the paper.

A hand on a simulated device presses 3 cm into the wall of Table 4 and lets go (scenario
`bilateral`): free, without the wall; wall; and loss, the wall with a tenth of the packets lost
beside what the channel loses. A sweep of the hand, pressed and free, then gives the impedance that
is felt. Its figures are of `bilateral_metrics`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final, cast

import numpy as np
import xarray as xr
from rich.console import Console
from rich.progress import track

from scara_drake import metrics
from scara_drake.channel.delays import ConstantDelay
from scara_drake.channel.impairments import Loss
from scara_drake.channel.links import Channel, Link
from scara_drake.channel.packets import Packets
from scara_drake.channel.presets import PRESETS
from scara_drake.common import checks
from scara_drake.common.parallel import side_by_side
from scara_drake.experiments.claim import Experiment
from scara_drake.experiments.teleoperation import hand_sweep
from scara_drake.experiments.teleoperation.couplings_claims import claims
from scara_drake.experiments.teleoperation.hand_sweep import HandSweep
from scara_drake.metrics import bilateral as bilateral_metrics
from scara_drake.operator.master import Master
from scara_drake.recordings.labels import labelled
from scara_drake.scenario import Scenario, load_scenario
from scara_drake.simulation.run import simulate
from scara_drake.stability.displayed_impedance import has_closed_form

SCENARIO = "bilateral"
COUPLINGS: Final = {
    "direct": "!Direct {}",
    "direct, force x 0.1": "!ScaledForce {}",
    "P+d": "!PositionDamping {}",
    "wave variables": "!WaveVariables {}",
    "TDPA": "!Tdpa {}",
    "TDPA, force x 0.1": "!Tdpa {force_scale: 0.1}",
    "model-mediated": "!ModelMediated {}",
}
LINKS: Final[dict[str, Link]] = {
    name: ConstantDelay(0.005) if name == "5 ms" else PRESETS[name].link
    for name in (
        "none",
        "lan",
        "5 ms",
        "5g",
        "4g",
        "paper",
        "paper_offset",
        "satellite",
        "paper_2s",
    )
}
CASES: Final = ("free", "wall", "loss")
LOSS = 0.1  # of the packets, in the case "loss"

TICK = 1e-3  # [s]: packets with less jitter keep their order
PRESS = (1.0, 2.0, 6.0, 7.0)  # [s], see `Master.times`
LAST = 0.5  # [s], end of the run, in which a drift is left

FIGURES: Final = {
    "peak": ("N", "largest force at the master, before the limit of its actuators"),
    "shown": ("N", "mean force at the master in the steady part of the press"),
    "felt": ("N", "mean force at the tool in that part, in the master's units"),
    "contact": ("1", "share of the steady part of the press in which the tool is touched"),
    "position_error": ("m", "tool from master, delay removed, rms: pressing, or free all along"),
    "drift": ("m", "tool from master, largest at the end of the run"),
    "force_error": ("N", "force at the master from that at the tool, delay removed, rms, pressing"),
    "ripple": ("N", "standard deviation of the force in the steady part of the press"),
    "energy_margin": ("J", "least energy left in coupling and channel, with the reserve"),
    "age_mean": ("s", "age of information, mean of both links"),
    "age_p99": ("s", "age of information, 99th percentile of both links"),
}
SWEPT: Final = {
    "transparency_error": (
        "decades",
        "mean |log10| of the impedance felt at the wall over its own",
    ),
    "closed_form": ("decades", "the same of the closed form, and the mean over the delays"),
    "z_width": ("decades", "mean log10 of what the hand feels at the wall over that in free space"),
}


@dataclass(frozen=True)
class Job:
    """One run, or with `sweep` the pair of them that give the impedance."""

    coupling: str
    preset: str
    case: str
    seed: int
    times: tuple[float, ...]  # [s]
    duration: float  # [s]: of the run, or of the sweep
    sweep: bool = False


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
    coordinates = {"coupling": list(couplings), "preset": list(presets), "case": list(cases)}
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


def _work(todo: Sequence[Job], jobs: int | None, title: str) -> Iterator[dict[str, float | bool]]:
    """Yield the figures of each job, in order."""

    def watched(results: Iterable[Any]) -> Iterator[Any]:
        console = Console(stderr=True)
        yield from track(
            results, title, len(todo), console=console, disable=not console.is_terminal
        )

    yield from watched(side_by_side(figures, todo, jobs))


def figures(job: Job) -> dict[str, float | bool]:
    """Simulate one job, and return its figures by name."""
    return sweep_figures(job) if job.sweep else press_figures(job)


def scenario(job: Job) -> Scenario:
    """Return the scenario of a job."""
    made = load_scenario(SCENARIO, {"coupling": COUPLINGS[job.coupling], "seed": job.seed})
    link = LINKS[job.preset]
    if job.case == "loss":
        link = lossy(link)
    made.channel = Channel(up=link, down=link)
    if job.case == "free":
        made.environment.surfaces = []
    return made


def has_jitter(name: str) -> bool:
    """Whether the jitter of a link of `LINKS` is that of a tick or more."""
    link = LINKS[name]
    return isinstance(link, Packets) and link.jitter.mean >= TICK


def buffered(name: str) -> Link:
    """Return a link of `LINKS` as it is through a playout buffer."""
    link = LINKS[name]
    from scipy import stats

    a = (link.jitter.mean / link.jitter.std) ** 2
    late = stats.gamma.ppf(0.99, a, scale=link.jitter.std**2 / link.jitter.mean)
    return ConstantDelay(np.ceil(1e3 * (link.delay.delay + late)) / 1e3)


def lossy(link: Link) -> Packets:
    """Return a link as packets, of which `LOSS` are lost beside those that it loses anyway."""
    if not isinstance(link, Packets):
        return Packets(delay=link, loss=Loss(in_good=LOSS))
    kept = 1.0 - LOSS
    loss = dataclasses.replace(
        link.loss,
        in_good=1.0 - kept * (1.0 - link.loss.in_good),
        in_bad=1.0 - kept * (1.0 - link.loss.in_bad),
    )
    return dataclasses.replace(link, loss=loss)


def press_figures(job: Job) -> dict[str, float | bool]:
    """Simulate a press, and return `FIGURES` and whether it was stable."""
    pressing = scenario(job)
    master, coupling = cast(Master, pressing.operator), pressing.coupling
    master.times = list(job.times)
    recording = simulate(pressing, duration=job.duration)
    begin, end = job.times[1:3]
    held = bilateral_metrics.steady_press(recording, begin, end)
    position = bilateral_metrics.position_error(recording, coupling.position_scale)
    if job.case != "free":
        position = position.sel(time=held.time)
    force = bilateral_metrics.force_error(recording, coupling.force_scale)
    left = bilateral_metrics.drift(recording, coupling.position_scale)
    ages = np.concatenate(
        [bilateral_metrics.age_of_information(recording, link) for link in ("up", "down")]
    )
    return {
        "stable": bilateral_metrics.is_stable_press(
            recording,
            begin=begin,
            end=end,
            way=float(np.linalg.norm(master.targets[1])),
            stiffness=master.hand_stiffness,
            mass=master.mass,
        ),
        "peak": bilateral_metrics.peak_force(recording),
        "shown": bilateral_metrics.mean_size(held.f_master),
        "felt": coupling.force_scale * bilateral_metrics.mean_size(held.f_env_on_tool_W),
        "contact": bilateral_metrics.contact_share(held),
        "position_error": float(metrics.rmse(position)),
        "drift": float(left.sel(time=slice(job.duration - LAST, None)).max()),
        "force_error": float(metrics.rmse(force.sel(time=held.time))),
        "ripple": bilateral_metrics.force_ripple(held),
        "energy_margin": bilateral_metrics.energy_margin(recording, coupling.reserves()),
        "age_mean": float(ages.mean()),
        "age_p99": float(np.quantile(ages, 0.99)),
    }


def sweep_figures(job: Job) -> dict[str, float | bool]:
    """Sweep the hand, pressed and free, and return the figures of the impedances."""
    sweep = HandSweep(job.times, job.duration)
    pressing, free = (scenario(dataclasses.replace(job, case=case)) for case in ("wall", "free"))
    recording = sweep.run(pressing)
    shown, felt = (sweep.displayed(recording, force) for force in ("f_master", "f_hand"))
    width = bilateral_metrics.decades(felt, sweep.displayed(sweep.run(free), "f_hand"), signed=True)
    frequency = shown.frequency
    closed_form = np.nan
    if has_closed_form(pressing.coupling):
        delays = sweep.delays(recording).values
        closed_form = hand_sweep.predicted_error(pressing, frequency, delays)
    ideal = hand_sweep.true_impedance(pressing, frequency)
    return {
        "transparency_error": bilateral_metrics.decades(shown, ideal),
        "closed_form": closed_form,
        "z_width": width,
    }
