"""The last seconds before each fault, at the full rate, whatever the rate of the recording."""

from __future__ import annotations

import json
from collections import deque
from contextlib import suppress
from pathlib import Path
from threading import Thread
from typing import Any, Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from scara_drake.recordings.dataset import Notes, to_dataset
from scara_drake.recordings.files import save_journal, save_recording
from scara_drake.recordings.journal import Journal
from scara_drake.recordings.samples import Keeper
from scara_drake.safety import words
from scara_drake.vectors import SUPERVISOR_STATUS

Array = NDArray[np.float64]

LENGTH: Final = 10.0  # [s], that are kept before a fault
MOST: Final = 5  # faults of which they are kept
APART: Final = 1.0  # [s]; what follows sooner belongs to the same fault
MOST_TOLD: Final = 100  # of which the recording tells
A_FAULT: Final = "a fault"
SIDES: Final = ("operator_status", "robot_status")


class BlackBox:
    """Keeps every sample of the last seconds before a fault, and passes on those of a recording.

    It stands between a run and what keeps its samples, and has no influence on either. A fault is
    whatever a supervisor counts as one: a hold by itself, a fault, an emergency stop. Where the
    keeper has a file NAME.journal each box is written at once to NAME.fault-1.journal and so on, so
    that a process that dies after it leaves it. The attribute `faults` of the recording tells them.

    Args:
        keeper: of the recording.
        period: of the recording [s]; the samples come at every tick.

    Attributes:
        missed: faults beyond the first `MOST`.
    """

    def __init__(self, keeper: Keeper, period: float) -> None:
        self._keeper, self._period = keeper, period
        self._start({})

    @property
    def has_samples(self) -> bool:
        """Whether there are any."""
        return self._keeper.has_samples

    @property
    def path(self) -> Path | None:
        """The file where they are; None for none."""
        return self._keeper.path

    @property
    def boxes(self) -> list[xr.Dataset]:
        """The recordings of the last seconds before each fault, in order; those in memory."""
        return [self._dataset(at, blocks) for at, blocks in self._boxes if blocks]

    def write(self, record: Path) -> list[Path]:
        """Write the boxes beside a recording NAME.nc: NAME.fault-1.nc and so on; return the files.

        Their journals are removed.

        Raises:
            OSError: one cannot be written.
        """
        paths = []
        for number, (at, blocks) in enumerate(self._boxes, 1):
            paths.append(record.with_name(f"{record.stem}.fault-{number}.nc"))
            if blocks:
                save_recording(self._dataset(at, blocks), paths[-1])
            else:
                save_journal(self._journals[number - 1], paths[-1])
        for journal in self._journals:
            journal.unlink(missing_ok=True)
        return paths

    def begin(self, description: dict[str, Any], width: int) -> None:
        """Keep what the run says of itself; samples have `width` values."""
        self._start(description)
        self._width = width
        self._keeper.begin(description, width)

    def append(self, times: Array, values: Array) -> None:
        """Keep samples at times (n,) with values (n, width), which nobody changes any more."""
        if not times.size:
            return
        self._last.append((times, values))
        while self._last[0][0][-1] < times[-1] - LENGTH - APART:
            self._last.popleft()
        for row, side in self._faults(values):
            self._tell(float(times[row]), side, values[row])
            self._keep(float(times[row]))
        rows = self._of_the_recording(times)
        self._keeper.append(times[rows], values[rows])

    def end(self, by: str, at: float, notes: Notes | None = None) -> None:
        """Keep what ended the run, and when [s], and further attributes of the recording."""
        for writer in self._writers:
            writer.join()
        told = {"faults": json.dumps(self._told)} if self._told else {}
        self._keeper.end(by, at, {**told, **(notes or {})})

    def _dataset(self, at: float, blocks: list[tuple[Array, Array]]) -> xr.Dataset:
        """Return the recording of a box, of a fault [s]."""
        times = np.concatenate([some for some, _ in blocks])
        values = np.concatenate([some for _, some in blocks])
        return to_dataset(self._description, times, values, A_FAULT, at)

    def _start(self, description: dict[str, Any]) -> None:
        self._description = description
        self._last: deque[tuple[Array, Array]] = deque()
        self._boxes: list[tuple[float, list[tuple[Array, Array]]]] = []
        self._latest, self._sampled, self.missed = -np.inf, 0, 0
        self._told: list[dict[str, str | float]] = []
        self._journals: list[Path] = []
        self._writers: list[Thread] = []
        columns = description.get("columns", {})
        self._sides = [(side, columns[side][0]) for side in SIDES if side in columns]
        self._before = np.zeros(len(self._sides))

    def _faults(self, values: Array) -> list[tuple[int, int]]:
        """Return the rows in which a count of faults has grown, and of which side."""
        count = SUPERVISOR_STATUS.slices["faults"].start
        columns = [first + count for _, first in self._sides]
        counts = np.vstack([self._before, values[:, columns]])
        self._before = counts[-1]
        return [(row, side) for row, side in np.argwhere(np.diff(counts, axis=0) > 0.0).tolist()]

    def _tell(self, at: float, side: int, values: Array) -> None:
        """Note a fault [s] of a side in words."""
        name, first = self._sides[side]
        status = SUPERVISOR_STATUS.unpack(values[first : first + SUPERVISOR_STATUS.size])
        says = words(float(status.state), float(status.reason))
        if len(self._told) < MOST_TOLD:
            self._told.append({"time": at, "side": name.removesuffix("_status"), "says": says})

    def _keep(self, at: float) -> None:
        """Keep the samples up to a fault [s], unless it belongs to the one before."""
        apart = at - self._latest >= APART
        self._latest = at
        if not apart:
            return
        if len(self._boxes) == MOST:
            self.missed += 1
            return
        blocks = []
        for times, values in self._last:
            rows = (times > at - LENGTH) & (times <= at)
            blocks.append((times[rows], values[rows]))
        self._boxes.append((at, blocks))
        if self.path is None:
            return
        path = self.path.with_name(f"{self.path.stem}.fault-{len(self._boxes)}.journal")
        self._journals.append(path)
        # Beside the run: it takes tens of milliseconds, for which no tick may wait.
        writer = Thread(target=self._write_at_once, args=(path, at, blocks))
        writer.start()
        self._writers.append(writer)

    def _write_at_once(self, path: Path, at: float, blocks: list[tuple[Array, Array]]) -> None:
        """Move a box, of a fault [s], from memory to its journal."""
        with suppress(OSError), Journal(path) as journal:  # of a full disk the memory has it
            journal.begin(self._description, self._width)
            for times, values in blocks:
                journal.append(times, values)
            journal.end(A_FAULT, at)
            blocks.clear()

    def _of_the_recording(self, times: Array) -> list[int]:
        """Return the rows that are samples of the recording: the first one of each period."""
        rows = []
        for row, time in enumerate(times.tolist()):
            if time >= self._sampled * self._period - 1e-9:
                rows.append(row)
                self._sampled = int((time + 1e-9) / self._period) + 1
        return rows
