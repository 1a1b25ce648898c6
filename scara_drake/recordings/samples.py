"""The samples of a run, kept in memory or in a journal."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Protocol

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from scara_drake.recordings.dataset import Notes, to_dataset, with_notes
from scara_drake.recordings.journal import Journal

Array = NDArray[np.float64]


class Keeper(Protocol):
    """What keeps the samples of a run: a `Journal`, or `Samples`."""

    @property
    def has_samples(self) -> bool:
        """Whether there are any."""

    @property
    def path(self) -> Path | None:
        """The file where they are; None for none."""

    def begin(self, description: dict[str, Any], width: int) -> None:
        """Keep what the run says of itself; samples have `width` values.

        What has been kept before is forgotten.
        """

    def append(self, times: Array, values: Array) -> None:
        """Keep samples at times (n,) with values (n, width), which nobody changes any more."""

    def end(self, by: str, at: float, notes: Notes | None = None) -> None:
        """Keep what ended the run, and when [s], and further attributes of the recording."""


class Samples:
    """Keeps the samples of a run in memory; see `Keeper`."""

    path = None

    def __init__(self) -> None:
        self.begin({}, 0)

    @property
    def has_samples(self) -> bool:
        """Whether there are any."""
        return bool(self._times)

    def begin(self, description: dict[str, Any], width: int) -> None:
        """Keep what the run says of itself; samples have `width` values."""
        self._description, self._width = description, width
        self._times: list[Array] = []
        self._values: list[Array] = []
        self._end = "", 0.0

    def append(self, times: Array, values: Array) -> None:
        """Keep samples at times (n,) with values (n, width), which nobody changes any more."""
        if times.size:
            self._times.append(times)
            self._values.append(values)

    def end(self, by: str, at: float, notes: Notes | None = None) -> None:
        """Keep what ended the run, and when [s], and further attributes of the recording."""
        self._end = by, at
        self._description = with_notes(self._description, notes)

    def recording(self) -> xr.Dataset:
        """Return the recording."""
        times = np.concatenate([np.empty(0), *self._times])
        values = np.concatenate([np.empty((0, self._width)), *self._values])
        return to_dataset(self._description, times, values, *self._end)

    def write(self, path: Path) -> None:
        """Write the journal of the run.

        Raises:
            OSError: it cannot be written.
        """
        with Journal(path) as journal:
            journal.begin(self._description, self._width)
            for times, values in zip(self._times, self._values, strict=True):
                journal.append(times, values)
            journal.end(*self._end)
