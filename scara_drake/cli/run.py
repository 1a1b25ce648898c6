"""The command `scara-drake run`: simulate a scenario and record it."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from pydrake.geometry import Meshcat
from rich.console import Console

from scara_drake import metrics
from scara_drake.cli.kernels import compile_kernels
from scara_drake.cli.outputs import check_output
from scara_drake.cli.summary import print_summary
from scara_drake.display.camera import set_camera
from scara_drake.display.page import publish_recording, save_html, start_recording
from scara_drake.recordings.files import save_recording
from scara_drake.scenario import load_scenario, parse_overrides
from scara_drake.simulation import run as simulation


def run(options: argparse.Namespace, console: Console) -> int:
    """Simulate a scenario, draw it, write its recording and its page, and print the summary.

    Returns:
        The exit status: 0 where the arm did what it was told, 1 where not, see `metrics.verdict`.

    Raises:
        ValueError: bad input; one line.
        RuntimeError: the run failed; says where what was recorded is kept.
        OSError: a file cannot be written.
    """
    overrides = parse_overrides(options.set)
    if options.duration is not None:
        overrides["duration"] = options.duration
    scenario = load_scenario(options.scenario, overrides)
    record = options.record or Path("runs") / f"{scenario.name}.nc"
    check_output("--record", record, ".nc")
    check_output("--html", options.html, ".html")
    if options.html and options.no_meshcat:
        raise ValueError("--html: needs the scene, allowed without --no-meshcat")
    if options.html:
        options.html.parent.mkdir(parents=True, exist_ok=True)
    if not options.no_meshcat:
        compile_kernels(scenario)  # before the scene, which stays empty while it goes on
    meshcat = None if options.no_meshcat else Meshcat()
    if meshcat is not None:
        console.print(f"Scene: {meshcat.web_url()}")
        set_camera(meshcat, scenario.environment)
        if options.html:
            start_recording(meshcat)
    journal = record.with_suffix(".journal")
    rate = 0.0 if options.no_realtime else 1.0
    try:
        result = simulation.run(scenario, journal, rate, meshcat, progress=True)
    except ValueError:
        raise
    except Exception as error:
        kept = f" (what was recorded is in {journal})" if journal.exists() else ""
        raise RuntimeError(f"{error}{kept}") from error
    verdict = metrics.verdict(result.recording)
    result.recording.attrs["verdict"] = str(verdict)
    save_recording(result.recording, record)
    journal.unlink()
    print_summary(console, scenario, result, verdict)
    console.print(f"Recording: {record}")
    if meshcat is not None and options.html:
        publish_recording(meshcat)
        save_html(meshcat, options.html)
        console.print(f"Page: {options.html}")
    if meshcat is not None and sys.stdin.isatty() and sys.stdout.isatty():
        console.input("Press Enter to close the scene. ")
    return 0 if verdict.good else 1
