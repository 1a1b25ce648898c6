"""Figure 22: joint 2 of a motion by the joystick, solved by DPSO at every sample and by DPSOIJ."""

from __future__ import annotations

import numpy as np
import xarray as xr

from scara_drake import metrics
from scara_drake.experiments.claim import Claim, Criterion, Experiment
from scara_drake.experiments.quantity import quantity
from scara_drake.joints import JOINT_NAMES, MAX_SPEED
from scara_drake.recordings.labels import labelled
from scara_drake.scenario import load_scenario
from scara_drake.simulation.run import simulate

METHODS = {"DPSO": "dpso", "DPSOIJ": "dpsoij"}
JUMP = 0.5  # [rad] in one sample of 1 ms
START = 1.0  # [s]: before it the drives take up the weight of the arm
TOOL_BOUND = 5e-3  # [m]


def run(seed: int = 0, duration: float = 3.0) -> Experiment:
    """Simulate the shipped free motion with each method, for the position only as in the paper.

    Args:
        seed: of the swarms.
        duration: [s], of the motion; the tool begins to move at about 1.6 s.
    """
    runs = {
        name: simulate(
            load_scenario("free_motion", {"inverse_kinematics.method": method, "seed": seed}),
            duration=duration,
        )
        for name, method in METHODS.items()
    }
    both = list(runs.values())
    joints = ("solver", "time", "joint")
    units = "m for d1, rad for the others"
    data = xr.Dataset(
        {
            "q_desired": labelled(
                joints, np.stack([r.q_desired for r in both]), units, "answers of the IK"
            ),
            "q_measured": labelled(
                joints, np.stack([r.q_measured for r in both]), units, "joints of the plant"
            ),
            "tool_error": labelled(
                ("solver", "time"),
                np.stack([metrics.tool_error(r) for r in both]),
                "m",
                "distance of the tool of the plant to that of the references",
            ),
        },
        coords={
            "solver": list(runs),
            "time": ("time", both[0].time.values, {"units": "s"}),
            "joint": list(JOINT_NAMES),
        },
        attrs={"seed": seed, "scenario": "free_motion"},
    )
    return Experiment("Figure 22", data, claims(data))


def claims(data: xr.Dataset) -> list[Claim]:
    """Judge Figure 22; see `run` for the data."""
    step = abs(data.q_desired.sel(joint="theta2").diff("time"))
    largest = step.max("time")
    swarm, both = (float(largest.sel(solver=name)) for name in METHODS)
    jumps = int((step > JUMP).sum("time").sel(solver="DPSO"))
    bound = MAX_SPEED[JOINT_NAMES.index("theta2")] * float(np.diff(data.time).mean())
    speed = f"The joint's speed lets it turn {1e3 * bound:.1f} mrad in a sample."
    return [
        Claim(
            "DPSO at every sample throws joint 2 about",
            "large variations",
            (
                quantity(swarm, "rad", "in a sample", "up to"),
                quantity(jumps, f"of {data.sizes['time']} samples", f"above {JUMP} rad"),
            ),
            Criterion(
                f"more than one step above {JUMP} rad (in kind: beyond the joint's speed)",
                swarm > JUMP and jumps > 1,
                swarm > bound,
            ),
            speed,
        ),
        Claim(
            "DPSOIJ is smooth",
            "smooth",
            quantity(1e3 * both, "mrad", "in a sample", "up to"),
            Criterion(
                f"no step beyond the joint's speed (in kind: none above {JUMP} rad)",
                both <= bound,
                both <= JUMP,
            ),
            speed,
        ),
        _controlled(data.tool_error.sel(time=slice(START, None)).max("time")),
    ]


def _controlled(off: xr.DataArray) -> Claim:
    loose, tight = (float(off.sel(solver=name)) for name in METHODS)
    return Claim(
        "Joints by DPSO cannot be controlled, those by DPSOIJ can",
        "impossible, feasible",
        quantity({"DPSO": 1e3 * loose, "DPSOIJ": 1e3 * tight}, "mm", "tool off by up to"),
        Criterion(
            f"the simulated tool within {1e3 * TOOL_BOUND:g} mm of its reference by DPSOIJ and "
            "more than 100 mm off by DPSO (in kind: closer by DPSOIJ)",
            tight <= TOOL_BOUND and loose > 0.1,
            tight < loose,
        ),
        "The drives cannot follow a reference that jumps at every sample.",
    )
