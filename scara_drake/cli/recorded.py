"""What the commands that simulate have in common: their scenario, recording, summary and end."""

from __future__ import annotations

import argparse
import glob
import signal
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import asdict
from pathlib import Path
from typing import Final

from rich.console import Console

from scara_drake import metrics
from scara_drake.cli.outputs import check_output
from scara_drake.cli.summary import print_summary
from scara_drake.metrics.scores import score_attributes
from scara_drake.recordings.black_box import BlackBox
from scara_drake.recordings.files import open_recording, save_journal
from scara_drake.recordings.journal import Journal
from scara_drake.recordings.samples import Keeper
from scara_drake.scenario import Scenario, load_scenario, parse_overrides
from scara_drake.simulation.advance import Ended
from scara_drake.simulation.interrupt import ENDING, DeferredInterrupt
from scara_drake.simulation.run import Live, Run, run_into, with_black_box
from scara_drake.simulation.steppers import AUTO
from scara_drake.stability.foresee import foresee

FAILED_RUN: Final = 1
ARM_LOST: Final = 3


def what_to_run(options: argparse.Namespace) -> tuple[Scenario, Path]:
    """Return the scenario that the options name, and where its recording goes.

    Raises:
        ValueError: there is none, or it cannot be written there.
    """
    overrides = parse_overrides(options.set)
    if options.duration is not None:
        overrides["duration"] = options.duration
    scenario = load_scenario(options.scenario, overrides)
    record = options.record or Path("runs") / f"{scenario.name}.nc"
    check_output("--record", record, ".nc")
    return scenario, record


@contextmanager
def recording_to(
    record: Path, scenario: Scenario, console: Console
) -> Iterator[tuple[Journal, DeferredInterrupt]]:
    """Open the journal of a recording, and listen to what ends a run; say what is foreseen."""
    with (
        Journal(record.with_suffix(".journal")) as journal,
        DeferredInterrupt(*ENDING) as signals,
    ):
        _say_what_is_there(record, journal)
        for line in foresee(scenario):
            console.print(f"Foreseen: {line}.", highlight=False, soft_wrap=True)
        yield journal, signals


def run_and_tell(
    console: Console,
    scenario: Scenario,
    live: Live,
    record: Path,
    journal: Journal,
    signals: DeferredInterrupt,
    engine: str = AUTO,
) -> metrics.Verdict:
    """Simulate into a journal, make the recording of it, print the summary, return the verdict.

    Raises:
        ValueError, RuntimeError: as `run_into`; the line says where what was recorded is kept.
        OSError: a file cannot be written.
    """
    with notes_told():
        box = with_black_box(journal, scenario)
        ended = run_into(box, scenario, live, True, signals, engine)
        keep(journal, record)
    verdict = tell(console, scenario, ended, record, signals)
    tell_faults(console, box, record)
    return verdict


def tell(
    console: Console, scenario: Scenario, ended: Ended, record: Path, signals: DeferredInterrupt
) -> metrics.Verdict:
    """Print the summary of a recording, and return its verdict."""
    with open_recording(record) as recording:
        verdict = metrics.verdict(recording)
        with suppress(OSError) if signals.pressed else nullcontext():  # a closed terminal
            result = Run(**asdict(ended), recording=recording)
            print_summary(console, scenario, result, verdict)
            console.print(f"Recording: {record}")
    return verdict


def tell_faults(console: Console, keeper: Keeper, record: Path) -> None:
    """Write the seconds before each fault of a supervised run, and say where.

    Raises:
        OSError: a file cannot be written.
    """
    if not isinstance(keeper, BlackBox):
        return
    for path in keeper.write(record):
        console.print(f"Before a fault: {path}")
    if keeper.missed:
        console.print(f"{keeper.missed} faults more, of which only the recording tells.")


def status_of(verdict: metrics.Verdict) -> int:
    """Return the exit status: 0 where the arm did what it was told, 3 where it was lost, else 1.

    Lost is also an arm that ended in a fault or an emergency stop, or without its command.
    """
    if verdict.good:
        return 0
    return ARM_LOST if verdict.lost else FAILED_RUN


def end_by_signal(signals: DeferredInterrupt) -> None:
    """End the program as a signal asks that is no Ctrl-C.

    Raises:
        SystemExit: there was one.
    """
    if signals.signal not in (None, signal.SIGINT):
        raise SystemExit(128 + signals.signal)


@contextmanager
def notes_told() -> Iterator[None]:
    """Let the one line of an error say what its notes say: where what was recorded is kept."""
    try:
        yield
    except BaseException as error:
        kept = getattr(error, "__notes__", [])
        if kept and isinstance(error, Exception):
            raise RuntimeError("; ".join([str(error), *kept])) from error
        _say(*kept)
        raise


def keep(journal: Journal, record: Path) -> None:
    """Make the recording of a journal, and remove it; if that fails the error names it.

    Raises:
        OSError: the recording cannot be written; the journal is kept.
    """
    try:
        save_journal(journal.path, record, score_attributes)
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
