"""What a run prints of itself at its end: its figures, then the verdict."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import xarray as xr
from rich.console import Console
from rich.table import Table

from scara_drake import metrics
from scara_drake.metrics import curves
from scara_drake.metrics.links import LINKS
from scara_drake.metrics.scores import score
from scara_drake.scenario import Scenario
from scara_drake.simulation.pacing import Timing
from scara_drake.simulation.run import Run

Row = tuple[str, str, str]
STANDS = 3.0  # of `policy_phase`: the picture


def print_summary(
    console: Console, scenario: Scenario, result: Run, verdict: metrics.Verdict
) -> None:
    """Print a table of how well a run followed its references, and what came of it."""
    recording = result.recording
    settled = curves.settled(recording)
    table = Table(title=f"{scenario.name}: {result.simulated:.1f} s", title_justify="left")
    table.add_column("after the first second")
    table.add_column("RMS", justify="right")
    table.add_column("largest", justify="right")
    for rows in (_tracking(settled), _command(settled), _contact(recording), _links(recording)):
        for row in rows:
            table.add_row(*row)
    table.add_row("real-time factor", f"{result.real_time_factor:.2f}", "")
    console.print(table)
    if result.engine_reason:
        _say(console, f"Drake ran it: {result.engine_reason}")
    if "policy_leg" in recording:
        _say(console, work_words(recording))
    if recording.attrs.get("device"):
        _say(console, f"Operator: {recording.attrs['device']}")
    print_first_posture(console, recording.attrs)
    if result.interrupted:
        console.print("Stopped early; what was simulated is recorded.")
    if result.timing is not None:
        _say(console, timing_words(result.timing))
    print_score(console, recording)
    for remark in verdict.remarks:
        _say(console, f"Note: {remark}")
    _say(console, f"Verdict: {verdict}")


def print_score(console: Console, recording: xr.Dataset) -> None:
    """Print the score of a recording's task with its criteria, if it has one."""
    found = score(recording)
    if found is None:
        return
    ended = f"done in {found.seconds:.1f} s" if found.done else f"{100.0 * found.share:.0f} % done"
    title = f"Score {found.total:.0f} of 100: {found.task}, {ended}"
    table = Table(title=title, title_justify="left")
    table.add_column("criterion")
    table.add_column("value", justify="right")
    table.add_column("points", justify="right")
    for each in found.criteria:
        value = f"{each.value:.3g} {each.unit if each.unit != '1' else ''}".strip()
        points = f"{found.share * each.points:.1f} of {each.weight:g}"
        table.add_row(each.name, value, points)
    console.print(table)


def _say(console: Console, sentence: str) -> None:
    """Print a sentence as it is: the name of a device may be anything."""
    console.print(f"{sentence}.", highlight=False, soft_wrap=True, markup=False)


def work_words(recording: xr.Dataset) -> str:
    """Say how far an operator who reacts came with his work."""
    legs, done = int(recording.policy_leg[-1]), metrics.completion_time(recording)
    moves = metrics.move_count(recording)
    if done == done:
        return f"The operator's work: done after {done:.1f} s, in {moves} moves"
    blind = " as the picture stands still" if recording.policy_phase[-1] == STANDS else ""
    return f"The operator's work: not done{blind}; {legs} of its stages, in {moves} moves"


def timing_words(timing: Timing) -> str:
    """Say how well a run kept to the clock."""
    strictly = timing.overruns == 0 and timing.restarts == 0
    parts = [
        f"{timing.late_ticks} of {timing.ticks} ticks more than 1 ms late",
        f"p99 {1e3 * timing.p99:.2f} ms, p99.9 {1e3 * timing.p999:.2f} ms, "
        f"worst {1e3 * timing.worst:.2f} ms",
    ]
    if timing.overruns:
        parts.append(f"{timing.overruns} times slower than 0.9 for a second")
    if timing.restarts:
        parts.append(f"{timing.given_up:.2f} s given up in {timing.restarts} stalls")
    if timing.pictures_dropped:
        parts.append(f"{timing.pictures_dropped} pictures of the scene gave way")
    return f"{'In' if strictly else 'Not in'} real time: {'; '.join(parts)}"


def _tracking(settled: xr.Dataset) -> Iterator[Row]:
    for curve in (*curves.JOINT_ERRORS, curves.TOOL_ERROR):
        yield from _error(curve, settled)


def _command(settled: xr.Dataset) -> Iterator[Row]:
    for curve in curves.COMMAND_ERRORS:
        yield from _error(curve, settled)
    for name, share in metrics.status_shares(settled).items():
        yield f"received command {name}", f"{100.0 * share:.1f} %", ""


def _contact(recording: xr.Dataset) -> Iterator[Row]:
    force = metrics.contact_force(recording)
    if not bool(force.notnull().any()):
        return
    yield "contact force", "", f"{float(metrics.peak(force)):.1f} N"
    if "saturation" in recording:
        share = metrics.yielding_joints(recording)
        names = [str(share.joint[i].values) for i in range(share.size) if share[i] > 0.0]
        yield "joints that yield in contact", "", ", ".join(names) or "none"


def _links(recording: xr.Dataset) -> Iterator[Row]:
    for link in LINKS:
        found = metrics.traffic(recording, link)
        if found is not None:
            yield f"packets {link}, lost of sent", f"{found.lost} of {found.sent}", ""
            if f"playout_depth_{link}" in recording:
                told = f"{found.late} late, {found.late_used} of them used"
                skipped = f"; {found.skipped} skipped" if found.skipped else ""
                depth = 1e3 * float(recording[f"playout_depth_{link}"].max())
                yield f"packets {link}, in the buffer", told + skipped, f"{depth:.0f} ms deep"
            yield f"longest gap {link}", "", f"{1e3 * found.longest_gap:.0f} ms"
            yield f"packets {link}, a second", f"{found.packets_per_second:.0f}", ""
            if not math.isnan(found.numbers):
                yield f"load {link}", f"{found.kilobits_per_second():.1f} kbit/s", ""


def _error(curve: curves.Curve, recording: xr.Dataset) -> Iterator[Row]:
    error = curve.shown(recording)
    if error is not None:
        rms, largest = float(metrics.rmse(error)), float(metrics.peak(error))
        yield curve.name, f"{rms:.3f} {curve.unit}", f"{largest:.3f} {curve.unit}"


def print_first_posture(console: Console, attributes: Mapping[str, Any]) -> None:
    """Print which method found the posture that the arm started from, if one did."""
    if "first_posture_method" in attributes:
        console.print(
            f"First posture: found by {attributes['first_posture_method']} in "
            f"{attributes['first_posture_evaluations']} evaluations, "
            f"{1e3 * attributes['first_posture_seconds']:.1f} ms."
        )
