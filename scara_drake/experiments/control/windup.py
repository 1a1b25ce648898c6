"""Wind-up: what clamping the integral does, and what it takes a governor to do. Not in the paper.

Six joints of one inertia each, the nominal one, under integral sliding mode control with Table 12.
A perturbation that exceeds rho winds the integral z up: clamping |s| ends that. Drives that cannot
follow a motion are another matter: nothing is wrong with the integral then, the reference has run
away, and it has to wait (`control/governor.py`).
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from scara_drake import joints, robot
from scara_drake.common.motion import minimum_jerk, minimum_jerk_rate
from scara_drake.control.governor import ReferenceGovernor
from scara_drake.control.integral_sliding_mode import IntegralSlidingMode
from scara_drake.control.ismc_law import GAINS
from scara_drake.experiments.claim import OURS, Claim, Criterion, Experiment
from scara_drake.experiments.quantity import quantity
from scara_drake.recordings.labels import labelled
from scara_drake.stability.joint_alone import make_rig, simulate

Array = NDArray[np.float64]

PERIOD = 1e-3  # [s]
EXCESS = 2.0  # perturbation, times rho
PUSH = (0.5, 3.5)  # [s], from and to
BAND = 0.02  # a joint is back within this share of its largest deviation
RECOVERY, LONGER = 0.8, 3.0  # [s] with the clamp, and how many times that without
DEMAND = 2.0  # peak acceleration of the motion, times what the drives can give
DISPLACEMENT = 1.0  # [m, rad]
OVERSHOOT = 0.01  # of the displacement; less counts as none

CLAMPS = ("clamp", "no clamp")
PROTECTIONS = ("no clamp", "clamp", "clamp and governor")


def run(seed: int = 0, duration: float = 9.0) -> Experiment:
    """Push the joints beyond rho, and ask more of the drives than they can give.

    Args:
        seed: nothing is drawn.
        duration: [s], of either simulation.
    """
    time: Array = np.array([PERIOD * step for step in range(round(duration / PERIOD))])
    pushed = np.stack([_push(time, clamp) for clamp in CLAMPS])
    moved = np.stack([_move(time, protection) for protection in PROTECTIONS])
    units = "m for d1, rad for the others"
    data = xr.Dataset(
        {
            "deviation": labelled(
                ("anti_windup", "time", "joint"), pushed, units, "under the perturbation"
            ),
            "q": labelled(
                ("protection", "time", "joint"), moved, units, "motion with limited drives"
            ),
            "q_desired": labelled(("time", "joint"), _reference(time)[:, :6], units, "its source"),
            "perturbation": labelled(
                ("joint",),
                EXCESS * np.array(IntegralSlidingMode().rho),
                "m/s^2 for d1, rad/s^2 for the others",
                "acceleration by the perturbation",
            ),
        },
        coords={
            "time": ("time", time, {"units": "s"}),
            "joint": list(joints.JOINT_NAMES),
            "anti_windup": list(CLAMPS),
            "protection": list(PROTECTIONS),
        },
        attrs={"seed": seed},
    )
    return Experiment("Wind-up", data, claims(data))


def recovery_time(data: xr.Dataset) -> xr.DataArray:
    """Time (anti_windup, joint) [s] from the end of the push until a joint stays in its band."""
    size = abs(data.deviation)
    outside = size > BAND * size.max("time")
    return (data.time * outside).max("time") - PUSH[1]


def overshoot(data: xr.Dataset) -> xr.DataArray:
    """Largest passing of the goal (protection, joint), as a share of the displacement."""
    goal = data.q_desired.isel(time=-1)
    return ((data.q.max("time") - goal) / DISPLACEMENT).clip(min=0.0)


def ahead_of(data: xr.Dataset) -> xr.DataArray:
    """Largest lead of the source over a joint (protection, joint), as a share of the way."""
    return (data.q_desired - data.q).max("time") / DISPLACEMENT


def claims(data: xr.Dataset) -> list[Claim]:
    """Say what was found; see `run` for the data."""
    return [_clamped(recovery_time(data)), _governed(overshoot(data), ahead_of(data))]


def _clamped(recovery: xr.DataArray) -> Claim:
    clamped, wound = recovery.sel(anti_windup="clamp"), recovery.sel(anti_windup="no clamp")
    ratio = wound / clamped
    return Claim(
        "A perturbation beyond rho winds the integral up, and clamping it ends that",
        None,
        (
            quantity(clamped, "s", "back after, with the clamp"),
            quantity(wound, "s", "without"),
        ),
        Criterion(
            f"after {PUSH[1] - PUSH[0]:g} s of {EXCESS:g} rho each joint within {100 * BAND:g} % "
            f"of its largest deviation in less than {RECOVERY:g} s, and more than {LONGER:g} times "
            "as late without the clamp",
            bool((clamped < RECOVERY).all()) and bool((ratio > LONGER).all()),
        ),
        f"Without the clamp it takes {quantity(ratio)} times as long. The paper's law has none.",
        OURS,
    )


def _governed(passed: xr.DataArray, ahead: xr.DataArray) -> Claim:
    shares = {name: passed.sel(protection=name) for name in PROTECTIONS}
    governed = shares["clamp and governor"]
    return Claim(
        "Drives at their limits need more than a clamp: the reference has to wait",
        None,
        tuple(quantity(100 * share, "%", f"overshoot, {name}") for name, share in shares.items()),
        Criterion(
            f"a motion that asks for {DEMAND:g} times the acceleration of the drives passes its "
            f"goal by less than {100 * OVERSHOOT:g} % with the governor, and by more than 5 % with "
            "the clamp alone",
            bool((governed < OVERSHOOT).all()) and bool((shares["clamp"] > 0.05).all()),
        ),
        "With the clamp the reference runs ahead of the joint by up to "
        f"{quantity(100 * ahead.sel(protection='clamp'), '%')} of the way, with the governor "
        f"by {quantity(100 * ahead.sel(protection='clamp and governor'), '%')} before it waits.",
        OURS,
    )


def _gains(clamped: bool, limit: Array | float) -> Array:
    """Return the gains of Table 12 with m_hat = 1 and effort limits [m/s², rad/s²]."""
    gains = IntegralSlidingMode(anti_windup=clamped).array(PERIOD)
    g = GAINS.unpack(gains)
    g.m_hat[:], g.effort[:] = 1.0, limit
    return gains


def _push(time: Array, clamp: str) -> Array:
    gains = _gains(clamp == "clamp", np.inf)
    pushing = (time >= PUSH[0]) & (time < PUSH[1])
    perturbation = pushing[:, None] * EXCESS * GAINS.unpack(gains).rho
    at_rest = np.zeros((time.size, 12))
    return motion(at_rest, gains, False, perturbation)


def _drives() -> Array:
    """Acceleration (6,) that the drives can give, the mast upwards [m/s², rad/s²]."""
    weight = np.array([9.81, 0.0, 0.0, 0.0, 0.0, 0.0])
    return joints.EFFORT / robot.nominal_inertias() - weight


def _reference(time: Array) -> Array:
    """Minimum-jerk motions (steps, 12) whose peak acceleration, 10 / sqrt(3) D / T², is DEMAND."""
    duration = np.sqrt(10.0 / np.sqrt(3.0) * DISPLACEMENT / (DEMAND * _drives()))
    x = np.clip(time[:, None] / duration, 0.0, 1.0)
    q = DISPLACEMENT * minimum_jerk(x)
    v = DISPLACEMENT * minimum_jerk_rate(x) / duration
    return np.hstack([q, v])


def _move(time: Array, protection: str) -> Array:
    gains = _gains(protection != "no clamp", _drives())
    return motion(_reference(time), gains, protection == "clamp and governor")


def motion(
    reference: Array, gains: Array, governed: bool, perturbation: Array | None = None
) -> Array:
    """Return q (steps, 6) of six joints q'' = u + d, from rest at the first reference.

    Args:
        reference: q, v of each sample (steps, 12).
        gains: of `ismc_law` (8, 6), with m_hat = 1.
        governed: whether the governor acts.
        perturbation: d (steps, 6) [m/s², rad/s²], held from sample to sample; None is zero.
    """
    steps = len(reference)
    bounds = ReferenceGovernor().array() if governed else 0.0
    return simulate(
        "ISMC",
        gains,
        make_rig(bounds=bounds),
        reference.reshape(steps, 2, 6),
        None if perturbation is None else perturbation[:, np.newaxis],
        start=reference[0, :6],
    ).x
