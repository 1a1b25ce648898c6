"""The last seconds before each fault, at the full rate, whatever the rate of the recording."""

from __future__ import annotations

from collections import deque
from pathlib import Path
from typing import Any, Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from scara_drake.recordings.dataset import Notes, to_dataset
from scara_drake.recordings.files import save_recording
from scara_drake.recordings.samples import Keeper
from scara_drake.vectors import SUPERVISOR_STATUS

Array = NDArray[np.float64]

LENGTH: Final = 10.0  # [s], that are kept before a fault
MOST: Final = 5  # faults of which they are kept
APART: Final = 1.0  # [s]; what follows sooner belongs to the same fault
SIDES: Final = ("operator_status", "robot_status")


class BlackBox:
    """Keeps every sample of the last seconds before a fault, and passes on those of a recording.

    It stands between a run and what keeps its samples, and has no influence on either. A fault is
    whatever a supervisor counts as one: a hold by itself, a fault, an emergency stop.

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
        """The recordings of the last seconds before each fault, in order."""
        return [
            to_dataset(
                self._description,
                np.concatenate([times for times, _ in blocks]),
                np.concatenate([values for _, values in blocks]),
                "a fault",
                at,
            )
            for at, blocks in self._boxes
        ]

    def write(self, record: Path) -> list[Path]:
        """Write the boxes beside a recording NAME.nc: NAME.fault-1.nc and so on; return the files.

        Raises:
            OSError: one cannot be written.
        """
        paths = []
        for number, box in enumerate(self.boxes, 1):
            paths.append(record.with_name(f"{record.stem}.fault-{number}.nc"))
            save_recording(box, paths[-1])
        return paths

    def begin(self, description: dict[str, Any], width: int) -> None:
        """Keep what the run says of itself; samples have `width` values."""
        self._start(description)
        self._keeper.begin(description, width)

    def append(self, times: Array, values: Array) -> None:
        """Keep samples at times (n,) with values (n, width), which nobody changes any more."""
        if not times.size:
            return
        self._last.append((times, values))
        while self._last[0][0][-1] < times[-1] - LENGTH - APART:
            self._last.popleft()
        for index in self._faults(values):
            self._keep(float(times[index]))
        rows = self._of_the_recording(times)
        self._keeper.append(times[rows], values[rows])

    def end(self, by: str, at: float, notes: Notes | None = None) -> None:
        """Keep what ended the run, and when [s], and further attributes of the recording."""
        self._keeper.end(by, at, notes)

    def _start(self, description: dict[str, Any]) -> None:
        self._description = description
        self._last: deque[tuple[Array, Array]] = deque()
        self._boxes: list[tuple[float, list[tuple[Array, Array]]]] = []
        self._latest, self._sampled, self.missed = -np.inf, 0, 0
        columns = description.get("columns", {})
        count = SUPERVISOR_STATUS.slices["faults"].start
        self._counts = [columns[side][0] + count for side in SIDES if side in columns]
        self._before = np.zeros(len(self._counts))

    def _faults(self, values: Array) -> list[int]:
        """Return the rows in which a count of faults has grown."""
        counts = np.vstack([self._before, values[:, self._counts]])
        self._before = counts[-1]
        return np.flatnonzero((np.diff(counts, axis=0) > 0.0).any(axis=1)).tolist()

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

    def _of_the_recording(self, times: Array) -> list[int]:
        """Return the rows that are samples of the recording: the first one of each period."""
        rows = []
        for row, time in enumerate(times.tolist()):
            if time >= self._sampled * self._period - 1e-9:
                rows.append(row)
                self._sampled = int((time + 1e-9) / self._period) + 1
        return rows
