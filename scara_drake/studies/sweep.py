"""Running a study: its runs on a backend, its rows into a store, its result as one dataset."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from scara_drake.common.schema import data_of
from scara_drake.recordings.dataset import BY_DURATION
from scara_drake.recordings.labels import labelled
from scara_drake.scenario import Scenario, dump_scenario
from scara_drake.simulation.many import FAILED, Failed
from scara_drake.simulation.progress import CountLine
from scara_drake.studies.backends import runner, versions
from scara_drake.studies.figures import METRICS, figures_of
from scara_drake.studies.runs import Runs
from scara_drake.studies.store import Memory, Row, Store, open_store
from scara_drake.studies.study import Study, load_study


def sweep(
    study: Study | str | Path,
    store: str | Path | None = None,
    jobs: int | None = None,
    backend: str = "local",
    address: str | None = None,
    progress: bool = False,
) -> xr.Dataset:
    """Run a study and return the figures of its runs.

    A run that breaks off does not stop the others: its figures are NaN, `failed` is true and
    `ended_by` says why. A figure that a run does not have is NaN, and `missing` says why.

    With a store every run is kept as it ends. Ctrl-C, or whatever else ends the study, loses
    nothing: the same call goes on where it was, and gives the same bits as one that was never
    stopped.

    Args:
        study: or the name of a shipped one, or the path of a YAML file; it is not changed.
        store: NetCDF file that the result is written to; while the study runs a journal is beside
            it, of the same name. In memory if None.
        jobs: how many run side by side on this machine; all cores if None. With more than one, a
            script of your own calls this under ``if __name__ == "__main__":``.
        backend: "local", "dask" or "ray" (the extras of these names).
        address: of a Dask scheduler or a Ray head; workers on this machine if None.
        progress: shows a line with how many runs are done, their rate, and the time left.

    Returns:
        The metrics, `run`, `failed`, `ended_by`, `missing` and `engine`, over the parameters of a
        grid (and `seed`, where it has several), or over `run` where the parameters are drawn.

    Raises:
        ValueError: a value of the study is out of its bounds, the store is of another study, the
            backend is not installed, or nobody answers at the address; nothing has been run or
            written then.
        KeyboardInterrupt: Ctrl-C; a store has what was run.
    """
    runs = Runs(study if isinstance(study, Study) else load_study(study))
    scenario = runs.check()
    with open_store(store, description_of(runs, scenario)) as rows:
        if rows.result is not None:
            return rows.result
        with runner(backend, jobs, address, runs.study.engine) as run_all:
            _fill(rows, runs, run_all, progress)
        result = result_of(runs, scenario, rows.rows)
        rows.finish(result)
    return result


def description_of(runs: Runs, scenario: Scenario) -> dict[str, Any]:
    """Return what a result depends on: of two that are equal each run has the same bits."""
    study = data_of(runs.study)
    del study["description"]
    return {"study": study, "scenario": dump_scenario(scenario), "versions": versions()}


def _fill(rows: Store | Memory, runs: Runs, run_all: Any, progress: bool) -> None:
    """Run what is not yet in the rows."""
    study = runs.study
    keep = Keep(tuple(study.metrics), study.after)
    with CountLine(study.name or "runs", len(runs), len(rows.rows), progress) as line:

        def add(number: int, row: Row) -> None:
            rows.add(number, row)
            line.show(len(rows.rows), sum(is_failed(row) for row in rows.rows.values()))

        def scenarios() -> Iterator[tuple[int, Scenario]]:
            for number in sorted(set(range(len(runs))) - set(rows.rows)):
                try:
                    yield number, runs.scenario(number)
                except ValueError as error:  # values that are not allowed together
                    add(number, keep.failed(" ".join(str(error).split())))

        for number, result in run_all(scenarios(), keep):
            add(number, keep.failed(result.reason) if isinstance(result, Failed) else result)


@dataclass(frozen=True)
class Keep:
    """What a study keeps of a run: a function that can be sent to where the run is.

    Attributes:
        names: of the metrics.
        after: the figures count from here on [s].
    """

    names: tuple[str, ...]
    after: float

    def __call__(self, scenario: Scenario, recording: xr.Dataset) -> Row:
        """Return the row of a run that came to its end."""
        figures, missing = figures_of(scenario, recording, self.names, self.after)
        reasons = "; ".join(f"{name}: {reason}" for name, reason in missing.items())
        engine = str(recording.attrs.get("engine", "drake"))
        return Row(tuple(figures), str(recording.attrs["ended_by"]), reasons, engine)

    def failed(self, reason: str) -> Row:
        """Return the row of a run that broke off."""
        return Row((np.nan,) * len(self.names), f"{FAILED}{reason}", "", "")


def is_failed(row: Row) -> bool:
    """Whether a run broke off."""
    return row.ended_by != BY_DURATION


def result_of(runs: Runs, scenario: Scenario, rows: dict[int, Row]) -> xr.Dataset:
    """Return the result of a study: rows by the numbers of all runs, in the shape of its design."""
    dims, shape = tuple(runs.dims), tuple(runs.dims.values())
    ordered = [rows[number] for number in range(len(runs))]

    def shaped(values: Iterable[Any], units: str, long_name: str) -> xr.Variable:
        return labelled(dims, np.reshape(np.array(list(values)), shape), units, long_name)

    data = {}
    for index, name in enumerate(runs.study.metrics):
        values = np.reshape([row.figures[index] for row in ordered], shape)
        data[name] = xr.Variable(dims, values, METRICS[name].attributes())
    if "run" not in runs.dims:
        data["run"] = shaped(range(len(runs)), "1", "number of the run")
    data["failed"] = shaped(map(is_failed, ordered), "1", "whether the run broke off")
    data["ended_by"] = shaped((row.ended_by for row in ordered), "", "what ended the run")
    data["missing"] = shaped((row.missing for row in ordered), "", "figures it has not, and why")
    data["engine"] = shaped((row.engine for row in ordered), "", "what ran it")
    attributes = {
        "name": runs.study.name,
        "description": runs.study.description,
        "scenario": dump_scenario(scenario),
        **versions(),
    }
    return xr.Dataset(data, coords=runs.coordinates(scenario), attrs=attributes)
