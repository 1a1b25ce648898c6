"""The pictures of an after-action report; each says its question."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from scara_drake import plotting
from scara_drake.comparison.plots import thinned
from scara_drake.debrief.drawing import draw_path
from scara_drake.debrief.told import SIDES, is_supervised
from scara_drake.display import look
from scara_drake.metrics.task_of import task_of
from scara_drake.safety import State

WIDTH: Final = 10.0  # [in]
FORCE: Final = look.FORCE[:3]
LINES: Final = (look.FIRST, look.SECOND)
# A state's colour on the time line: green goes, grey rests, the rest are stops.
STATE_COLORS: Final = {
    State.IDLE: "#c8c8c8",
    State.ACTIVE: "#5aa469",
    State.CLUTCH: "#8fb8de",
    State.HOLD: "#e9c46a",
    State.FAULT: "#d1495b",
    State.ESTOP: "#7b1e3a",
}


def pictures(recording: xr.Dataset) -> Iterator[tuple[str, Figure | str]]:
    """Yield each question with its picture, or with why there is none."""
    for title, missing, draw in PICTURES:
        reason = missing(recording)
        yield title, reason or draw(recording)


def _axes(rows: int, height: float, columns: int = 1) -> tuple[Figure, list[Axes]]:
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    return figure, list(np.ravel(figure.subplots(rows, columns)))


def _line(ax: Axes, values: xr.DataArray, **style: Any) -> None:
    x, y = thinned(values.time.values, values.values)
    ax.plot(x, y, linewidth=1.1, **style)


def _path(recording: xr.Dataset) -> Figure:
    figure, (top, side) = _axes(1, 4.6, 2)
    draw_path(recording, top, 0, 1)
    top.set_title("from above", fontsize=10)
    draw_path(recording, side, 1, 2)
    side.set_title("from the side", fontsize=10)
    return figure


def _force(recording: xr.Dataset) -> Figure:
    figure, (ax,) = _axes(1, 2.8)
    size = (recording.f_env_on_tool_W**2).sum("axis", skipna=False) ** 0.5
    _line(ax, size, color=FORCE, label="on the tool")
    task: Any = task_of(recording)
    if task is not None:
        if hasattr(task, "force"):
            low, high = task.force - task.force_tolerance, task.force + task.force_tolerance
            ax.axhspan(low, high, color=look.LAW, alpha=0.15, label="as it was set")
        if float(size.max()) > 0.3 * task.most_force:
            ax.axhline(task.most_force, color=look.LIMIT, linestyle="--", label="most allowed")
    plotting.finish(ax, "time [s]", "force [N]")
    return figure


def _states(recording: xr.Dataset) -> Figure:
    sides = [side for side in SIDES if f"{side}_state" in recording]
    figure, (ax,) = _axes(1, 0.9 + 0.5 * len(sides))
    t, seen = recording.time.values, set()
    for row, side in enumerate(sides):
        states = recording[f"{side}_state"].values
        edges = [0, *(np.flatnonzero(np.diff(states)) + 1), states.size]
        for begin, end in pairwise(edges):
            state = State(int(states[begin]))
            until = t[min(end, t.size - 1)]
            label = "" if state in seen else state.name.lower()
            seen.add(state)
            ax.barh(
                row, until - t[begin], left=t[begin], height=0.6, color=STATE_COLORS[state],
                label=label,
            )  # fmt: skip
    ax.set_yticks(range(len(sides)), sides)
    ax.set_xlim(t[0], t[-1])
    ax.set_xlabel("time [s]")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, 1.6), ncols=6, fontsize="small")
    return figure


def _blade(recording: xr.Dataset) -> Figure:
    figure, (speed, left) = _axes(1, 2.6, 2)
    _line(speed, recording.blade_speed, color=LINES[0], label="rim of the blade")
    plotting.finish(speed, "time [s]", "speed [m/s]")
    _line(left, 100.0 * recording.cut_left, color=LINES[1], label="of the section")
    plotting.finish(left, "time [s]", "left [%]")
    return figure


def _delays(recording: xr.Dataset) -> Figure:
    figure, (ax,) = _axes(1, 2.4)
    for name, color in zip(("up", "down"), LINES, strict=True):
        chosen = f"age_{name}" if f"age_{name}" in recording else f"delay_{name}"
        if recording[chosen].notnull().any():
            _line(ax, 1e3 * recording[chosen], color=color, label=f"{chosen.replace('_', ' ')}")
    ax.set_ylim(bottom=0.0)
    plotting.finish(ax, "time [s]", "[ms]")
    return figure


def _has(*names: str) -> Callable[[xr.Dataset], str]:
    def missing(recording: xr.Dataset) -> str:
        there = [name in recording and recording[name].notnull().any() for name in names]
        return "" if any(there) else f"The recording has no {' and no '.join(names)}."

    return missing


def _unsupervised(recording: xr.Dataset) -> str:
    return "" if is_supervised(recording) else "This run had no supervisor."


def _no_saw(recording: xr.Dataset) -> str:
    return "" if "blade_speed" in recording else "This run had no saw."


PICTURES: Final[tuple[tuple[str, Callable[[Any], str], Callable[[Any], Figure]], ...]] = (
    ("Where did the tool go?", _has("p_WE_measured"), _path),
    ("How hard did it press?", _has("f_env_on_tool_W"), _force),
    ("How did the saw run?", _no_saw, _blade),
    ("What did the supervisors let through?", _unsupervised, _states),
    ("How late was it?", _has("delay_up", "delay_down"), _delays),
)
