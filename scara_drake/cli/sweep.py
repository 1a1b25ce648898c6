"""The command `scara-drake sweep`: run a study, and draw what comes of it."""

from __future__ import annotations

import argparse
from pathlib import Path

import xarray as xr
from rich import box
from rich.console import Console
from rich.table import Table

from scara_drake.cli.outputs import check_output
from scara_drake.common.checks import shown
from scara_drake.studies.study import load_study
from scara_drake.studies.sweep import sweep

MOST_SHOWN = 5  # runs that failed, each a line


def run(options: argparse.Namespace, console: Console) -> int:
    """Run a study into its store, and print what came of it.

    Returns:
        The exit status: 0, or 1 where no run came to its end.

    Raises:
        ValueError: bad input; one line.
        OSError: the store or the picture cannot be written.
        KeyboardInterrupt: the store has what was run.
    """
    study = load_study(options.study)
    store = options.store or Path("runs") / f"{study.name}.nc"
    check_output("--store", store, ".nc")
    check_output("--picture", options.picture, ".png", ".svg", ".pdf")
    try:
        result = sweep(
            study,
            store,
            jobs=options.jobs,
            backend=options.backend,
            address=options.address,
            progress=True,
        )
    except KeyboardInterrupt:
        if store.with_suffix(".journal").exists():
            console.print(f"Stopped; the same command goes on with what is in {store.parent}.")
        raise
    _print(result, console)
    console.print(f"Study: {store}")
    if options.picture:
        save_picture(result, options.picture)
        console.print(f"Picture: {options.picture}")
    return 1 if bool(result.failed.all()) else 0


def save_picture(result: xr.Dataset, path: Path) -> None:
    """Draw a study into a file; its folder is made if need be."""
    from matplotlib.figure import Figure  # takes a while to import

    from scara_drake.studies.picture import study_map

    figure = Figure(layout="constrained")
    study_map(result, figure)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=100)


def _print(result: xr.Dataset, console: Console) -> None:
    failed, count = result.failed.values.ravel(), result.failed.size
    table = Table(
        title=f"{result.attrs['name']}: {count} runs", title_justify="left", box=box.SIMPLE_HEAD
    )
    for heading in ("", "least", "median", "most", "unit", "runs without"):
        table.add_column(heading, justify="left" if heading in ("", "unit") else "right")
    for name in [name for name in result.data_vars if "units" in result[name].attrs]:
        values = result[name]
        if values.dtype.kind != "f":
            continue
        numbers = (float(f) for f in (values.min(), values.median(), values.max()))
        none = int(values.isnull().sum())
        cells = [f"{number:.4g}" for number in numbers]
        table.add_row(str(name), *cells, values.attrs["units"], str(none) if none else "")
    console.print(table)
    numbers = result.run.values if "run" in result.dims else result.run.values.ravel()
    lines = [f"run {n}: {w}" for n, w in zip(numbers, result.ended_by.values.ravel(), strict=True)]
    broken = [line for line, fails in zip(lines, failed, strict=True) if fails]
    for line in broken[:MOST_SHOWN]:
        console.print(f"Failed: {shown(line, 200, quotes=False)}", highlight=False, soft_wrap=True)
    if len(broken) > MOST_SHOWN:
        console.print(f"Failed: {len(broken) - MOST_SHOWN} more")
    missing = sorted({str(text) for text in result.missing.values.ravel()} - {""})
    for text in missing[:MOST_SHOWN]:
        console.print(f"Without a figure: {shown(text, 200, quotes=False)}", highlight=False)
