"""When the operator's side stops: the part of a scenario, and what its supervisor remembers."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Final, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.fields import ABOVE_ZERO, choice, number
from scara_drake.common.layout import Cell, Layout
from scara_drake.safety import Reason
from scara_drake.vectors import device_status_of

Array = NDArray[np.float64]

AFTERWARDS: Final = ("engage", "resume")
BACKWARDS = -1e-3  # [s]; an age below it is of a clock that ran backwards

# Kernels read numbers: an enumeration in one would be compiled anew in every process.
NONE, SPIKE = float(Reason.NONE), float(Reason.SPIKE)
CLOCK_JUMP, OVERRUN = float(Reason.CLOCK_JUMP), float(Reason.OVERRUN)


@dataclass
class OperatorSupervision:
    """When the operator's side stops, and how it goes on.

    Attributes:
        dead_man: the arm follows only while the engage button is held; if not, a press of it
            engages and another one stops.
        after_outage: what ends a hold after the link or the device was silent: "engage", a new
            press of the button; "resume", that it is still held. Either way the arm goes on from
            where it is. A device that was unplugged always has to be engaged.
        stale_after: silence of the device from which on it counts as lost.
        bad_samples: in a row that are no numbers or out of range, for a fault.
        spike: of the stick's travel: from which size on a spike that is left out is told.
        report_after: silence of the robot from which on it counts as lost.
        clock_jump: of the lateness from a tick to the next one, from which on it is told.
        late: behind the clock, and
        late_for: for so long, until it is told.
        shown_for: how long a warning that is over stays on the port.
    """

    dead_man: bool = True
    after_outage: str = choice("engage", AFTERWARDS)
    stale_after: float = number(0.1, "s", ABOVE_ZERO, 10.0)
    bad_samples: int = number(3, "1", 1, 100)
    spike: float = number(0.25, "1", 0.0, 2.0)
    report_after: float = number(0.5, "s", ABOVE_ZERO, 60.0)
    clock_jump: float = number(0.5, "s", ABOVE_ZERO, 60.0)
    late: float = number(0.1, "s", ABOVE_ZERO, 60.0)
    late_for: float = number(1.0, "s", 0.0, 60.0)
    shown_for: float = number(0.5, "s", 0.0, 10.0)

    def parameters(self, period: float) -> Array:
        """Return the fields as `supervision_of` reads them, at a period [s]."""
        values = asdict(self)
        del values["spike"]
        resumes = values.pop("after_outage") == "resume"
        return SUPERVISION.pack(**values, resumes=resumes, period=period)


class Supervision(NamedTuple):
    """`OperatorSupervision` in a kernel; `resumes` is 1 or 0."""

    dead_man: float
    resumes: float
    stale_after: float
    bad_samples: float
    report_after: float
    clock_jump: float
    late: float
    late_for: float
    shown_for: float
    period: float


class Watch(NamedTuple):
    """Memory of the supervisor.

    Attributes:
        engage: button at the last tick.
        waits: until the buttons of a live device count [s].
        interrupted: 1 while it may resume: an outage has stopped it, and nothing else since.
        reset: button at the last tick.
        robot_state: that the robot reported last.
        robot_faults: its count.
        spikes: count of the filter.
        lateness: at the last tick [s].
        late_time: it has been behind the clock for so long [s].
        backwards_time: the device's clock has run backwards for so long [s].
        warning: a reason that is told, and
        warning_time: is told for so long yet [s].
    """

    engage: Cell
    waits: Cell
    interrupted: Cell
    reset: Cell
    robot_state: Cell
    robot_faults: Cell
    spikes: Cell
    lateness: Cell
    late_time: Cell
    backwards_time: Cell
    warning: Cell
    warning_time: Cell


SUPERVISION = Layout(Supervision)
WATCH = Layout(Watch, **dict.fromkeys(Watch._fields, ()))
supervision_of = SUPERVISION.reader()
watch_of = WATCH.reader()


def first_watch(config: OperatorSupervision, live: bool) -> Array:
    """Return the memory at the start: what a live device holds down by then is not pressed."""
    if not live:
        return WATCH.zeros()
    return WATCH.zeros(engage=1.0, reset=1.0, waits=config.stale_after)


@njit(cache=True)
def tell_warnings(spikes: float, device_status: Array, supervision: Array, watch: Array) -> None:
    """Keep the warning that is to be told, in place: what happened last, while it is fresh."""
    d, s, w = device_status_of(device_status), supervision_of(supervision), watch_of(watch)
    w.warning_time[()] = max(w.warning_time[()] - s.period, 0.0)
    if w.warning_time[()] == 0.0:
        w.warning[()] = NONE
    behind = d.lateness > s.late
    w.late_time[()] = w.late_time[()] + s.period if behind else 0.0
    backwards = d.age < BACKWARDS
    w.backwards_time[()] = w.backwards_time[()] + s.period if backwards else 0.0
    jumped = backwards or abs(d.lateness - w.lateness[()]) > s.clock_jump
    w.lateness[()] = d.lateness
    happened = NONE
    if behind and w.late_time[()] >= s.late_for:
        happened = OVERRUN
    if spikes != w.spikes[()]:
        happened = SPIKE
    if jumped:
        happened = CLOCK_JUMP
    w.spikes[()] = spikes
    if happened != NONE:
        w.warning[()], w.warning_time[()] = happened, s.shown_for
