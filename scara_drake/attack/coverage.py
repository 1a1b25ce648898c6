"""How much of the space a search has seen: no verdict is worth more than this."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Final

import numpy as np

from scara_drake.attack.bounds import Bound, shares_of
from scara_drake.attack.trial import Trial

CELLS: Final = 10  # of a range, beside each other


@dataclass(frozen=True)
class Reached:
    """What of a field's range was tried.

    Attributes:
        low, median, high: of the values.
        gap: largest part of the range in which nothing was tried, as a share.
        attacked: share of the runs that changed the field.
        alone: largest harm of the runs that changed nothing else; NaN where none counted.
    """

    low: float | str
    median: float | str
    high: float | str
    gap: float
    attacked: float
    alone: float


@dataclass(frozen=True)
class Coverage:
    """What of the space was tried.

    Attributes:
        fields: by name.
        pairs: share of the cells, of ten by ten for each pair of fields, with a run in it.
    """

    fields: dict[str, Reached]
    pairs: float


def coverage_of(bounds: Sequence[Bound], trials: Sequence[Trial]) -> Coverage:
    """Return what was tried, of the runs that count."""
    counted = [trial for trial in trials if trial.counts]
    shares = np.array([shares_of(bounds, trial.attack) for trial in counted])
    shares = shares.reshape(len(counted), len(bounds))
    fields = {}
    for index, bound in enumerate(bounds):
        tried = np.sort(shares[:, index][~np.isnan(shares[:, index])])
        if not tried.size:
            fields[bound.label] = Reached("-", "-", "-", 1.0, 0.0, np.nan)
            continue
        gap = float(np.diff([0.0, *tried.clip(0.0, 1.0), 1.0]).max())
        low, median, high = (
            bound.value(float(each)) for each in (tried[0], tried[len(tried) // 2], tried[-1])
        )
        alone = [t.harm for t in counted if list(t.attack) == [bound.label]]
        fields[bound.label] = Reached(
            low, median, high, gap, tried.size / len(counted), max(alone, default=np.nan)
        )
    return Coverage(fields, _pairs(shares))


def _pairs(shares: np.ndarray) -> float:
    """Return the share of the cells of all pairs of columns with a row in it."""
    if shares.shape[1] < 2 or not len(shares):
        return np.nan
    seen = 0
    for first, second in combinations(range(shares.shape[1]), 2):
        both = shares[:, [first, second]]
        both = both[~np.isnan(both).any(axis=1)]
        cells = np.minimum((both.clip(0.0, 1.0) * CELLS).astype(int), CELLS - 1)
        seen += len(np.unique(cells @ [CELLS, 1]))
    return seen / (CELLS**2 * len(list(combinations(range(shares.shape[1]), 2))))
