"""Figure 22: joint 2 of a motion by the joystick, solved by DPSO at every sample and by DPSOIJ."""

from __future__ import annotations

import numpy as np
import xarray as xr

from scara_drake import metrics
from scara_drake.experiments.claim import Claim, Experiment, judge, variable
from scara_drake.joints import JOINT_NAMES, MAX_SPEED
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
            "q_desired": variable(
                joints, np.stack([r.q_desired for r in both]), units, "answers of the IK"
            ),
            "q_measured": variable(
                joints, np.stack([r.q_measured for r in both]), units, "joints of the plant"
            ),
            "tool_error": variable(
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
    largest, jumps = step.max("time"), (step > JUMP).sum("time")
    swarm, both = (float(largest.sel(solver=name)) for name in METHODS)
    settled = data.tool_error.sel(time=slice(START, None)).max("time")
    loose, tight = (float(settled.sel(solver=name)) for name in METHODS)
    period = float(np.diff(data.time).mean())
    bound = MAX_SPEED[JOINT_NAMES.index("theta2")] * period
    return [
        Claim(
            "DPSO at every sample throws joint 2 about",
            "large variations",
            f"up to {swarm:.1f} rad in a sample, {int(jumps.sel(solver='DPSO'))} above 0.5 rad in "
            f"{data.sizes['time']}",
            judge(swarm > JUMP and int(jumps.sel(solver="DPSO")) > 1, swarm > bound),
            "Criterion: more than one step above 0.5 rad (in kind: beyond the joint's speed).",
        ),
        Claim(
            "DPSOIJ is smooth",
            "smooth",
            f"steps up to {1e3 * both:.2f} mrad",
            judge(both <= bound, both <= JUMP),
            f"Criterion: no step beyond the joint's speed, {1e3 * bound:.1f} mrad a sample (in "
            "kind: none above 0.5 rad).",
        ),
        Claim(
            "Joints by DPSO cannot be controlled, those by DPSOIJ can",
            "impossible, feasible",
            f"tool off by up to {loose:.2g} m and {1e3 * tight:.2g} mm",
            judge(
                tight <= TOOL_BOUND and loose > 0.1,
                tight < loose,
            ),
            "Criterion: the simulated tool within 5 mm of its reference by DPSOIJ and more than "
            "100 mm off by DPSO (in kind: closer by DPSOIJ).",
        ),
    ]
