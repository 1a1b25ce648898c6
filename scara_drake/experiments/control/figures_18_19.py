"""Figures 18 and 19: joints 2 and 4 on a sine, with the whole arm, and with an arm unlike it.

The law has one nominal inertia a joint and no model, so it is also run with link masses 30 % off
and with a load that it is not told of.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import xarray as xr

from scara_drake import joints, metrics
from scara_drake.experiments.claim import Claim, Criterion, Experiment
from scara_drake.experiments.quantity import quantity
from scara_drake.experiments.reading import OpenQuestion, Reading
from scara_drake.recordings.labels import labelled
from scara_drake.scenario import load_scenario
from scara_drake.simulation.run import simulate

SCENARIO = "joint_sine"  # Table 11
JOINTS: Final = ["theta2", "theta4"]
ARM: Final = list(joints.JOINT_NAMES[1:])
# The sine has a velocity at 0 s and the arm has none: the law catches up with it first.
START = 1.0  # [s]
RUNS: Final[dict[str, dict[str, Any]]] = {
    "nominal": {},
    "masses 30 % up": {"robot.mass_scale": 1.3},
    "masses 30 % down": {"robot.mass_scale": 0.7},
    # z of the tool frame is the tool's axis, about which joint 6 turns.
    "10 kg at the tool": {"robot.payload_mass": 10.0, "robot.payload_offset": [0.0, 0.1, 0.0]},
}
FOLLOW: Final = "Joints 2 and 4 follow the sine of 0.7854 rad and 1.25 rad/s (Figures 18 and 19)"
RAW: Final[dict[str, Any]] = {"controller.mode": ["paper"] * 6, "controller.allow_chatter": True}
UNITS: Final = {
    "acceleration": (
        "m/s² and rad/s², times the nominal inertia of each joint", "q_measured", "tau"
    ),
    "N m": ("effort in N and N m of errors in mm and rad", "q_raw", "tau_raw"),
}  # fmt: skip
SMALL, LARGER = 0.3e-3, 3e-3  # [rad]
QUIET = 1.0  # [N m]


def run(seed: int = 0, duration: float = 10.0) -> Experiment:
    """Simulate the sines with each robot.

    Args:
        seed: of the scenario; nothing is random.
        duration: [s].
    """
    runs = [
        simulate(load_scenario(SCENARIO, {**changes, "seed": seed}), duration=duration)
        for changes in RUNS.values()
    ]
    raw = simulate(load_scenario(SCENARIO, {**RAW, "seed": seed}), duration=duration)
    dims = ("run", "time", "joint")

    def stacked(name: str, units: str, long_name: str) -> xr.Variable:
        return labelled(dims, np.stack([r[name] for r in runs]), units, long_name)

    units = "m for d1, rad for the others"
    efforts = "N for d1, N m for the others"
    data = xr.Dataset(
        {
            "q_desired": stacked("q_desired", units, "references"),
            "q_measured": stacked("q_measured", units, "positions"),
            "tau": stacked("tau_applied", efforts, "effort of the drives"),
            "q_raw": labelled(
                dims[1:], raw.q_measured.values, units, "positions by the law in N and N m"
            ),
            "tau_raw": labelled(dims[1:], raw.tau_applied.values, efforts, "effort of that law"),
        },
        coords={
            "run": list(RUNS),
            "time": ("time", runs[0].time.values, {"units": "s"}),
            "joint": list(joints.JOINT_NAMES),
        },
        attrs={"seed": seed, "scenario": SCENARIO},
    )
    return Experiment("Figures 18 and 19", data, claims(data), questions(data))


def questions(data: xr.Dataset) -> tuple[OpenQuestion, ...]:
    """Show what the errors become by other units of u; see `run` for the data."""
    late = data.sel(time=slice(START, None), joint=JOINTS, run="nominal")
    readings = []
    for name, (meaning, measured, effort) in UNITS.items():
        error = abs(late.q_desired - late[measured])
        shown = 1e3 * error.max("time")
        found = {
            "largest error": quantity(_by_joint(shown), "mrad"),
            "RMS": quantity(_by_joint(1e3 * metrics.rmse(error)), "mrad"),
            "largest effort": quantity(_by_joint(abs(late[effort]).max("time")), "N m"),
        }
        verdict = _within(shown).verdict(None)
        readings.append(Reading(name, meaning, found, verdict, measured == "q_measured"))
    return (OpenQuestion("In which units is u?", FOLLOW, tuple(readings)),)


def _by_joint(values: xr.DataArray) -> dict[str, float]:
    return {f"joint {n}": float(values.sel(joint=f"theta{n}")) for n in (2, 4)}


def _within(shown: xr.DataArray) -> Criterion:
    return Criterion(
        f"within {1e3 * SMALL:g} mrad after the first second (in kind: {1e3 * LARGER:g} mrad); "
        "both are ours",
        bool((shown < 1e3 * SMALL).all()),
        bool((shown < 1e3 * LARGER).all()),
    )


def claims(data: xr.Dataset) -> list[Claim]:
    """Judge the figures; see `run` for the data."""
    late = data.sel(time=slice(START, None))
    error = metrics.tracking_error(late)
    largest = 1e3 * metrics.peak(error.sel(joint=ARM))
    change = metrics.chatter(late.tau.sel(joint=ARM))
    return [
        _followed(data, error, largest.sel(run="nominal", joint=JOINTS)),
        _quiet(change),
        _unlike(largest.drop_sel(run="nominal")),
        Claim(
            "Posture and references of the other joints",
            None,
            "joints 3, 5 and 6 hold 0.3, 0.5 and 0 rad, the mast rises by 0.5 m",
            None,
            "Nothing to compare with; the mast's move makes the test harder.",
        ),
    ]


def _followed(data: xr.Dataset, error: xr.DataArray, shown: xr.DataArray) -> Claim:
    nominal = {"run": "nominal", "joint": JOINTS}
    behind = 1e3 * float(metrics.peak(metrics.tracking_error(data)).sel(nominal).max())
    return Claim(
        FOLLOW,
        "a curve, no number",
        (
            quantity(
                _by_joint(shown),
                "mrad",
                "at most, after the first second",
            ),
            quantity(1e3 * metrics.rmse(error).sel(nominal).max(), "mrad", "RMS"),
        ),
        _within(shown),
        f"The arm starts at rest, and falls behind by {behind:.3f} mrad at first.",
    )


def _quiet(change: xr.DataArray) -> Claim:
    rough = float(change.sel(run="nominal").max())
    return Claim(
        "ISMC does without the high switching gains that make the effort chatter",
        None,
        quantity(rough, "N m a tick", "mean change of the torque of a joint", "at most"),
        Criterion(
            f"below {QUIET:g} N m a tick of 1 ms on each of joints 2 to 6, after the first second; "
            "the bound is ours",
            rough < QUIET,
        ),
        f"Over the other arms it is {float(change.max()):.3f} N m a tick at most.",
    )


def _unlike(largest: xr.DataArray) -> Claim:
    worst = {str(name): float(largest.sel(run=name).max()) for name in largest.run.values}
    return Claim(
        "ISMC performs well without information on the dynamics",
        None,
        quantity(worst, "mrad", "largest error of joints 2 to 6"),
        Criterion(
            f"below {1e3 * LARGER:g} mrad on each after the first second, with the gains and "
            "inertias of the nominal arm; the bound is ours",
            max(worst.values()) < 1e3 * LARGER,
        ),
        "The law has one nominal inertia a joint; the load is 0.1 m off the tool's axis.",
    )
