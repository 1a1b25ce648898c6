"""Inverse kinematics: the package's methods beside TRAC-IK, roboticstoolbox and Drake's own.

All solve the same targets in one run, in turns of a few targets each and in rotating order, so that
what else the machine does falls on all alike. Whether a target is met is decided by a forward
kinematics of the benchmark's own. The peers come with the extra `benchmarks`; those that are not
there are left out. Run it on a machine that rests::

    python benchmarks/ik_methods.py --output benchmarks/results
"""

from __future__ import annotations

import argparse
import csv
import gc
import os
import platform
import time
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from ik_solvers import Solver, solvers
from ik_targets import Array, Targets, errors, make_targets, reached
from rich import box
from rich.console import Console
from rich.progress import track
from rich.table import Table
from rich.text import Text

TURN = 20  # targets that a solver is given before the next one has its turn
PACKAGES = ("scara-drake", "drake", "numba", "numpy", "pytracik", "roboticstoolbox-python")
OURS_COLOUR, PEER_COLOUR = "tab:orange", "tab:gray"


@dataclass
class Row:
    """What one solver did on one set; times in µs (a point, for paths), the error in µm."""

    targets: str
    solver: str
    ours: bool
    poses: int
    success: float
    median: float
    p99: float
    median_error: float
    ratios: dict[str, float]


def measure(targets: Targets, contestants: Sequence[Solver]) -> tuple[Array, Array]:
    """Return the times [µs] (solvers, n) and the answers (solvers, n, ..., 6), NaN for none."""
    n, shape = len(targets), targets.X_WE.shape[:-2]
    times = np.empty((len(contestants), n))
    answers = np.full((len(contestants), *shape, 6), np.nan)
    for solver in contestants:
        solver.call(0)  # compiles
    gc.collect()
    gc.disable()
    try:
        turns = [range(begin, min(begin + TURN, n)) for begin in range(0, n, TURN)]
        for number, turn in enumerate(track(turns, targets.name, console=Console(stderr=True))):
            for place in range(len(contestants)):
                index = (place + number) % len(contestants)
                solver = contestants[index]
                solver.call(turn[-1])  # untimed: the one before has emptied the caches
                for k in turn:
                    begin = time.perf_counter_ns()
                    answer = solver.call(k)
                    times[index, k] = 1e-3 * (time.perf_counter_ns() - begin)
                    if answer is not None:
                        answers[index, k] = answer
            gc.collect()
    finally:
        gc.enable()
    if targets.paths:
        times /= targets.X_WE.shape[1]
    return times, answers


def compare(targets: Targets, contestants: Sequence[Solver]) -> list[Row]:
    """Measure one set."""
    times, answers = measure(targets, contestants)
    medians = np.median(times, axis=1)
    references = {
        solver.reference: median
        for solver, median in zip(contestants, medians, strict=True)
        if solver.reference
    }
    rows = []
    for solver, time_, median, q in zip(contestants, times, medians, answers, strict=True):
        good = reached(targets, q)
        distance, _ = errors(targets.X_WE, q)
        rows.append(
            Row(
                targets=targets.name,
                solver=solver.name,
                ours=solver.ours,
                poses=good.size,
                success=float(good.mean()),
                median=float(median),
                p99=float(np.quantile(time_, 0.99)),
                median_error=1e6 * float(np.median(distance[good])) if good.any() else np.nan,
                ratios={name: float(median / one) for name, one in references.items()},
            )
        )
    return rows


def cells(rows: Sequence[Row]) -> tuple[list[str], list[list[str]]]:
    """Return the headings and the texts of a table."""
    headings = ["solver", "met [%]", "median [µs]", "99 % [µs]", *rows[0].ratios, "error [µm]"]
    body = [
        [
            row.solver,
            f"{100.0 * row.success:.2f}".rstrip("0").rstrip("."),
            _digits(row.median),
            _digits(row.p99),
            *(_digits(ratio) for ratio in row.ratios.values()),
            _digits(row.median_error),
        ]
        for row in rows
    ]
    return headings, body


def _digits(value: float) -> str:
    if np.isnan(value):
        return "-"
    if value < 1e-3:
        return "< 0.001"
    return f"{value:.3g}" if value < 1000.0 else f"{value:.0f}"


def print_table(console: Console, title: str, rows: Sequence[Row]) -> None:
    """Print one set."""
    table = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0))
    headings, body = cells(rows)
    for heading in headings:
        left = heading == "solver"
        table.add_column(
            Text(heading.replace(" [", "\n[")), justify="left" if left else "right", no_wrap=True
        )
    for row, texts in zip(rows, body, strict=True):
        table.add_row(*texts, style=None if row.ours else "dim")
    console.print(table)


def processor() -> str:
    """Name and number of the processors."""
    name = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists():
        for line in info.read_text().splitlines():
            if line.startswith("model name"):
                name = line.partition(":")[2].strip()
                break
    return f"{name}, {os.cpu_count()} logical cores"


def versions() -> str:
    """Versions of what takes part."""
    found = [f"Python {platform.python_version()}"]
    for package in PACKAGES:
        try:
            found.append(f"{package} {version(package)}")
        except PackageNotFoundError:
            found.append(f"{package} not installed")
    return ", ".join(found)


def write(
    folder: Path, sets: Sequence[Targets], results: Sequence[Sequence[Row]], notes: Sequence[str]
) -> None:
    """Write ik_methods.md, .csv and .png."""
    folder.mkdir(parents=True, exist_ok=True)
    write_csv(folder / "ik_methods.csv", results)
    plot(folder / "ik_methods.png", sets, results)
    command = f"python benchmarks/ik_methods.py --targets {len(sets[0])}"
    lines = [
        "# Inverse kinematics: measured beside its peers",
        "",
        f"{date.today().isoformat()}; {processor()}; {versions()}.",
        "",
        f"Written by `{command}`. Met: within 5 mm, 0.0175 rad and the joint ranges, by the "
        "benchmark's own forward kinematics. Times are of one call from Python, failures "
        "included; ratios are of medians. The error is the median position error of the poses "
        "that were met: some solvers stop at the tolerance, others go on to the exact pose.",
        "",
        "![Median and 99th percentile of each solver](ik_methods.png)",
    ]
    for targets, rows in zip(sets, results, strict=True):
        headings, body = cells(rows)
        count = f"{len(targets)} {'paths' if targets.paths else 'poses'}"
        lines += ["", f"## {targets.title[0].upper()}{targets.title[1:]}, {count}", ""]
        lines += [" | ".join(["", *headings, ""]).strip()]
        lines += ["|---|" + "---:|" * (len(headings) - 1)]
        lines += [" | ".join(["", *texts, ""]).strip() for texts in body]
    lines += ["", *notes] if notes else []
    (folder / "ik_methods.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def write_csv(path: Path, results: Sequence[Sequence[Row]]) -> None:
    """Write all rows."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(
            ["targets", "solver", "poses", "success", "median_us", "p99_us", "median_error_um"]
        )
        for row in (row for rows in results for row in rows):
            numbers = (row.success, row.median, row.p99, row.median_error)
            writer.writerow(
                [row.targets, row.solver, row.poses, *(f"{value:.6g}" for value in numbers)]
            )


def plot(path: Path, sets: Sequence[Targets], results: Sequence[Sequence[Row]]) -> None:
    """Draw the median (dot) and the 99th percentile (end of the line) of each solver."""
    heights = [len(rows) for rows in results]
    figure, axes = plt.subplots(
        len(sets), figsize=(9.0, 0.27 * sum(heights) + 3.0), sharex=True, squeeze=False,
        height_ratios=heights, layout="constrained",
    )  # fmt: skip
    for ax, targets, rows in zip(axes[:, 0], sets, results, strict=True):
        for y, row in enumerate(rows):
            colour = OURS_COLOUR if row.ours else PEER_COLOUR
            ax.plot([row.median, row.p99], [y, y], color=colour, linewidth=2)
            ax.plot(row.median, y, "o", color=colour)
            ax.annotate(
                f"{100.0 * row.success:.4g} %", (1.01, y), xycoords=("axes fraction", "data"),
                va="center", fontsize="small",
            )  # fmt: skip
        ax.set_yticks(range(len(rows)), [row.solver for row in rows], fontsize="small")
        ax.invert_yaxis()
        ax.set_xscale("log")
        ax.grid(axis="x", alpha=0.3)
        ax.set_title(targets.title, loc="left", fontsize="medium")
    axes[-1, 0].set_xlabel("time [µs]: median (dot) to 99th percentile; at the right: targets met")
    figure.savefig(path, dpi=120)
    plt.close(figure)


def main(arguments: list[str] | None = None) -> None:
    """Measure, print, and write where asked to."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("--targets", type=int, default=1000, help="poses a set (default 1000)")
    parser.add_argument("--quick", action="store_true", help="40 poses a set: only to try it")
    parser.add_argument("--output", type=Path, metavar="FOLDER", help="write .md, .csv and .png")
    options = parser.parse_args(arguments)
    if options.targets < 1:
        parser.error(f"--targets {options.targets}: allowed 1 or more")
    console = Console()
    console.print(f"{processor()}; {versions()}", highlight=False)
    sets = make_targets(40 if options.quick else options.targets)
    results, missing = [], []
    for targets in sets:
        contestants, notes = solvers(targets)
        missing += [note for note in notes if note not in missing]
        results.append(compare(targets, contestants))
        print_table(console, targets.title, results[-1])
    for note in missing:
        console.print(note)
    if options.output:
        write(options.output, sets, results, missing)
        console.print(f"Results: {options.output}")


if __name__ == "__main__":
    main()
