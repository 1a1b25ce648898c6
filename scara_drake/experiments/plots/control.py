"""Figures 16 to 19, 29 and 30, Table 10, and equations (31), (38) to (42), (48) to (51)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from scara_drake.experiments.control import figures_16_17, figures_29_30, table_10
from scara_drake.experiments.plots.drawing import (
    ALLOWED,
    ASKED,
    COLORS,
    SAID,
    SETTLED,
    each,
    legend,
    named,
    panels,
    ranged,
)

JOINTS: Final = ("theta2", "theta4")
PAPER_MAST: Final = figures_16_17.PAPER_ERROR.values[0]  # [mm]
# Of zeta(t) and d(t), see figures_29_30.
READINGS: Final = {
    "none": "neither",
    "A": "delays in samples, in the loop",
    "B": "a perturbation of the joint",
    "B reduced": "as far as the drive can meet it",
    "C": "delays in samples, of the command",
    "B alone": "of a joint without arm and limits",
}
LEFT: Final = 1e-4  # of a step: nearer it counts as arrived [m]


def mast(data: xr.Dataset) -> Figure:
    """Draw the mast on its polynomial, in each run (Figure 16)."""
    figure, ax = panels(1, height=3.2)
    each(ax, data.q_measured, data.time)
    ax.plot(data.time, data.q_desired.isel(run=0), **ASKED, label="desired")
    named(ax, "time [s]", "mast d1 [m]")
    return legend(figure)


def mast_error(data: xr.Dataset) -> Figure:
    """Draw the error of the mast in each run (Figure 17)."""
    figure, ax = panels(1, height=3.2)
    error = 1e3 * (data.q_desired - data.q_measured)
    each(ax, error, data.time)
    ax.axhline(PAPER_MAST, **SAID, label=f"the paper's {PAPER_MAST:g} mm")
    ranged(ax, error, [PAPER_MAST])
    named(ax, "time [s]", "mast error [mm]")
    return legend(figure)


def sines(data: xr.Dataset) -> Figure:
    """Draw joints 2 and 4 on their sines, in each run (Figure 18)."""
    figure, axes = panels(2)
    for ax, joint in zip(axes, JOINTS, strict=True):
        one = data.sel(joint=joint)
        each(ax, one.q_measured, data.time)
        ax.plot(data.time, one.q_desired.isel(run=0), **ASKED, label="desired")
        named(ax, "time [s]" if ax is axes[-1] else "", f"joint {joint[-1]} [rad]")
    return legend(figure)


def sine_errors(data: xr.Dataset) -> Figure:
    """Draw the errors of joints 2 and 4 on their sines, in each run (Figure 19)."""
    figure, axes = panels(2)
    for ax, joint in zip(axes, JOINTS, strict=True):
        one = data.sel(joint=joint)
        error = 1e3 * (one.q_desired - one.q_measured)
        each(ax, error, data.time)
        ranged(ax, error.sel(time=SETTLED))
        named(ax, "time [s]" if ax is axes[-1] else "", f"joint {joint[-1]} error [mrad]")
    return legend(figure)


def delayed(data: xr.Dataset, controllers: Sequence[str]) -> Figure:
    """Draw joint 2 and its error, a row for each reading of the delay (Figures 29 and 30).

    Args:
        data: of figures_29_30.
        controllers: those of the figure.
    """
    figure, rows = panels(len(READINGS), 2, height=1.5)
    for (left, right), (reading, meaning) in zip(rows, READINGS.items(), strict=True):
        one = data.sel(reading=reading)
        error = 1e3 * (data.q_desired - one.q_measured)
        for ax in (left, right):
            ax.axvspan(*figures_29_30.WINDOW, color="0.9", label="the paper's window")
        for place, name in enumerate(data.controller.values):
            if name in controllers:
                style = {"color": COLORS[place], "label": str(name)}
                left.plot(data.time, one.q_measured.sel(controller=name), **style)
                right.plot(data.time, error.sel(controller=name), **style)
        left.plot(data.time, data.q_desired, **ASKED, label="desired")
        ranged(left, data.q_desired)
        ranged(right, error.sel(controller=list(controllers), time=SETTLED))
        below = "time [s]" if left is rows[-1, 0] else ""
        named(left, below, "joint 2 [rad]", f"{reading}: {meaning}")
        named(right, below, "error [mrad]")
    return legend(figure)


def step_responses(data: xr.Dataset) -> Figure:
    """Draw what is left of a unit step by SMC and ISMC, under each disturbance (Table 10)."""
    names = [str(name) for name in data.disturbance.values]
    figure, axes = panels(len(names) // 2, 2, height=1.9, sharey=True)
    paper = {law: (table_10.PAPER_ISMC_RISE.values[0], table_10.PAPER_ISMC_SETTLING.values[0])
             if law == "ISMC" else table_10.PAPER_SMC.values for law in table_10.GAINS}  # fmt: skip
    for ax, name in zip(axes.ravel(), names, strict=True):
        left = abs(1.0 - data.x.sel(disturbance=name))
        each(ax, left, data.time)
        for color, (law, times) in zip(COLORS, paper.items(), strict=False):
            ax.plot(times, (0.1, table_10.BAND), "o", color=color, markerfacecolor="none",
                    markersize=9, label=f"the paper's times of {law}")  # fmt: skip
        for bound, style in ((0.1, ":"), (table_10.BAND, "--")):
            ax.axhline(bound, color="0.5", linestyle=style, linewidth=0.8,
                       label=f"{100 * bound:g} % left")  # fmt: skip
        ax.set_yscale("log")
        ax.set_ylim(LEFT, 1.5)
        named(ax, "", "", name)
    for ax in axes[:, 0]:
        ax.set_ylabel("|1 - x| [m]")
    for ax in axes[-1]:
        ax.set_xlabel("time [s]")
    return legend(figure)


def reaching(data: xr.Dataset) -> Figure:
    """Draw sigma of SMC under each disturbance, a row for each layer (equation 31)."""
    figure, axes = panels(data.sizes["phi"])
    for ax, phi in zip(axes, data.phi.values, strict=True):
        each(ax, data.sigma_smc.sel(phi=phi) / phi, data.time)
        for bound in (-1.0, 1.0):
            ax.axhline(bound, **ALLOWED, label="the layer, |sigma| = phi")
        ax.set_yscale("symlog", linthresh=1.0)
        named(ax, "time [s]" if ax is axes[-1] else "", "sigma / phi [1]", f"phi = {phi:g} m/s")
    return legend(figure)


def equivalent(data: xr.Dataset, disturbance: str = "fast sine") -> Figure:
    """Draw u1 of ISMC over the perturbation Psi, a row for each layer (equations 38 and 39)."""
    figure, axes = panels(data.sizes["phi"], sharey=True)
    one = data.sel(disturbance=disturbance)
    for ax, phi in zip(axes, data.phi.values, strict=True):
        ax.plot(data.time, one.u1.sel(phi=phi), color=COLORS[0], label="u1")
        ax.plot(data.time, one.psi.sel(phi=phi), **ASKED, label="the perturbation Psi")
        named(ax, "time [s]" if ax is axes[-1] else "", "u1, Psi [m/s²]", f"phi = {phi:g} m/s")
    return legend(figure)


def decay(data: xr.Dataset) -> Figure:
    """Draw |sigma| of ISMC over its start, a row for each layer (equations 40 to 42)."""
    figure, axes = panels(data.sizes["phi"], sharey=True)
    within = data.sel(time=slice(None, 0.3))
    for ax, phi in zip(axes, data.phi.values, strict=True):
        sigma = within.sigma.sel(phi=phi)
        each(ax, sigma / sigma.isel(time=0), within.time)
        ax.plot(within.time, np.exp(-data.attrs["k"] * within.time), **ASKED, label="exp(-k t)")
        ax.set_ylim(-0.3, 1.5)
        named(
            ax, "time [s]" if ax is axes[-1] else "", "sigma / sigma(0) [1]", f"phi = {phi:g} m/s"
        )
    return legend(figure)


def lyapunov(data: xr.Dataset) -> Figure:
    """Draw V of each joint over its value at the edge of the layer, by run (equations 48 to 51)."""
    figure, axes = panels(data.sizes["run"], sharey=True)
    for ax, run in zip(axes, data.run.values, strict=True):
        each(ax, data.V_of_layer.sel(run=run), data.time)
        ax.axhline(1.0, **ALLOWED, label="the edge of the layer")
        ax.set_yscale("log")
        ax.set_ylim(1e-8, 1e3)
        named(ax, "time [s]" if ax is axes[-1] else "", "V / (phi² / 2) [1]", str(run))
    return legend(figure)
