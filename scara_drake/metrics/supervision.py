"""What the supervisors of a run did: how long they were in which state, and why they stopped."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
import xarray as xr

from scara_drake.safety import Reason, State, words

SIDES: Final = ("operator", "robot")
STOPS: Final = (State.HOLD, State.FAULT, State.ESTOP)
# Holds that nobody wanted.
LOST: Final = (
    Reason.DEVICE_LOST,
    Reason.DEVICE_STALE,
    Reason.REPORT_LOST,
    Reason.COMMAND_LOST,
)


@dataclass(frozen=True)
class Stop:
    """A time for which a supervisor stood, for one reason.

    Attributes:
        side: "operator" or "robot".
        start: [s].
        end: [s], of the last sample.
        says: state and reason in words.
        state: it stood in.
        reason: why.
        open: whether it lasts to the end of the recording.
    """

    side: str
    start: float
    end: float
    says: str
    state: State
    reason: Reason
    open: bool

    def __str__(self) -> str:
        until = "to the end" if self.open else f"to {self.end:.2f} s"
        return f"{self.side} {self.says}, from {self.start:.2f} s {until}"


def is_supervised(recording: xr.Dataset, side: str = "robot") -> bool:
    """Whether a side of the run had a supervisor."""
    return f"{side}_state" in recording


def state_shares(recording: xr.Dataset, side: str = "robot") -> dict[str, float]:
    """Share of the time in each state of `safety.State`, by name; empty without a supervisor."""
    if not is_supervised(recording, side):
        return {}
    states = recording[f"{side}_state"].values
    return {state.name.lower(): float(np.mean(states == state)) for state in State}


def stops(recording: xr.Dataset, side: str = "robot") -> list[Stop]:
    """Return the times for which a supervisor stood, in order; empty without one."""
    if not is_supervised(recording, side):
        return []
    times = recording.time.values
    codes = np.stack([recording[f"{side}_state"].values, recording[f"{side}_reason"].values], 1)
    edges = np.flatnonzero((np.diff(codes, axis=0) != 0.0).any(axis=1)) + 1
    bounds = [0, *edges.tolist(), len(times)]
    return [
        Stop(
            side,
            float(times[first]),
            float(times[past - 1]),
            words(*codes[first]),
            State(int(codes[first, 0])),
            Reason(int(codes[first, 1])),
            past == len(times),
        )
        for first, past in pairwise(bounds)
        if State(int(codes[first, 0])) in STOPS
    ]


def not_followed(recording: xr.Dataset) -> Iterator[str]:
    """Yield a sentence for each side that ended in a state that the operator has to mend."""
    for side in SIDES:
        for stop in stops(recording, side)[-1:]:
            if stop.open and (stop.state != State.HOLD or stop.reason in LOST):
                yield f"ended in {stop}"


def stops_told(recording: xr.Dataset, most: int = 8) -> Iterator[str]:
    """Yield what each side stood for, and for how long it was engaged."""
    for side in SIDES:
        shares = {name: share for name, share in state_shares(recording, side).items() if share > 0}
        if shares:
            parts = ", ".join(f"{100.0 * share:.1f} % {name}" for name, share in shares.items())
            yield f"the {side}'s side was {parts.replace('estop', 'e-stop')}"
        found = stops(recording, side)
        yield from (str(stop) for stop in found[:most])
        if len(found) > most:
            yield f"{side} stopped {len(found) - most} times more"
