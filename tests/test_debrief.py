"""The after-action report: one page, from any recording, without Drake."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from test_scores import cut_recording, line_task, recording_of, touch_path

from scara_drake.debrief.page import page
from scara_drake.debrief.told import MOST, events
from scara_drake.safety import MEANINGS, Reason, State
from scara_drake.tasks import TouchPoints

MARK = [0.7, -1.05, 3.0]


def whole(recording: xr.Dataset) -> xr.Dataset:
    """A recording with what a verdict reads beside: joints that follow, no channel."""
    n = recording.sizes["time"]
    joints = np.zeros((n, 6))
    names = ("q_measured", "q_desired", "v_measured", "v_desired", "tau_applied")
    more: dict[str, Any] = dict.fromkeys(names, (("time", "joint"), joints))
    more |= {"p_WE_desired": recording.p_WE_measured, "p_WE_commanded": recording.p_WE_measured}
    more |= {name: ("time", np.zeros(n)) for name in ("delay_up", "delay_down", "status")}
    joint_names = ["d1", *(f"theta{k}" for k in range(2, 7))]
    return recording.assign(more).assign_coords(joint=joint_names)


def touched(**more: Any) -> xr.Dataset:
    return whole(recording_of(TouchPoints(points=[MARK]), *touch_path([MARK]), **more))


def supervised() -> xr.Dataset:
    """Active, lost by the link, and a fault by force; the time of each is its half second."""
    n = touched().sizes["time"]
    states, reasons = np.ones(n), np.zeros(n)
    states[50:100], reasons[50:100] = State.HOLD, Reason.COMMAND_LOST
    states[150:], reasons[150:] = State.FAULT, Reason.OVER_FORCE
    return touched(robot_state=states, robot_reason=reasons)


def test_the_operator_is_told_the_words_of_the_table_at_their_times():
    told = [each for each in events(supervised()) if each.source == "robot"]
    assert [each.time for each in told] == pytest.approx([0.0, 0.5, 1.0, 1.5])
    for event, reason in zip(told[1::2], (Reason.COMMAND_LOST, Reason.OVER_FORCE), strict=True):
        assert MEANINGS[reason].says in event.said
        assert MEANINGS[reason].remedy in event.said
    assert [each.grave for each in told] == [False, False, False, True]


def test_steps_and_mistakes_of_the_task_are_events():
    said = [each.said for each in events(touched())]
    assert said == ["step 1 of the task is done", "the task is done"]
    stalls = [each for each in events(whole(cut_recording())) if "stalled" in each.said]
    assert [each.time for each in stalls] == pytest.approx([1.0, 3.0])
    assert all(each.grave for each in stalls)


def test_many_events_are_cut_short_and_it_is_said():
    n = 2000
    states = np.arange(n) % 2 * 1.0
    path, force = np.tile(MARK, (n, 1)), np.zeros(n)
    recording = recording_of(
        line_task(), path, force, operator_state=states, operator_reason=np.zeros(n)
    )
    found = events(recording)
    assert len(found) == MOST + 1
    assert found[-1].said == f"and {n - MOST} more events"


def test_the_page_holds_all_it_shows():
    text = page(supervised(), "a <run>")
    assert "a &lt;run&gt;" in text
    assert "<run>" not in text
    assert "http" not in text
    for shown in (MEANINGS[Reason.OVER_FORCE].says, "of 100", "largest force", "no saw"):
        assert shown in text
    assert text.count("<img") == 4


def test_a_run_without_a_task_or_a_supervisor_says_so():
    bare = touched().assign_attrs(scenario="name: free\ntask: null\n")
    text = page(bare, "bare")
    assert "This scenario has no task" in text
    assert "no supervisor" in text
    assert "no saw" in text


def test_the_report_is_made_without_drake(tmp_path: Path):
    touched().to_netcdf(tmp_path / "run.nc")
    program = (
        "import sys; sys.modules['pydrake'] = None\n"
        "from rich.console import Console\n"
        "import argparse, pathlib\n"
        "from scara_drake.cli.report import run\n"
        f"folder = pathlib.Path({str(tmp_path)!r})\n"
        "run(argparse.Namespace(recording=folder / 'run.nc', html=None), Console())\n"
    )
    subprocess.run([sys.executable, "-c", program], check=True, timeout=300)
    assert (tmp_path / "run.html").read_text().startswith("<!doctype html>")
