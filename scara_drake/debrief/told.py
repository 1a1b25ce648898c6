"""What happened in a run and what the operator was told, each with its time, in words."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
import xarray as xr

from scara_drake.metrics.scores import collisions, merged, score
from scara_drake.metrics.stretches import stretches
from scara_drake.metrics.task_of import task_of
from scara_drake.safety import MEANINGS, Reason, Severity, words

SIDES: Final = ("operator", "robot")
MOST: Final = 200  # of the rows of a page


class Event(NamedTuple):
    """Something that happened.

    Attributes:
        time: [s].
        source: whose word it is: "operator", "robot", "device", "task".
        said: a sentence without a full stop.
        grave: whether it is a fault or a mistake.
    """

    time: float
    source: str
    said: str
    grave: bool


def events(recording: xr.Dataset) -> list[Event]:
    """Return the events of a recording, in order of time; at most `MOST` and one that says so."""
    found = [
        *(event for side in SIDES for event in _supervisor(recording, side)),
        *_device(recording),
        *_task(recording),
    ]
    found.sort(key=lambda event: event.time)
    left = len(found) - MOST
    if left > 0:
        last = found[MOST - 1].time
        found = [*found[:MOST], Event(last, "task", f"and {left} more events", False)]
    return found


def is_supervised(recording: xr.Dataset) -> bool:
    """Whether a recording has the states of a supervisor."""
    return any(f"{side}_state" in recording for side in SIDES)


def _supervisor(recording: xr.Dataset, side: str) -> list[Event]:
    if f"{side}_state" not in recording:
        return []
    states, reasons = recording[f"{side}_state"].values, recording[f"{side}_reason"].values
    known = np.isfinite(states) & np.isfinite(reasons)
    pairs = np.stack([states, reasons], axis=1)
    changed = np.any(np.diff(pairs, axis=0) != 0.0, axis=1)
    at = [0, *(np.flatnonzero(changed) + 1)]
    return [_said(recording, side, k, states[k], reasons[k]) for k in at if known[k]]


def _said(recording: xr.Dataset, side: str, k: int, state: float, reason: float) -> Event:
    meaning = MEANINGS[Reason(int(reason))]
    remedy = f" ({meaning.remedy})" if meaning.remedy else ""
    grave = meaning.severity in (Severity.FAULT, Severity.ESTOP)
    return Event(float(recording.time[k]), side, f"{words(state, reason)}{remedy}", grave)


def _device(recording: xr.Dataset) -> list[Event]:
    if "device_connected" not in recording:
        return []
    lost = stretches(recording.time.values, recording.device_connected.values < 1.0)
    gone = [Event(each.start, "device", "the operator's device is gone", True) for each in lost]
    back = [Event(each.end, "device", "it is back", False) for each in lost if not each.open]
    return [*gone, *back]


def _task(recording: xr.Dataset) -> list[Event]:
    task, found = task_of(recording), score(recording)
    if task is None or found is None:
        return []
    start = float(recording.time[0])
    made = [
        Event(start + mark, "task", f"step {number} of the task is done", False)
        for number, mark in enumerate(found.marks, 1)
    ]
    if found.done:
        made.append(Event(start + found.seconds, "task", "the task is done", False))
    for each in collisions(recording, task):
        made.append(Event(each.start, "task", f"collision, for {each.length:.2f} s", True))
    if "blade_stalled" in recording:
        for each in merged(recording, recording.blade_stalled.values > 0.5):
            made.append(Event(each.start, "task", f"blade stalled, for {each.length:.2f} s", True))
    return made
