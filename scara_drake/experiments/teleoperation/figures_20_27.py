"""Figures 20, 21 and 23 to 27: teleoperation by a recorded operator, and whose error is whose.

The tool's error is the sum of three, sample by sample::

    commanded - measured =  (commanded - received)   the channel
                          + (received - desired)     the inverse kinematics and its limits of motion
                          + (desired - measured)     the controller
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import xarray as xr

from scara_drake import metrics
from scara_drake.experiments.claim import Claim, Criterion, Experiment, at_least, within
from scara_drake.experiments.quantity import quantity
from scara_drake.joints import JOINT_NAMES
from scara_drake.recordings.labels import labelled
from scara_drake.scenario import load_scenario
from scara_drake.simulation.run import simulate

SCENARIO = "free_motion"
START = 1.0  # [s]: before it the drives take up the weight of the arm
# The paper's raw law at the mast, in mm and N; and a stick whose data are taken as they come.
RUNS: dict[str, dict[str, Any]] = {
    "normalised": {},
    "mast in mm and N": {"controller.mode": ["paper"] + ["normalised"] * 5},
    "raw stick": {"operator.mapping.smoothing": 0.0, "operator.mapping.dead_zone": 0.0},
}
PAPER_MAST = quantity(2.0, "mm", "on average")
PAPER_SPIKES = quantity((40, 65, 80), "s", "spikes at about 40, 65 and 80 s")
PARTS = ("channel", "inverse kinematics", "controller")


def run(seed: int = 0, duration: float = 30.0) -> Experiment:
    """Simulate the recorded operator in free space with a varying delay.

    Args:
        seed: of the scenario.
        duration: [s]; the mast moves from 13 s on.
    """
    runs = [
        simulate(load_scenario(SCENARIO, {**overrides, "seed": seed}), duration=duration)
        for overrides in RUNS.values()
    ]
    path, joints = ("run", "time", "axis"), ("run", "time", "joint")
    units = "m for d1, rad for the others"
    first = runs[0]
    data = xr.Dataset(
        {
            **{
                name: labelled(
                    path, np.stack([r[name] for r in runs]), "m", runs[0][name].long_name
                )
                for name in ("p_WE_commanded", "p_WE_received", "p_WE_desired", "p_WE_measured")
            },
            **{
                name: labelled(
                    joints, np.stack([r[name] for r in runs]), units, first[name].long_name
                )
                for name in ("q_desired", "q_measured")
            },
            "tau": labelled(
                joints,
                np.stack([r.tau_applied for r in runs]),
                "N for d1, N m for the others",
                "effort of the drives",
            ),
        },
        coords={
            "run": list(RUNS),
            "time": ("time", first.time.values, {"units": "s"}),
            "axis": first.axis.values,
            "joint": list(JOINT_NAMES),
        },
        attrs={"seed": seed, "scenario": SCENARIO},
    )
    data["tool_error"] = tool_errors(data)
    return Experiment("Figures 20, 21 and 23 to 27", data, claims(data))


def tool_errors(data: xr.Dataset) -> xr.DataArray:
    """Split the tool's error (run, part, time, axis) [m] into its three parts, which add up."""
    stations = [data[f"p_WE_{name}"] for name in ("commanded", "received", "desired", "measured")]
    parts = [one - other for one, other in pairwise(stations)]
    errors = xr.concat(parts, xr.IndexVariable("part", list(PARTS)))
    errors.attrs = {"units": "m", "long_name": "error of the tool by its cause"}
    return errors


def _length(vectors: xr.DataArray) -> xr.DataArray:
    return (vectors**2).sum("axis") ** 0.5


def claims(data: xr.Dataset) -> list[Claim]:
    """Judge the figures; see `run` for the data."""
    settled = data.sel(time=slice(START, None))
    plain, raw = (settled.sel(run=name) for name in ("normalised", "raw stick"))
    rms = {
        part: 1e3 * float(metrics.rmse(_length(plain.tool_error.sel(part=part)))) for part in PARTS
    }
    inner = _length(plain.tool_error.sel(part=list(PARTS[1:])).sum("part"))
    in_loop = 1e3 * float(metrics.rmse(inner))
    return [
        _small(rms, 1e3 * float(metrics.rmse(_length(plain.tool_error.sum("part")))), in_loop),
        Claim(
            "The actual error exceeds the expected one, as it holds the errors of the inverse "
            "kinematics and of the control (Figure 24)",
            "actual above expected",
            quantity({"actual": in_loop, "expected": rms["controller"]}, "mm", "RMS"),
            Criterion(
                "the error with the inverse kinematics exceeds the controller's alone",
                in_loop > rms["controller"],
            ),
            f"The inverse kinematics alone err by {rms['inverse kinematics']:.2f} mm.",
        ),
        _acceptable(1e3 * metrics.peak(metrics.tracking_error(plain))),
        _spikes(plain, raw),
        _mast(settled),
        Claim(
            "How the expected error of Figure 24 is obtained",
            None,
            "the controller's part of the error",
            None,
            "Read as the error of the control process alone, of which the paper says that the "
            "actual one exceeds it.",
        ),
    ]


def _small(rms: dict[str, float], total: float, in_loop: float) -> Claim:
    return Claim(
        "The tool follows the joystick with a small error (Figures 20 and 21)",
        "small",
        quantity({**rms, "in all": total}, "mm", "RMS"),
        Criterion(
            "RMS below 1 mm by the controller and below 10 mm with the inverse kinematics (in "
            "kind: 20 mm)",
            rms["controller"] < 1.0 and in_loop < 10.0,
            in_loop < 20.0,
        ),
        "The paper gives curves without a number; the inverse kinematics keep limits of motion.",
    )


def _acceptable(peak: xr.DataArray) -> Claim:
    shown = {"joint 2": float(peak.sel(joint="theta2")), "joint 4": float(peak.sel(joint="theta4"))}
    return Claim(
        "Joints 2 and 4 track acceptably (Figures 23 to 26)",
        "acceptable",
        quantity(shown, "mrad", "at most"),
        Criterion("below 5 mrad at all times after the first second", max(shown.values()) < 5.0),
        "The paper gives curves without a number.",
    )


def _spikes(plain: xr.Dataset, raw: xr.Dataset) -> Claim:
    error = metrics.tracking_error(plain)
    spike = metrics.peak(metrics.tracking_error(raw)) / metrics.peak(error)
    rough = metrics.chatter(raw.tau) / metrics.chatter(plain.tau)
    return Claim(
        "Spikes come from the fluctuating data of a gaming joystick, not from the control",
        PAPER_SPIKES,
        (
            quantity(
                {f"joint {n}": float(spike.sel(joint=f"theta{n}")) for n in (2, 4)},
                "times as high",
                "peaks without smoothing and dead zone",
            ),
            quantity(rough.sel(joint="theta2"), "times as fast", "change of the torque of joint 2"),
        ),
        Criterion(
            "the spikes at their times (in kind: the same motion, taken as the stick gives it, has "
            "higher peaks)",
            False,
            bool((spike.sel(joint=["theta2", "theta4"]) > 1.0).all()),
        ),
        "The paper's recording is not published, so its three spikes cannot be replayed.",
    )


def _mast(settled: xr.Dataset) -> Claim:
    raw_mast = settled.sel(run="mast in mm and N")
    mast = 1e3 * metrics.tracking_error(raw_mast).sel(joint="d1")
    rising = raw_mast.q_desired.sel(joint="d1").differentiate("time") > 0.01
    still = float(mast.isel(time=-1))
    fast = float(mast.where(rising).max()) if bool(rising.any()) else still
    rest = quantity(still, "mm", "at rest, in mm and N")
    nominal = metrics.tracking_error(settled.sel(run="normalised")).sel(joint="d1")[-1]
    return Claim(
        "The mast keeps a steady error because of gravity, larger against gravity (Figure 27)",
        PAPER_MAST,
        (
            rest,
            quantity(fast, "mm", "while rising", "up to") if fast != still else "not raised",
            quantity(1e3 * abs(float(nominal)), "mm", "with the nominal inertia"),
        ),
        Criterion(
            "the paper's within 10 % (in kind: a tenth of it or more, and larger while rising)",
            within(rest, 0.1),
            (at_least(rest, 0.1), still < fast),
        ),
        f"The law in mm and N gives (m g - rho) / (k c) with Table 12, {still:.1f} mm at rest and "
        f"not {PAPER_MAST.values[0]:g}.",
    )
