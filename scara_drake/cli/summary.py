"""What a run prints of itself at its end."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from rich.console import Console
from rich.table import Table

from scara_drake import joints, metrics
from scara_drake.metrics.contact import yielding_joints
from scara_drake.scenario import Scenario
from scara_drake.simulation.run import Run

SETTLING: Final = 1.0  # [s], left out of the tracking figures: the drives take up the weight


def print_summary(console: Console, scenario: Scenario, result: Run) -> None:
    """Print a table of how well a run followed its references, and what came of it."""
    recording = result.recording
    settled = recording.sel(time=slice(SETTLING, None))
    if settled.sizes["time"] < 2:
        settled = recording
    error = metrics.tracking_error(settled)
    table = Table(title=f"{scenario.name}: {result.simulated:.1f} s", title_justify="left")
    table.add_column("after the first second")
    table.add_column("RMS", justify="right")
    table.add_column("largest", justify="right")
    for joint, rms, peak in zip(
        joints.JOINT_NAMES,
        metrics.rmse(error).values,
        metrics.peak(error).values,
        strict=True,
    ):
        unit = "mm" if joint == "d1" else "mrad"
        table.add_row(f"{joint} error", f"{1e3 * rms:.3f} {unit}", f"{1e3 * peak:.3f} {unit}")
    tool = metrics.tool_error(settled)
    table.add_row(
        "tool error",
        f"{1e3 * float(metrics.rmse(tool)):.3f} mm",
        f"{1e3 * float(metrics.peak(tool)):.3f} mm",
    )
    if scenario.environment.surfaces:
        force = float(metrics.peak(metrics.contact_force(recording)))
        table.add_row("contact force", "", f"{force:.1f} N")
        if "saturation" in recording:
            share = yielding_joints(recording)
            names = [str(share.joint[i].values) for i in range(share.size) if share[i] > 0.0]
            table.add_row("joints that yield in contact", "", ", ".join(names) or "none")
    table.add_row("real-time factor", f"{result.real_time_factor:.2f}", "")
    console.print(table)
    print_first_posture(console, recording.attrs)
    if result.interrupted:
        console.print("Stopped early; what was simulated is recorded.")
    if result.late:
        console.print(f"Not in real time: the clock was lost {result.late} times.")


def print_first_posture(console: Console, attributes: Mapping[str, Any]) -> None:
    """Print which method found the posture that the arm started from, if one did."""
    if "first_posture_method" in attributes:
        console.print(
            f"First posture: found by {attributes['first_posture_method']} in "
            f"{attributes['first_posture_evaluations']} evaluations, "
            f"{1e3 * attributes['first_posture_seconds']:.1f} ms."
        )
