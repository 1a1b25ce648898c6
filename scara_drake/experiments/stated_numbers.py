"""Tables 1 to 4, 11 and 12: the numbers that the model, the surfaces and the controller carry.

They are read from what runs, the plant of the URDF and the parts of a scenario, and not from where
the program writes them down.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Final

import numpy as np
import xarray as xr
from pydrake.multibody.plant import MultibodyPlant

from scara_drake.control.integral_sliding_mode import IntegralSlidingMode
from scara_drake.environment.wall import Wall
from scara_drake.experiments.claim import Claim, Criterion, Experiment, within
from scara_drake.experiments.quantity import quantity
from scara_drake.joints import JOINT_NAMES, LOWER, UPPER
from scara_drake.recordings.labels import labelled
from scara_drake.robot import TOOL_FRAME, add_scara
from scara_drake.scenario import load_scenario

EXACT: Final = 1e-9  # share of a number: what its conversion to SI units may lose
LENGTHS: Final = (750.0, 820.0, 730.0)  # d3, a4, d6 [mm]
ALPHA: Final = (0.0, -math.pi / 2, math.pi / 2, 0.0, math.pi / 2, 0.0)
TURN: Final = 2.0 * math.pi
MAST: Final = (2500.0, 10000.0)  # [mm]
ARM: Final = (TURN, TURN, 0.75 * math.pi, 0.75 * math.pi, TURN)  # to either side [rad]
MASSES: Final = (345.9, 88.0, 139.7, 129.4, 20.8, 11.7)  # [kg]
DAMPING, STIFFNESS = 100.0, 1e4  # [kg/s], [kg/s²]
GAINS: Final = {  # k and c [1/s], rho [m/s² and rad/s², as (30) has it]
    "Table 11": {
        "k": (150.0, 50.0, 35.0, 25.0, 20.0, 20.0),
        "c": (50.0, 20.0, 20.0, 15.0, 10.0, 10.0),
        "rho": (300.0, 150.0, 150.0, 120.0, 100.0, 100.0),
    },
    "Table 12": {
        "k": (150.0, 100.0, 100.0, 75.0, 40.0, 20.0),
        "c": (50.0, 50.0, 50.0, 40.0, 10.0, 10.0),
        "rho": (500.0, 150.0, 150.0, 120.0, 100.0, 100.0),
    },
}
POSTURES: Final = 100


def table_1(seed: int = 0) -> Experiment:
    """Compare the model's joint frames with the rows of Denavit and Hartenberg.

    Args:
        seed: of the postures.
    """
    plant = _plant()
    frames = [plant.GetJointByName(name).frame_on_parent() for name in JOINT_NAMES]
    frames.append(plant.GetFrameByName(TOOL_FRAME))
    context = plant.CreateDefaultContext()
    pairs = (frames[2:4], frames[3:5], frames[5:7])
    lengths = [
        1e3 * float(np.linalg.norm(end.CalcPose(context, start).translation()))
        for start, end in pairs
    ]
    apart = []
    for q in np.random.default_rng(seed).uniform(LOWER, UPPER, (POSTURES, 6)):
        plant.SetPositions(context, q)
        X_WE = frames[-1].CalcPoseInWorld(context).GetAsMatrix4()
        apart.append(np.abs(X_WE - _product_of_rows(q)).max())
    off = max(*apart, 1e-16)
    data = _numbers(seed, apart=apart, lengths=lengths)
    return Experiment(
        "Table 1",
        data,
        [
            _equal("d3, a4 and d6", {"mm": (LENGTHS, lengths)}, "From joint to joint in the URDF."),
            Claim(
                "The tool's pose is the product of the six rows",
                "Rz(θ) Tz(d) Tx(a) Rx(α)",
                quantity(10.0 ** math.ceil(math.log10(off)), "", "in m and rotations", "below"),
                Criterion("below 1e-12, in position and in rotation", bool(off < 1e-12)),
                "The URDF in Drake against the rows multiplied here, mast height included.",
            ),
        ],
    )


def table_2(seed: int = 0) -> Experiment:
    """Compare the limits of the model's joints; nothing is random."""
    plant = _plant()
    low, high = plant.GetPositionLowerLimits(), plant.GetPositionUpperLimits()
    where = "Limits of the joints in the URDF."
    claims = [
        _equal("Range of the mast", {"mm": (MAST, (1e3 * low[0], 1e3 * high[0]))}, where),
        _equal(
            "Ranges of joints 2 to 6, to either side",
            {"rad, to the left": (ARM, -low[1:]), "rad, to the right": (ARM, high[1:])},
            where,
        ),
    ]
    return Experiment("Table 2", _numbers(seed, low=low, high=high), claims)


def table_3(seed: int = 0) -> Experiment:
    """Compare the masses of the model's links; nothing is random."""
    plant = _plant()
    context = plant.CreateDefaultContext()
    links = [plant.GetJointByName(name).child_body() for name in JOINT_NAMES]
    masses = [link.get_mass(context) for link in links]
    total = quantity(sum(masses), "kg")
    return Experiment(
        "Table 3",
        _numbers(seed, mass=masses),
        [
            _equal(
                "Masses of joints 1 to 6", {"kg": (MASSES, masses)}, "Of the links in the URDF."
            ),
            Claim(
                "The mast carries approximately 735 kg",
                quantity(735.0, "kg"),
                total,
                Criterion("within 1 kg, the paper's last digit", within(total, 1.0 / 735.0)),
                "The sum of Table 3, all of which the mast lifts.",
            ),
        ],
    )


def table_4(seed: int = 0) -> Experiment:
    """Compare the impedance of a wall as it is by default; nothing is random."""
    wall = Wall()
    claim = _equal(
        "Damping and stiffness of the environment",
        {"kg/s": ((DAMPING,), (wall.damping,)), "kg/s²": ((STIFFNESS,), (wall.stiffness,))},
        "Defaults of a surface; kg/s is N s/m and kg/s² is N/m.",
    )
    data = _numbers(seed, damping=[wall.damping], stiffness=[wall.stiffness])
    return Experiment("Table 4", data, [claim])


def table_11(seed: int = 0) -> Experiment:
    """Compare the gains of the scenarios joint_sine and mast_step; nothing is random."""
    return _gains("Table 11", seed, ("joint_sine", "mast_step"))


def table_12(seed: int = 0) -> Experiment:
    """Compare the gains of the scenario teleoperation; nothing is random."""
    return _gains("Table 12", seed, ("teleoperation",))


def _gains(table: str, seed: int, scenarios: tuple[str, ...]) -> Experiment:
    claims: list[Claim] = []
    kept: dict[str, np.ndarray] = {}
    for name in scenarios:
        controller = load_scenario(name).controller
        if not isinstance(controller, IntegralSlidingMode):
            raise ValueError(f"controller of {name}: allowed an IntegralSlidingMode")
        found = {gain: np.array(getattr(controller, gain)) for gain in GAINS[table]}
        kept |= {f"{gain}_{name}": values for gain, values in found.items()}
        pairs = {gain: (GAINS[table][gain], values) for gain, values in found.items()}
        reason = "k and c in 1/s, rho in m/s² and rad/s², as (30) has it."
        claims.append(_equal(f"Gains of the scenario {name}", pairs, reason))
    return Experiment(table, _numbers(seed, **kept), claims)


def _equal(statement: str, pairs: Mapping[str, tuple[Any, Any]], reason: str) -> Claim:
    """Judge whether stated numbers are those that were found: (stated, found) by their unit."""
    same = all(np.allclose(found, stated, EXACT, 0.0) for stated, found in pairs.values())
    paper, here = (
        "; ".join(f"{_listed(pair[which])} {unit}" for unit, pair in pairs.items())
        for which in (0, 1)
    )
    return Claim(statement, paper, here, Criterion("all equal", same), reason)


def _listed(values: Any) -> str:
    return ", ".join(f"{round(float(value), 3):g}" for value in values)


def _numbers(seed: int, **rows: Any) -> xr.Dataset:
    arrays = {name: labelled((f"{name}_entry",), row, "", name) for name, row in rows.items()}
    return xr.Dataset(arrays, attrs={"seed": seed})


def _plant() -> MultibodyPlant:
    plant = MultibodyPlant(time_step=0.0)
    add_scara(plant)
    plant.Finalize()
    return plant


def _product_of_rows(q: np.ndarray) -> np.ndarray:
    """Return Rz(theta) Tz(d) Tx(a) Rx(alpha) of the six rows, multiplied (4, 4)."""
    d = [q[0], 0.0, LENGTHS[0] / 1e3, 0.0, 0.0, LENGTHS[2] / 1e3]
    a = [0.0, 0.0, 0.0, LENGTHS[1] / 1e3, 0.0, 0.0]
    X = np.eye(4)
    for theta, d_i, a_i, alpha in zip([0.0, *q[1:]], d, a, ALPHA, strict=True):
        ct, st, ca, sa = math.cos(theta), math.sin(theta), math.cos(alpha), math.sin(alpha)
        X = X @ np.array(
            [
                [ct, -st * ca, st * sa, a_i * ct],
                [st, ct * ca, -ct * sa, a_i * st],
                [0.0, sa, ca, d_i],
                [0.0, 0.0, 0.0, 1.0],
            ]
        )
    return X
