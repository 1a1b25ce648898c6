"""What recordings have in common, and what not: figures, variables, scenarios, verdicts."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd
import xarray as xr

from scara_drake.comparison.differences import Difference, differences, is_there
from scara_drake.comparison.scenarios import scenario_differences
from scara_drake.joints import JOINT_NAMES
from scara_drake.metrics.curves import settled
from scara_drake.metrics.figures import figures
from scara_drake.metrics.judgement import verdict
from scara_drake.recordings.files import load_recording

MOST: Final = 10  # recordings beside each other: no table or plot shows more
JUDGED: Final = (
    "q_measured", "q_desired", "v_measured", "v_desired", "tau_applied", "p_WE_measured",
    "p_WE_desired", "p_WE_commanded", "f_env_on_tool_W", "delay_up", "status",
)  # fmt: skip


@dataclass(frozen=True)
class Comparison:
    """Recordings beside each other; the others are compared with the first.

    Attributes:
        names: of the recordings.
        recordings: themselves.
        start: of the time that the figures are of [s].
        end: of it [s]; they all have it.
        figures: a row for each figure, with its unit and a column for each recording; NaN where
            that does not have it.
        variables: of each other recording, how its variables differ from those of the first.
        scenario: fields whose values are not the same, a column for each recording.
        verdicts: on the whole of each recording.
        remarks: what has to be known of the comparison.
    """

    names: tuple[str, ...]
    recordings: tuple[xr.Dataset, ...]
    start: float
    end: float
    figures: pd.DataFrame
    variables: dict[str, list[Difference]]
    scenario: pd.DataFrame
    verdicts: dict[str, str]
    remarks: tuple[str, ...]

    @property
    def equal(self) -> bool:
        """Whether all recordings are equal to the bit: the same times, the same values."""
        times = [recording.time.values for recording in self.recordings]
        return all(np.array_equal(times[0], each) for each in times[1:]) and all(
            difference.equal for each in self.variables.values() for difference in each
        )

    def save_html(self, path: str | Path) -> None:
        """Write the tables, and the curves over each other, as one page that needs no network.

        Raises:
            ValueError: not a name of a page.
            OSError: the page cannot be written.
        """
        from scara_drake.comparison.page import save_page

        save_page(self, path)

    def __str__(self) -> str:
        from scara_drake.comparison.report import as_text

        return as_text(self)

    def _repr_html_(self) -> str:
        from scara_drake.comparison.page import tables

        return tables(self)


def compare(*recordings: xr.Dataset | str | Path, names: Sequence[str] | None = None) -> Comparison:
    """Compare two or more recordings, whatever scenarios they are of.

    The figures are of the time that all have, without its first second. What one does not have is
    NaN there, and is said.

    Args:
        *recordings: of `simulate` or `load_recording`, or files of recordings and journals.
        names: of them; those of the files, or A, B, C, if None.

    Raises:
        ValueError: fewer than two, a file that is no recording, one without samples, or recordings
            that have no time in common.
    """
    if not 2 <= len(recordings) <= MOST:
        raise ValueError(f"recordings: {len(recordings)}, allowed 2 to {MOST}")
    called = tuple(names) if names is not None else _names(recordings)
    if len(called) != len(recordings) or len(set(called)) < len(called):
        raise ValueError(f"names: {', '.join(called)}, allowed one for each recording")
    loaded = tuple(_loaded(*each) for each in zip(called, recordings, strict=True))
    start = max(float(each.time[0]) for each in loaded)
    end = min(float(each.time[-1]) for each in loaded)
    common = [settled(each.sel(time=slice(start, end))) for each in loaded]
    if not all(each.sizes["time"] for each in common):
        raise ValueError("recordings: no time in common, allowed those of the same stretch")
    scenario = pd.DataFrame.from_dict(
        scenario_differences(loaded), orient="index", columns=list(called)
    )
    return Comparison(
        names=called,
        recordings=loaded,
        start=max(float(each.time[0]) for each in common),
        end=end,
        figures=_figures(called, common),
        variables={
            name: differences(loaded[0], each)
            for name, each in zip(called[1:], loaded[1:], strict=True)
        },
        scenario=scenario,
        verdicts={name: _verdict(each) for name, each in zip(called, loaded, strict=True)},
        remarks=tuple(_remarks(called, loaded, end)),
    )


def _names(recordings: Sequence[xr.Dataset | str | Path]) -> tuple[str, ...]:
    """Names of files, as short as they tell them apart, or letters."""
    paths = [None if isinstance(each, xr.Dataset) else Path(each) for each in recordings]
    stems = [path.stem if path else chr(ord("A") + index) for index, path in enumerate(paths)]
    found: list[str] = []
    for path, stem in zip(paths, stems, strict=True):
        name = str(path) if path and stems.count(stem) > 1 else stem
        found.append(name if name not in found else f"{name} ({len(found) + 1})")
    return tuple(found)


def _loaded(name: str, source: xr.Dataset | str | Path) -> xr.Dataset:
    recording = source if isinstance(source, xr.Dataset) else load_recording(source)
    if not recording.sizes.get("time") or "time" not in recording.coords:
        raise ValueError(f"recording: '{name}', allowed one with samples over time")
    return recording


def _figures(names: Sequence[str], recordings: Sequence[xr.Dataset]) -> pd.DataFrame:
    found = [figures(each) for each in recordings]
    units = {name: figure.unit for each in found for name, figure in each.items()}
    rows = [
        [unit, *(each[name].value if name in each else np.nan for each in found)]
        for name, unit in units.items()
    ]
    return pd.DataFrame(rows, index=list(units), columns=["unit", *names])


def _verdict(recording: xr.Dataset) -> str:
    missing = [name for name in JUDGED if name not in recording]
    if missing:
        return f"none: there is no {', '.join(missing)}"
    if list(recording.joint.values) != list(JOINT_NAMES):
        return "none: not all joints are there"
    return str(verdict(recording))


def _remarks(names: Sequence[str], recordings: Sequence[xr.Dataset], end: float) -> Iterator[str]:
    """Say where the recordings are not of one length, rate, or choice of variables."""
    for what, form, values in (
        ("length", "{:.6g} s", [float(each.time[-1]) for each in recordings]),
        ("period", "{:.6g} s", [_period(each) for each in recordings]),
    ):
        if len({form.format(value) for value in values}) > 1:
            each = [
                f"{name} {form.format(value)}" for name, value in zip(names, values, strict=True)
            ]
            cut = f"; the figures end at {end:.6g} s" if what == "length" else ""
            yield f"not of one {what}: {', '.join(each)}{cut}"
    have = [{str(n) for n, v in each.data_vars.items() if is_there(v)} for each in recordings]
    everything = set.union(*have)
    for name, variables in zip(names, have, strict=True):
        if lacking := sorted(everything - variables):
            yield f"{name} does not have {', '.join(lacking)}"
    for dim in ("joint", "surface"):
        labels = [
            ", ".join(map(str, each[dim].values)) if dim in each.coords else "none"
            for each in recordings
        ]
        if len(set(labels)) > 1:
            each = [f"{name} {label}" for name, label in zip(names, labels, strict=True)]
            yield f"not the same {dim}s: {'; '.join(each)}"


def _period(recording: xr.Dataset) -> float:
    times = recording.time.values
    return float(np.median(np.diff(times))) if times.size > 1 else np.nan
