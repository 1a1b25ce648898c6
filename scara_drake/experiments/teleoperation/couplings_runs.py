"""One run of a coupling over a channel: its scenario, and the figures that are made of it."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Final, cast

import numpy as np

from scara_drake import metrics
from scara_drake.channel.delays import ConstantDelay
from scara_drake.channel.impairments import Jitter, Loss
from scara_drake.channel.links import Channel, Link
from scara_drake.channel.packets import Packets
from scara_drake.channel.playout import Playout
from scara_drake.channel.presets import PRESETS
from scara_drake.experiments.teleoperation import hand_sweep
from scara_drake.experiments.teleoperation.hand_sweep import HandSweep
from scara_drake.metrics import bilateral as bilateral_metrics
from scara_drake.metrics import hand_press
from scara_drake.operator.master import Master
from scara_drake.scenario import Scenario, load_scenario
from scara_drake.simulation.run import simulate
from scara_drake.stability.displayed_impedance import has_closed_form

SCENARIO = "bilateral"
COUPLINGS: Final = {
    "direct": "!Direct {}",
    "direct, force x 0.1": "!ScaledForce {}",
    "P+d": "!PositionDamping {}",
    "four channels": "!FourChannel {}",
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
_JITTER = Packets(ConstantDelay(9.5e-3), Jitter("gamma", 0.5e-3, 0.25e-3), longest=0.1)
# What half a millisecond of jitter does, beside twenty milliseconds of delay. Behind the buffer 99
# of 100 packets are in time.
DELAYS: Final[dict[str, Link]] = {
    "10 ms": ConstantDelay(0.01),
    "30 ms": ConstantDelay(0.03),
    "10 ms, half of one as jitter": _JITTER,
    "the same through a buffer of 11 ms": dataclasses.replace(
        _JITTER, playout=Playout(depth=0.011)
    ),
}
CASES: Final = ("free", "wall", "loss")
LOSS = 0.1  # of the packets, in the case "loss"

TICK = 1e-3  # [s]: packets with less jitter keep their order
PRESS = (1.0, 2.0, 6.0, 7.0)  # [s], see `Master.times`

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
# Of a press and a sweep through the buffer that is recommended.
BUFFERED: Final = {
    "contact": FIGURES["contact"],
    "position_error": FIGURES["position_error"],
    **{name: SWEPT[name] for name in ("transparency_error", "closed_form")},
}
BUFFERED_COUPLINGS = ("P+d", "wave variables", "TDPA", "model-mediated")
DELAYED_COUPLINGS = ("wave variables", "TDPA")


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
    buffered: bool = False  # through the playout buffer that is recommended


def figures(job: Job) -> dict[str, float | bool]:
    """Simulate one job, and return its figures by name."""
    return sweep_figures(job) if job.sweep else press_figures(job)


def scenario(job: Job) -> Scenario:
    """Return the scenario of a job."""
    made = load_scenario(SCENARIO, {"coupling": COUPLINGS[job.coupling], "seed": job.seed})
    link = buffered(job.preset) if job.buffered else (LINKS | DELAYS)[job.preset]
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


def buffered(name: str) -> Packets:
    """Return a link of `LINKS` that has jitter, with the buffer that is recommended for it."""
    return cast(Packets, PRESETS[name].buffered())


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
    ages = np.concatenate(
        [bilateral_metrics.age_of_information(recording, link) for link in ("up", "down")]
    )
    return {
        "stable": hand_press.is_stable(recording, master),
        "peak": bilateral_metrics.peak_force(recording),
        "shown": bilateral_metrics.mean_size(held.f_master),
        "felt": coupling.force_scale * bilateral_metrics.mean_size(held.f_env_on_tool_W),
        "contact": bilateral_metrics.contact_share(held),
        "position_error": float(metrics.rmse(position)),
        "drift": hand_press.drift_left(recording, job.duration, coupling.position_scale),
        "force_error": float(metrics.rmse(force.sel(time=held.time))),
        "ripple": bilateral_metrics.force_ripple(held),
        "energy_margin": bilateral_metrics.energy_margin(recording, coupling.reserves()),
        "age_mean": float(ages.mean()),
        "age_p99": float(np.quantile(ages, 0.99)),
    }


def sweep_figures(job: Job) -> dict[str, float | bool]:
    """Sweep the hand, pressed and free, and return the figures of the impedances.

    Behind a buffer only pressed: there is no Z-width then.
    """
    sweep, pressing = HandSweep(job.times, job.duration), scenario(job)
    recording = sweep.run(pressing)
    shown, felt = (sweep.displayed(recording, force) for force in ("f_master", "f_hand"))
    ideal = hand_sweep.true_impedance(pressing, shown.frequency)
    made = {
        "transparency_error": bilateral_metrics.decades(shown, ideal),
        "closed_form": np.nan,
        "z_width": np.nan,
    }
    if has_closed_form(pressing.coupling):
        delays = sweep.delays(recording).values
        made["closed_form"] = hand_sweep.predicted_error(pressing, shown.frequency, delays)
    if not job.buffered:
        free = scenario(dataclasses.replace(job, case="free"))
        freely = sweep.displayed(sweep.run(free), "f_hand")
        made["z_width"] = bilateral_metrics.decades(felt, freely, signed=True)
    return made
