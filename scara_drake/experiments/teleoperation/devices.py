"""The couplings on devices that exist: what a device of 40 N hides. Not in the paper.

The press of `couplings` (scenario `bilateral`), shortened, with the simulated master as one of
several devices, and over few channels. It is done at full scale, where a newton at the tool is one
in the hand, and with the scales that are natural for a device: its largest force stands for 40 N at
the tool, the radius of its workspace for 75 mm there. The hand is the same person's on each.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, cast

import numpy as np
import xarray as xr

from scara_drake.channel.links import Channel
from scara_drake.common.parallel import side_by_side
from scara_drake.experiments.claim import Experiment
from scara_drake.experiments.teleoperation.couplings import COUPLINGS, LINKS
from scara_drake.experiments.teleoperation.devices_claims import claims
from scara_drake.metrics import bilateral as bilateral_metrics
from scara_drake.metrics import hand_press
from scara_drake.operator.kinesthetic_devices import OWN
from scara_drake.operator.master import Master
from scara_drake.recordings.labels import labelled
from scara_drake.scenario import Scenario, load_scenario
from scara_drake.simulation.run import simulate

SCENARIO: Final = "bilateral"
DEVICES: Final = (OWN, "touch", "omega.3", "delta.3")
KINDS: Final = ("direct", "P+d", "wave variables", "TDPA", "model-mediated")
PRESETS: Final = ("none", "5g")
SCALES: Final = ("full", "natural")
TOOL_FORCE, TOOL_WAY = 40.0, 0.075  # [N], [m] at the tool, for all that a device has
PRESS: Final = (0.3, 0.8, 2.8, 3.3)  # [s], see `Master.times`
DURATION: Final = 4.0  # [s]

FIGURES: Final = {
    "stable": ("1", "the force rests, and nothing but the hand moves the device"),
    "asked": ("N", "mean force that is asked of the device in the steady part of the press"),
    "felt": ("N", "mean force of the device in that part, within its limit"),
    "tool": ("N", "mean force at the tool in that part, in the master's units"),
    "ripple": ("N", "standard deviation of the asked force in that part"),
    "contact": ("1", "share of that part in which the tool is touched"),
    "cut": ("1", "share of the press in which the device is at its limit"),
    "energy_margin": ("J", "least energy left in coupling and channel, with the reserve"),
    "meter_error": ("J", "largest difference of the metered work of the device and the true one"),
    "meter_bound": ("J", "what half a count times the way of the force allows of it"),
}


@dataclass(frozen=True)
class Job:
    """One run."""

    device: str
    scale: str
    coupling: str
    preset: str
    seed: int
    times: tuple[float, ...]  # [s]
    duration: float  # [s]


def run(
    seed: int = 0,
    devices: Sequence[str] = DEVICES,
    couplings: Sequence[str] = KINDS,
    presets: Sequence[str] = PRESETS,
    times: Sequence[float] = PRESS,
    duration: float = DURATION,
    jobs: int | None = None,
) -> Experiment:
    """Press with each device and coupling over each channel, at full scale and at its own.

    Args:
        seed: of jitter and loss.
        devices: of `kinesthetic_devices.DEVICES`, or "own".
        couplings: of `couplings.COUPLINGS`.
        presets: of `couplings.LINKS`.
        times: of the press: it starts, is there, is given up, is over [s].
        duration: of a run [s].
        jobs: runs side by side; all cores if None.
    """
    cells = [(d, s, c, p) for d in devices for s in SCALES for c in couplings for p in presets]
    # The own device has no scale of its own.
    cells_run = [(d, SCALES[0] if d == OWN else s, c, p) for d, s, c, p in cells]
    todo = [Job(*cell, seed, tuple(times), duration) for cell in cells_run]
    different = list(dict.fromkeys(todo))
    known = dict(zip(different, side_by_side(figures, different, jobs), strict=True))
    results = [known[job] for job in todo]
    dims = ("device", "scale", "coupling", "preset")
    shape = (len(devices), len(SCALES), len(couplings), len(presets))
    data = {
        name: labelled(dims, np.reshape([result[name] for result in results], shape), *told)
        for name, told in FIGURES.items()
    }
    coordinates = dict(zip(dims, map(list, (devices, SCALES, couplings, presets)), strict=True))
    dataset = xr.Dataset(data, coords=coordinates, attrs={"seed": seed, "scenario": SCENARIO})
    return Experiment("Devices", dataset, claims(dataset))


def scenario(job: Job) -> Scenario:
    """Return the scenario of a job; the hand goes as far as puts the tool where it would be."""
    changes = {"coupling": COUPLINGS[job.coupling], "seed": job.seed}
    made = load_scenario(SCENARIO, changes | {"operator.device": job.device})
    master = cast(Master, made.operator)
    if job.scale == "natural":
        hardware = master.hardware()
        way = TOOL_WAY / hardware.workspace
        made.coupling = replace(
            made.coupling, force_scale=hardware.force / TOOL_FORCE, position_scale=way
        )
        master.targets = [[entry / way for entry in target] for target in master.targets]
    master.times = list(job.times)
    made.channel = Channel(up=LINKS[job.preset], down=LINKS[job.preset])
    return made


def figures(job: Job) -> dict[str, float | bool]:
    """Simulate a press, and return `FIGURES`."""
    pressing = scenario(job)
    master, coupling = cast(Master, pressing.operator), pressing.coupling
    hardware = master.hardware()
    recording = simulate(pressing, duration=job.duration)
    begin, end = job.times[1:3]
    held = bilateral_metrics.steady_press(recording, begin, end)
    pressed = recording.sel(time=slice(job.times[0], end))
    error, bound = meter_error(recording, hardware.force, hardware.resolution)
    return {
        "stable": hand_press.is_stable(recording, master),
        "asked": bilateral_metrics.mean_size(held.f_master),
        "felt": bilateral_metrics.mean_size(held.f_master.clip(-hardware.force, hardware.force)),
        "tool": coupling.force_scale * bilateral_metrics.mean_size(held.f_env_on_tool_W),
        "ripple": bilateral_metrics.force_ripple(held),
        "contact": bilateral_metrics.contact_share(held),
        "cut": float((abs(pressed.f_master) >= hardware.force).any("axis").mean()),
        "energy_margin": bilateral_metrics.energy_margin(recording, coupling.reserves()),
        "meter_error": error,
        "meter_bound": bound,
    }


def meter_error(recording: xr.Dataset, limit: float, resolution: float) -> tuple[float, float]:
    """Return how far the metered work of a device is from the true one [J], and the bound of it.

    The force f_k moves the device from x_k to x_k+1, the meters see counts q = x + e with |e| no
    larger than half a count. So the sums differ by sum f_k (e_k+1 - e_k), which by parts is no more
    than half a count times the first and last force and all that the force changes by.

    Args:
        recording: of each tick.
        limit: of the device's actuators [N].
        resolution: of its encoders [m].
    """
    if resolution == 0.0:
        return 0.0, 0.0
    applied = recording.f_master.clip(-limit, limit).transpose("time", "axis").values[:-1]
    slip = (recording.x_master_measured - recording.x_master).transpose("time", "axis").values
    wrong = np.abs(np.cumsum(applied * np.diff(slip, axis=0), axis=0))
    changes = np.abs(np.diff(applied, axis=0)).sum(axis=0) + np.abs(applied[[0, -1]]).sum(axis=0)
    return float(wrong.max()), float(0.5 * resolution * changes.max())
