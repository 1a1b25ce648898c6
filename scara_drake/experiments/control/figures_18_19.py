"""Figures 18 and 19: joints 2 and 4 on a sine, with the whole arm, and with an arm unlike it.

The law has one nominal inertia a joint and no model, so it is also run with link masses 30 % off
and with a load that it is not told of.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import xarray as xr

from scara_drake import joints, metrics
from scara_drake.experiments.claim import NOT_COMPARABLE, Claim, Experiment, judge, variable
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
    dims = ("run", "time", "joint")

    def stacked(name: str, units: str, long_name: str) -> xr.Variable:
        return variable(dims, np.stack([r[name] for r in runs]), units, long_name)

    units = "m for d1, rad for the others"
    efforts = "N for d1, N m for the others"
    data = xr.Dataset(
        {
            "q_desired": stacked("q_desired", units, "references"),
            "q_measured": stacked("q_measured", units, "positions"),
            "tau": stacked("tau_applied", efforts, "effort of the drives"),
        },
        coords={
            "run": list(RUNS),
            "time": ("time", runs[0].time.values, {"units": "s"}),
            "joint": list(joints.JOINT_NAMES),
        },
        attrs={"seed": seed, "scenario": SCENARIO},
    )
    return Experiment("Figures 18 and 19", data, claims(data))


def claims(data: xr.Dataset) -> list[Claim]:
    """Judge the figures; see `run` for the data."""
    late = data.sel(time=slice(START, None))
    error = metrics.tracking_error(late)
    largest = metrics.peak(error.sel(joint=ARM))
    catching_up = metrics.peak(metrics.tracking_error(data))
    change = metrics.chatter(late.tau.sel(joint=ARM))
    nominal = largest.sel(run="nominal")
    shown = nominal.sel(joint=JOINTS)
    others = largest.drop_sel(run="nominal")
    worst = {name: float(others.sel(run=name).max()) for name in others.run.values}
    rough = float(change.sel(run="nominal").max())
    return [
        Claim(
            "Joints 2 and 4 follow the sine of 0.7854 rad and 1.25 rad/s (Figures 18 and 19)",
            "a curve, no number",
            f"within {_milli(shown[0])} and {_milli(shown[1])} mrad after the first second, RMS "
            f"{_milli(metrics.rmse(error).sel(run='nominal', joint=JOINTS).max())} mrad",
            judge(bool((shown < SMALL).all()), bool((shown < LARGER).all())),
            f"Criterion: within {1e3 * SMALL:g} mrad after the first second (in kind: "
            f"{1e3 * LARGER:g} mrad). The arm starts at rest, and falls behind by "
            f"{_milli(catching_up.sel(run='nominal', joint=JOINTS).max())} mrad at first.",
        ),
        Claim(
            "ISMC does without the high switching gains that make the effort chatter",
            "no number",
            f"mean change of the torque of a joint {rough:.3f} N m a tick at most",
            judge(rough < QUIET),
            f"Criterion: below {QUIET:g} N m a tick of 1 ms on each of joints 2 to 6, after the "
            "first second.",
        ),
        Claim(
            "ISMC performs well without information on the dynamics",
            "no number",
            "largest error of joints 2 to 6: "
            + ", ".join(f"{name} {_milli(value)} mrad" for name, value in worst.items()),
            judge(max(worst.values()) < LARGER),
            f"Criterion: below {1e3 * LARGER:g} mrad on each after the first second, with the "
            "gains and inertias of the nominal arm. The load is 0.1 m off the tool's axis.",
        ),
        Claim(
            "Posture and references of the other joints",
            "not given",
            "joints 3, 5 and 6 hold 0.3, 0.5 and 0 rad, the mast rises by 0.5 m",
            NOT_COMPARABLE,
            "Nothing to compare with; the mast's move makes the test harder.",
        ),
    ]


def _milli(value: xr.DataArray | float) -> str:
    return f"{1e3 * float(value):.3f}"
