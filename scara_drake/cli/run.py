"""The command `scara-drake run`: simulate a scenario and record it."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from pydrake.geometry import Meshcat
from rich.console import Console

from scara_drake.cli.summary import print_summary
from scara_drake.display.camera import set_camera
from scara_drake.display.page import publish_recording, save_html, start_recording
from scara_drake.recordings.files import save_recording
from scara_drake.scenario import load_scenario, parse_overrides
from scara_drake.simulation import run as simulation
from scara_drake.stability.foresee import foresee


def run(options: argparse.Namespace, console: Console) -> None:
    """Simulate a scenario, draw it, write its recording and its page, and print the summary.

    Raises:
        ValueError: bad input; one line.
        RuntimeError: the run failed; says where what was recorded is kept.
        OSError: a file cannot be written.
    """
    scenario = load_scenario(options.scenario, parse_overrides(options.set))
    record = options.record or Path("runs") / f"{scenario.name}.nc"
    for path, suffix in ((record, ".nc"), (options.html, ".html")):
        _check_target(path, suffix)
    if options.html and options.no_meshcat:
        raise ValueError("--html: needs the scene, allowed without --no-meshcat")
    for line in foresee(scenario):
        console.print(f"Foreseen: {line}.")
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
    save_recording(result.recording, record)
    journal.unlink()
    print_summary(console, scenario, result)
    console.print(f"Recording: {record}")
    if meshcat is not None and options.html:
        publish_recording(meshcat)
        save_html(meshcat, options.html)
        console.print(f"Page: {options.html}")
    if meshcat is not None and sys.stdin.isatty() and sys.stdout.isatty():
        console.input("Press Enter to close the scene. ")


def _check_target(path: Path | None, suffix: str) -> None:
    if path is not None and (path.suffix != suffix or path.is_dir()):
        raise ValueError(f"output: '{path}', allowed a file that ends in {suffix}")
