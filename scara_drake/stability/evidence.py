"""Poles, delays and Lyapunov's function for the gains of Tables 11 and 12, as labelled data."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Final

import numpy as np
import xarray as xr

from scara_drake import joints, metrics, robot
from scara_drake.common.parallel import side_by_side
from scara_drake.control.integral_sliding_mode import IntegralSlidingMode
from scara_drake.control.ismc_law import GAINS
from scara_drake.recordings.labels import labelled
from scara_drake.scenario import Scenario, load_scenario
from scara_drake.simulation.run import simulate
from scara_drake.stability.delay_margin import (
    arm_onset,
    delay_margin,
    mass_ratios,
    onset,
    simulated_onset,
)
from scara_drake.stability.linear import least_mass_ratio, linearise
from scara_drake.stability.lyapunov import lyapunov, sliding_mode
from scara_drake.stability.robustness import SETTLE, Overrides

PERIOD: Final = 1e-3  # [s]
GRAVITY: Final = 9.81  # [m/s²]
PUSHED: Final = "pushed"
SCENARIO: Final = "joint_sine"  # with the gains of Table 11
TABLE_12: Final[Overrides] = {"controller": "!IntegralSlidingMode {}"}


def tables() -> dict[str, IntegralSlidingMode]:
    """Return the gains of the paper's two tables."""
    return {name: sliding_mode(scenario) for name, scenario in _table_scenarios().items()}


def poles(tables: Mapping[str, IntegralSlidingMode], seed: int, postures: int) -> xr.Dataset:
    """Poles in random postures of the ranges, and how much of the layer gravity takes there."""
    q = np.random.default_rng(seed).uniform(joints.LOWER, joints.UPPER, (postures, 6))
    loops = [[linearise(row, controller) for row in q] for controller in tables.values()]
    found = np.linalg.eigvals([[loop.matrix for loop in row] for row in loops])
    eigenvalues = np.take_along_axis(found, np.argsort(-found.real), axis=-1)
    dims = ("table", "posture", "pole")
    share = [[loop.share for loop in row] for row in loops]
    return xr.Dataset(
        {
            "q": labelled(("posture", "joint"), q, "m for d1, rad for the others", "posture"),
            "pole_real": labelled(dims, eigenvalues.real, "1/s", "real part, slowest first"),
            "pole_imag": labelled(dims, eigenvalues.imag, "rad/s", "imaginary part"),
            "least_mass_ratio": labelled(
                ("table", "joint"),
                [least_mass_ratio(g.c, g.k, g.rho, g.phi) for g in tables.values()],
                "1",
                "least stable m_hat / M of a joint alone",
            ),
            "gravity_share": labelled(
                (*dims[:2], "joint"), share, "1", "|s| / phi that holds the robot at rest"
            ),
        },
        coords={"table": list(tables), "joint": list(joints.JOINT_NAMES)},
    )


def delays(tables: Mapping[str, IntegralSlidingMode], every: int) -> xr.Dataset:
    """Delay that each joint bears alone, at its extremes of m_hat / M, and the arm as a whole."""
    formula, exact, simulated, ratio, arm = [], [], [], [], []
    for controller in tables.values():
        gains = controller.array(PERIOD)
        g = GAINS.unpack(gains)
        low, high = mass_ratios(controller)
        b = np.array([low, np.ones(6), high])
        ratio.append(b)
        formula.append(delay_margin(g.c, g.k, g.rho, g.phi, b, PERIOD))
        cells = list(np.ndindex(b.shape))
        inverse_mass = b / g.m_hat
        exact.append([onset(inverse_mass[i, j].reshape(1, 1), gains[:, [j]]) for i, j in cells])
        simulated.append(simulated_onset(b.ravel(), np.tile(gains, 3)))
        arm.append(arm_onset(controller, PERIOD, every))
    dims, shape = ("table", "inertia", "joint"), (len(tables), 3, 6)
    return xr.Dataset(
        {
            "mass_ratio": labelled(dims, ratio, "1", "m_hat / M"),
            "delay_margin": labelled(dims, formula, "s", "phase margin / crossover - T_s / 2"),
            "delay_onset": labelled(
                dims, np.reshape(exact, shape), "s", "where the spectral radius passes 1"
            ),
            "delay_simulated": labelled(
                dims, np.reshape(simulated, shape), "s", "where a simulated joint begins to grow"
            ),
            "arm_onset": labelled(
                ("table", "grid_posture"), arm, "s", "delay that the coupled joints bear"
            ),
        },
        coords={"table": list(tables), "inertia": ["largest", "nominal", "least"]},
    )


def pushed_scenario() -> Scenario:
    """Return a run whose joints are pushed out of their layer for 0.1 s, and may return.

    With the paper's gains no drive has the effort rho m_hat, so |s| = phi is out of its reach. Here
    rho is 80 % of what it has, the slope rho / phi stays, and the push is 120 % of it, for the mast
    beyond its weight.
    """
    most = joints.EFFORT / robot.nominal_inertias()
    rho, push = 0.8 * most, 1.2 * most
    push[0] += GRAVITY
    return load_scenario(
        SCENARIO,
        {
            "controller.rho": rho.tolist(),
            "controller.phi": (rho / 150.0).tolist(),
            "perturbation.offset": push.tolist(),
            "perturbation.start": 0.5,
            "perturbation.stop": 0.6,
        },
    )


def followed(duration: float, jobs: int | None = None) -> xr.Dataset:
    """Follow Lyapunov's function, and the share of rho that the perturbation takes."""
    scenarios = {**_table_scenarios(), PUSHED: pushed_scenario()}
    recordings = side_by_side(partial(simulate, duration=duration), scenarios.values(), jobs)
    results = []
    for scenario, recording in zip(scenarios.values(), recordings, strict=True):
        found = lyapunov(recording, scenario)
        g = GAINS.unpack(sliding_mode(scenario).array())
        share = abs(found.perturbation) / xr.DataArray(g.rho, dims="joint")
        start = abs(recording.sliding_variable.isel(time=0))
        s = abs(recording.sliding_variable) / xr.DataArray(g.phi, dims="joint")
        each = {name: v for name, v in found.data_vars.items() if v.dims == ("joint",)}
        results.append(
            xr.Dataset(
                {
                    **each,
                    "V_of_layer": labelled(
                        ("time", "joint"),
                        found.V / (0.5 * xr.DataArray(g.phi, dims="joint") ** 2),
                        "1",
                        "V over phi^2 / 2, its value at the edge of the layer",
                    ),
                    "s_start": _like(start, _units(found, "largest_s"), "|s| at the start"),
                    "excursion": _like(metrics.peak(s), "1", "largest |s| / phi"),
                    "excursion_late": _like(
                        metrics.peak(s.sel(time=slice(SETTLE, None))),
                        "1",
                        "largest |s| / phi after the first second",
                    ),
                    "used": _like(metrics.peak(share), "1", "largest |D| / rho"),
                    "used_late": _like(
                        metrics.peak(share.sel(time=slice(SETTLE, None))),
                        "1",
                        "largest |D| / rho after the first second",
                    ),
                    "drive_share": labelled(
                        ("joint",),
                        joints.EFFORT / (g.m_hat * g.rho),
                        "1",
                        "effort limit of the drive / (m_hat rho)",
                    ),
                },
                coords={"time": found.time},
            )
        )
    return xr.concat(results, xr.Variable(("run",), list(scenarios)))


def _units(data: xr.Dataset, name: str) -> str:
    return str(data[name].attrs["units"])


def _like(values: xr.DataArray, units: str, long_name: str) -> xr.Variable:
    return labelled(("joint",), values.values, units, long_name)


def _table_scenarios() -> dict[str, Scenario]:
    return {
        "Table 11": load_scenario(SCENARIO),
        "Table 12": load_scenario(SCENARIO, dict(TABLE_12)),
    }
