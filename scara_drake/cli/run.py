"""The command `scara-drake run`: simulate a scenario and record it."""

from __future__ import annotations

import argparse
import sys

from pydrake.geometry import Meshcat
from rich.console import Console

from scara_drake.cli.outputs import check_output
from scara_drake.cli.recorded import (
    end_by_signal,
    recording_to,
    run_and_tell,
    status_of,
    what_to_run,
)
from scara_drake.display.camera import set_camera
from scara_drake.display.page import publish_recording, save_html, start_recording
from scara_drake.display.server import start_meshcat, who_reaches
from scara_drake.scenario import Scenario
from scara_drake.simulation.kernels import compile_kernels
from scara_drake.simulation.run import Live, check_engine


def run(options: argparse.Namespace, console: Console) -> int:
    """Simulate a scenario, draw it, write its recording and its page, and print the summary.

    Returns:
        The exit status, see `recorded.status_of`.

    Raises:
        ValueError: bad input; one line.
        RuntimeError: the run failed; says where what was recorded is kept.
        OSError: a file cannot be written.
    """
    scenario, record = what_to_run(options)
    _check_options(options)
    if options.html:
        options.html.parent.mkdir(parents=True, exist_ok=True)
    with recording_to(record, scenario, console) as (journal, signals):
        live = Live(
            0.0 if options.no_realtime else 1.0,
            options.realtime_priority,
            None if options.no_meshcat else _open_scene(options, scenario, console),
        )
        verdict = run_and_tell(console, scenario, live, record, journal, signals, options.engine)
        if live.meshcat is not None and options.html:
            publish_recording(live.meshcat)
            save_html(live.meshcat, options.html)
            console.print(f"Page: {options.html}")
    end_by_signal(signals)
    if live.meshcat is not None and sys.stdin.isatty() and sys.stdout.isatty():
        console.input("Press Enter to close the scene. ")
    return status_of(verdict)


def _check_options(options: argparse.Namespace) -> None:
    """Check what does not go together, and where the page is to be written.

    Raises:
        ValueError: names the option and what is allowed.
    """
    check_output("--html", options.html, ".html")
    check_engine(options.engine, not (options.no_meshcat and options.no_realtime))
    if options.realtime_priority and options.no_realtime:
        raise ValueError("--realtime-priority: for real time, allowed without --no-realtime")
    if options.html and options.no_meshcat:
        raise ValueError("--html: needs the scene, allowed without --no-meshcat")


def _open_scene(options: argparse.Namespace, scenario: Scenario, console: Console) -> Meshcat:
    """Compile the kernels, which would leave the scene empty, then open it and say where it is."""
    compile_kernels(scenario)
    meshcat = start_meshcat(options.host, options.port)
    console.print(f"Scene: {meshcat.web_url()} ({who_reaches(options.host)})")
    set_camera(meshcat, scenario.environment)
    if options.html:
        start_recording(meshcat)
    return meshcat
