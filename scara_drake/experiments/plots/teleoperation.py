"""Figures 20 to 28: the joystick's motion, and what the operator feels."""

from __future__ import annotations

from typing import Final

import xarray as xr
from matplotlib.figure import Figure

from scara_drake.experiments.plots.drawing import (
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
from scara_drake.experiments.teleoperation import figures_20_27
from scara_drake.experiments.teleoperation.delay_readings import DELAYS
from scara_drake.plotting import COMMANDED, FIRST, FORCE, MEASURED, SECOND

PLAIN: Final = "normalised"
RAW: Final = "raw stick"
PAPER_MAST: Final = figures_20_27.PAPER_MAST.values[0]  # [mm]


def tool_way(data: xr.Dataset) -> Figure:
    """Draw the way of the tool from above (Figure 20)."""
    figure, ax = panels(1, height=4.5)
    one = data.sel(run=PLAIN)
    for name, style in (
        ("commanded", {"color": COMMANDED, "linewidth": 3.0}),
        ("reference", ASKED),
        ("measured", {"color": MEASURED}),
    ):
        p = one[f"p_WE_{name}"]
        ax.plot(p.sel(axis="x"), p.sel(axis="y"), **style, label=name)
    ax.set_aspect("equal", adjustable="datalim")
    named(ax, "x [m]", "y [m]")
    return legend(figure)


def tool_error(data: xr.Dataset) -> Figure:
    """Draw the distance of the tool from its command, and what each cause adds (Figure 21)."""
    figure, axes = panels(2, height=2.3)
    parts = 1e3 * data.tool_error.sel(run=PLAIN)
    before, behind = ("channel", "command limiter"), ("controller", "inverse kinematics")
    axes[0].plot(data.time, _length(parts.sum("part")), color=MEASURED, label="in all")
    for ax, names, colors in zip(axes, (before, behind), (COLORS[1:], COLORS[3:]), strict=True):
        for color, name in zip(colors, names, strict=False):
            ax.plot(data.time, _length(parts.sel(part=name)), color=color, label=name)
    named(axes[0], "", "tool error [mm]", "before the references of the joints")
    named(axes[1], "time [s]", "tool error [mm]", "from there on")
    return legend(figure)


def answers(data: xr.Dataset) -> Figure:
    """Draw joint 2 as the methods answer, and as the arm follows them in the loop (Figure 22)."""
    figure, (above, below) = panels(2, height=2.5)
    styles = {"DPSO": {"color": SECOND}, "DPSOIJ": {"color": FIRST}}
    one = data.sel(joint="theta2")
    for name, style in styles.items():
        above.plot(data.answer_time, one.answer.sel(solver=name), **style, label=name)
        below.plot(data.time, one.q_measured.sel(solver=name), **style, label=name)
    named(above, "", "joint 2 [rad]", "answers of the inverse kinematics")
    named(below, "time [s]", "joint 2 [rad]", "the arm in the loop")
    return legend(figure)


def joint(data: xr.Dataset, name: str) -> Figure:
    """Draw a joint over its reference (Figures 23 and 25).

    Args:
        data: of figures_20_27.
        name: "theta2" or "theta4".
    """
    figure, ax = panels(1, height=3.2)
    one = data.sel(run=PLAIN, joint=name)
    ax.plot(data.time, one.q_measured, color=MEASURED, label="measured")
    ax.plot(data.time, one.q_desired, **ASKED, label="desired")
    named(ax, "time [s]", f"joint {name[-1]} [rad]")
    return legend(figure)


def actual_and_expected(data: xr.Dataset) -> Figure:
    """Draw the error of joint 2, with and without what comes before its reference (Figure 24).

    What the received command asks for is the reference that the limiter has led to one lag later.
    """
    figure, (above, below) = panels(2)
    one = data.sel(run=PLAIN, joint="theta2")
    ahead = one.q_desired.interp(time=one.time + data.attrs["limiter_lag"])
    actual = 1e3 * (ahead.assign_coords(time=one.time) - one.q_measured).dropna("time")
    expected = 1e3 * (one.q_desired - one.q_measured)
    above.plot(actual.time, actual, color=FIRST, label="actual, of the received command")
    for ax in (above, below):
        ax.plot(data.time, expected, color=FORCE, label="expected, of the control alone")
    ranged(below, expected.sel(time=SETTLED))
    named(above, "", "joint 2 error [mrad]")
    named(below, "time [s]", "joint 2 error [mrad]", "the control alone")
    return legend(figure)


def stick_errors(data: xr.Dataset) -> Figure:
    """Draw the error of joint 4, with the stick smoothed and taken as it is (Figure 26)."""
    figure, ax = panels(1, height=3.2)
    one = data.sel(joint="theta4")
    error = 1e3 * (one.q_desired - one.q_measured)
    for name, color, label in (
        (RAW, SECOND, "stick as it is"),
        (PLAIN, MEASURED, "stick smoothed"),
    ):
        ax.plot(data.time, error.sel(run=name), color=color, label=label)
    ranged(ax, error.sel(run=[PLAIN, RAW], time=SETTLED))
    named(ax, "time [s]", "joint 4 error [mrad]")
    return legend(figure)


def mast_error(data: xr.Dataset) -> Figure:
    """Draw the error of the mast, by the normalised law and in mm and N (Figure 27)."""
    figure, ax = panels(1, height=3.2)
    error = 1e3 * (data.q_desired - data.q_measured).sel(joint="d1")
    shown = error.sel(run=[PLAIN, "mast in mm and N"])
    each(ax, shown, data.time)
    ax.axhline(PAPER_MAST, **SAID, label=f"the paper's {PAPER_MAST:g} mm")
    ranged(ax, shown.sel(time=SETTLED), [PAPER_MAST])
    named(ax, "time [s]", "mast error [mm]")
    return legend(figure)


def haptic(data: xr.Dataset) -> Figure:
    """Draw the force that the operator feels with and without delay, by reading (Figure 28)."""
    figure, axes = panels(len(DELAYS) + 1, height=1.6)
    without = data.force_felt.sel(channel="none")
    for color, ax, (name, reading) in zip(COLORS[1:], axes, DELAYS.items(), strict=False):
        ax.plot(data.time, data.force_felt.sel(channel=name), color=FORCE, label="with delay")
        ax.plot(data.time, without, color=FIRST, linestyle=":", label="without delay")
        axes[-1].plot(data.time, data.delay.sel(channel=name), color=color, label=reading.name)
        named(ax, "", "force felt [N]", f"{reading.name}: {reading.meaning}")
    named(axes[-1], "time [s]", "delay [s]")
    touched = data.time[(data.force_felt.max("channel") > 0.0).values]
    if touched.size:
        axes[-1].set_xlim(float(touched[0]) - 0.5, float(touched[-1]) + 0.5)
    return legend(figure)


def _length(vectors: xr.DataArray) -> xr.DataArray:
    return (vectors**2).sum("axis") ** 0.5
