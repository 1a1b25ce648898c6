"""Figure 22: joint 2 of a motion by the joystick, solved by DPSO at every sample and by DPSOIJ."""

from __future__ import annotations

import numpy as np
import xarray as xr

from scara_drake import ik, kinematics
from scara_drake.experiments.claim import Claim, Criterion, Experiment
from scara_drake.experiments.quantity import quantity
from scara_drake.joints import JOINT_NAMES, MAX_SPEED
from scara_drake.recordings.labels import labelled
from scara_drake.scenario import load_scenario
from scara_drake.simulation.run import simulate

METHODS = {"DPSO": "dpso", "DPSOIJ": "dpsoij"}
EVERY = 10  # samples of 1 ms, from one answer of the swarm alone to the next
JUMP = 0.5  # [rad] from answer to answer
START = 1.0  # [s]: before it the drives take up the weight of the arm
TOOL_BOUND = 5e-3  # [m]


def run(seed: int = 0, duration: float = 3.0) -> Experiment:
    """Simulate the shipped free motion with each method, for the position only as in the paper.

    In the loop the references keep to the speeds of the joints whatever the method answers, so the
    answers themselves are asked for beside it: of DPSO by itself for each pose, of DPSOIJ along
    the motion.

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
    # By DPSOIJ the references are the answers; their tool is where the command that has arrived is.
    asked = runs["DPSOIJ"]
    along = asked.q_desired.isel(time=slice(None, None, EVERY))
    poses = kinematics.forward_kinematics(along.values)
    alone = ik.solve_path(
        poses, "dpso", "arm", "position", q_seed=along.values[0], seed=seed, polish=False
    )
    joints = ("solver", "time", "joint")
    units = "m for d1, rad for the others"
    off = [(asked.p_WE_desired - r.p_WE_measured).values for r in both]
    data = xr.Dataset(
        {
            "answer": labelled(
                ("solver", "answer_time", "joint"),
                np.stack([alone.q, along.values]),
                units,
                "answers of the IK",
            ),
            "q_desired": labelled(
                joints, np.stack([r.q_desired for r in both]), units, "references in the loop"
            ),
            "q_measured": labelled(
                joints, np.stack([r.q_measured for r in both]), units, "joints of the plant"
            ),
            "tool_error": labelled(
                ("solver", "time"),
                np.linalg.norm(off, axis=-1),
                "m",
                "distance of the tool of the plant from where it is commanded",
            ),
        },
        coords={
            "solver": list(runs),
            "time": ("time", asked.time.values, {"units": "s"}),
            "answer_time": ("answer_time", along.time.values, {"units": "s"}),
            "joint": list(JOINT_NAMES),
        },
        attrs={"seed": seed, "scenario": "free_motion"},
    )
    return Experiment("Figure 22", data, claims(data))


def claims(data: xr.Dataset) -> list[Claim]:
    """Judge Figure 22; see `run` for the data."""
    step = abs(data.answer.sel(joint="theta2").diff("answer_time"))
    largest = step.max("answer_time")
    swarm, both = (float(largest.sel(solver=name)) for name in METHODS)
    jumps = int((step > JUMP).sum("answer_time").sel(solver="DPSO"))
    every = float(np.diff(data.answer_time).mean())
    bound = MAX_SPEED[JOINT_NAMES.index("theta2")] * every
    speed = f"The joint's speed lets it turn {1e3 * bound:.0f} mrad in {1e3 * every:.0f} ms."
    between = f"in {1e3 * every:.0f} ms"
    return [
        Claim(
            "DPSO at every sample throws joint 2 about",
            "large variations",
            (
                quantity(swarm, "rad", between, "up to"),
                quantity(jumps, f"of {step.sizes['answer_time']} steps", f"above {JUMP} rad"),
            ),
            Criterion(
                f"more than one step above {JUMP} rad (in kind: beyond the joint's speed); both "
                "bounds are ours",
                swarm > JUMP and jumps > 1,
                swarm > bound,
            ),
            f"Each answer is a draw of its own, on any branch. {speed}",
        ),
        Claim(
            "DPSOIJ is smooth",
            "smooth",
            quantity(1e3 * both, "mrad", between, "up to"),
            Criterion(
                f"no step beyond the joint's speed (in kind: none above {JUMP} rad); both "
                "bounds are ours",
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
            f"the simulated tool within {1e3 * TOOL_BOUND:g} mm of where it is commanded by DPSOIJ "
            "and more than 100 mm off by DPSO (in kind: closer by DPSOIJ); the 100 mm are ours",
            tight <= TOOL_BOUND and loose > 0.1,
            tight < loose,
        ),
        "The references in the loop keep to the speeds of the joints: they are always on the way "
        "to an answer, and the next one is elsewhere.",
    )
