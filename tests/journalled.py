"""Runs that are kept in a journal."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

from scara_drake.recordings.files import load_recording
from scara_drake.recordings.journal import Journal
from scara_drake.scenario import Scenario
from scara_drake.simulation.run import Run, run_into


def journalled(
    scenario: Scenario, path: Path, engine: str = "auto", kind: type[Journal] = Journal
) -> Run:
    """Simulate a scenario into a journal, and read that."""
    with kind(path) as journal:
        ended = run_into(journal, scenario, engine=engine)
        return Run(**asdict(ended), recording=load_recording(path))
