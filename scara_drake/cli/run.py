"""The command `scara-drake run`: simulate a scenario and record it."""

from __future__ import annotations

import argparse
import glob
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import asdict
from pathlib import Path

from pydrake.geometry import Meshcat
from rich.console import Console

from scara_drake import metrics
from scara_drake.cli.kernels import compile_kernels
from scara_drake.cli.outputs import check_output
from scara_drake.cli.summary import print_summary
from scara_drake.display.camera import set_camera
from scara_drake.display.page import publish_recording, save_html, start_recording
from scara_drake.display.server import start_meshcat, who_reaches
from scara_drake.recordings.files import open_recording, save_journal
from scara_drake.recordings.journal import Journal
from scara_drake.scenario import Scenario, load_scenario, parse_overrides
from scara_drake.simulation.interrupt import ENDING, DeferredInterrupt
from scara_drake.simulation.run import Run, check_engine, run_into
from scara_drake.stability.foresee import foresee


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
    _check_options(options, record)
    if options.html:
        options.html.parent.mkdir(parents=True, exist_ok=True)
    with (
        Journal(record.with_suffix(".journal")) as journal,
        DeferredInterrupt(*ENDING) as signals,
    ):
        _say_what_is_there(record, journal)
        for line in foresee(scenario):
            console.print(f"Foreseen: {line}.", highlight=False, soft_wrap=True)
        meshcat = None if options.no_meshcat else _open_scene(options, scenario, console)
        rate = 0.0 if options.no_realtime else 1.0
        with _notes_told():
            ended = run_into(
                journal,
                scenario,
                rate,
                meshcat,
                True,
                signals,
                options.engine,
                options.realtime_priority,
            )
            _keep(journal, record)
        with open_recording(record) as recording:
            verdict = metrics.verdict(recording)
            with suppress(OSError) if signals.pressed else nullcontext():  # a closed terminal
                result = Run(**asdict(ended), recording=recording)
                print_summary(console, scenario, result, verdict)
                console.print(f"Recording: {record}")
        if meshcat is not None and options.html:
            publish_recording(meshcat)
            save_html(meshcat, options.html)
            console.print(f"Page: {options.html}")
    if signals.signal not in (None, signal.SIGINT):
        raise SystemExit(128 + signals.signal)
    if meshcat is not None and sys.stdin.isatty() and sys.stdout.isatty():
        console.input("Press Enter to close the scene. ")
    return 0 if verdict.good else 1


def _check_options(options: argparse.Namespace, record: Path) -> None:
    """Check what does not go together, and where files are to be written.

    Raises:
        ValueError: names the option and what is allowed.
    """
    check_output("--record", record, ".nc")
    check_output("--html", options.html, ".html")
    check_engine(options.engine, not (options.no_meshcat and options.no_realtime))
    if options.realtime_priority and options.no_realtime:
        raise ValueError("--realtime-priority: for real time, allowed without --no-realtime")
    if options.html and options.no_meshcat:
        raise ValueError("--html: needs the scene, allowed without --no-meshcat")


@contextmanager
def _notes_told() -> Iterator[None]:
    """Let the one line of an error say what its notes say: where what was recorded is kept."""
    try:
        yield
    except BaseException as error:
        kept = getattr(error, "__notes__", [])
        if kept and isinstance(error, Exception):
            raise RuntimeError("; ".join([str(error), *kept])) from error
        _say(*kept)
        raise


def _open_scene(options: argparse.Namespace, scenario: Scenario, console: Console) -> Meshcat:
    """Compile the kernels, which would leave the scene empty, then open it and say where it is."""
    compile_kernels(scenario)
    meshcat = start_meshcat(options.host, options.port)
    console.print(f"Scene: {meshcat.web_url()} ({who_reaches(options.host)})")
    set_camera(meshcat, scenario.environment)
    if options.html:
        start_recording(meshcat)
    return meshcat


def _keep(journal: Journal, record: Path) -> None:
    """Make the recording of a journal, and remove it; if that fails the error names it.

    Raises:
        OSError: the recording cannot be written; the journal is kept.
    """
    try:
        save_journal(journal.path, record)
    except BaseException as error:
        error.add_note(f"what was recorded is in {journal.path}")
        raise
    journal.remove()


def _say_what_is_there(record: Path, journal: Journal) -> None:
    """Say which recording will be written over, and which journals earlier runs have left."""
    if record.exists():
        _say(f"Overwrites: {record}")
    for left in sorted(record.parent.glob(f"{glob.escape(record.stem)}.*.journal")):
        _say(
            f"Left by a run that was cut off: {left} (scara-drake recover makes a recording of it)"
        )


def _say(*lines: str) -> None:
    for line in lines:
        Console(stderr=True, soft_wrap=True, highlight=False).print(line, markup=False)
