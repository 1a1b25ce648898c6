"""The couplings of a bilateral teleoperation over the named channels: one table a channel.

What is run, and what each figure means, is told by
`scara_drake.experiments.teleoperation.couplings`. It takes some minutes::

    python benchmarks/couplings.py --output benchmarks/results
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path

import device_table  # the file beside this one
import numpy as np
import xarray as xr
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table
from rich.text import Text

from scara_drake.channel.presets import PRESETS
from scara_drake.experiments.claim import Claim
from scara_drake.experiments.report import sentence
from scara_drake.experiments.teleoperation.couplings import BUFFERED, CASES, COUPLINGS, LINKS, run
from scara_drake.experiments.teleoperation.couplings_runs import has_jitter
from scara_drake.recordings.recorder import versions

# Figure, its heading, and its scale.
PRESSED = {
    "peak": ("peak [N]", 1.0),
    "shown": ("shown [N]", 1.0),
    "felt": ("felt [N]", 1.0),
    "contact": ("contact [%]", 1e2),
    "position_error": ("error [mm]", 1e3),
    "drift": ("drift [mm]", 1e3),
    "ripple": ("ripple [N]", 1.0),
    "force_error": ("force error [N]", 1.0),
    "energy_margin": ("energy [J]", 1.0),
}
SWEPT = {
    "transparency_error": ("Z error [dec]", 1.0),
    "closed_form": ("Z closed form [dec]", 1.0),
    "z_width": ("Z width [dec]", 1.0),
}
ALWAYS = ("peak", "energy_margin")  # of a run that is not stable, too
TOUCHING = ("shown", "felt", "contact", "ripple", "force_error")
LEGEND = (
    "A hand of 150 N/m on a device of 0.3 kg presses 3 cm into a wall of 10 kN/m and 100 N s/m, "
    "holds for 4 s and lets go, in the master's units. Cases: free, without the wall; wall; loss, "
    "the wall with 10 % of the packets lost beside what the channel loses.",
    "- stable: from the second second of the hold on, the device has less energy of motion than "
    "the hand's spring could give, and the ripple is below a quarter of the hand's 6 N. Of a run "
    "that is not, only peak and energy are given.\n"
    "- peak: of the force at the master, before the limit of its actuators.\n"
    "- shown, felt: mean force at the master and at the tool in the last second of the press.\n"
    "- contact: share of the last second of the press in which the tool is touched.\n"
    "- error: tool from master in that second, with the delay removed, rms; in the case free all "
    "along.\n"
    "- drift: tool from master, largest in the last half second, 4.5 s after the release.\n"
    "- ripple: standard deviation of the force at the master in the last second of the press.\n"
    "- force error: to the force at the tool in that second, with the delay removed, rms.\n"
    "- energy: least that was left in coupling and channel, with the reserve; negative where they "
    "made some.\n"
    "- Z error: mean |log10| of the impedance that the coupling shows at the wall over the wall's, "
    "0.1 to 10 Hz, by a sweep of the hand.\n"
    "- Z closed form: the same of the coupling's closed form, where it has one, at the age of what "
    "was in use; where that varies, the mean over it.\n"
    "- buffered: the case wall through the playout buffer that is recommended for the channel, of "
    "which a packet in a hundred may be late; the waves drop those.\n"
    "- Z width: mean log10 of what the hand feels at the wall over that in free space, the device "
    "included.",
)


@dataclass
class Grid:
    """A table: its title, its headings, its rows."""

    title: str
    headings: list[str]
    rows: list[list[str]]

    def print(self, console: Console) -> None:
        """Print it."""
        table = Table(title=self.title, title_justify="left", box=SIMPLE_HEAD, padding=(0, 1, 0, 0))
        for index, heading in enumerate(self.headings):
            table.add_column(
                Text(heading.replace(" ", "\n") if index else heading),
                justify="right" if index else "left",
                no_wrap=index == 0,
            )
        names = [row[0] for row in self.rows]
        for before, row in zip(["", *names], self.rows, strict=False):
            table.add_row("" if row[0] == before else row[0], *row[1:])
        console.print(table)

    def markdown(self) -> list[str]:
        """Return its lines."""
        rule = "|---|" + "---:|" * (len(self.headings) - 1)
        lines = [f"| {' | '.join(row)} |" for row in (self.headings, *self.rows)]
        return [f"## {self.title}", "", lines[0], rule, *lines[1:], ""]


def digits(value: float) -> str:
    """Three digits, and none below a hundredth; "-" for none."""
    if np.isnan(value):
        return "-"
    if abs(value) < 0.005:
        return "0"
    places = 2 if abs(value) < 10.0 else 1 if abs(value) < 100.0 else 0
    return f"{value:.{places}f}"


def summary(data: xr.Dataset) -> Grid:
    """Tabulate the worst of each coupling over the channels, among what was stable."""
    pressed = data.sel(case=[case for case in data.case.values if case != "free"])
    rows = []
    for name in data.coupling.values:
        one, stable = pressed.sel(coupling=name), data.stable.sel(coupling=name)
        calm = one.where(one.stable)
        rows.append(
            [
                name,
                f"{int(stable.sum())} of {stable.size}",
                digits(float(one.peak.max())),
                *(
                    _range(calm[figure].values, scale)
                    for figure, (_, scale) in PRESSED.items()
                    if figure not in ALWAYS
                ),
                digits(float(one.energy_margin.min())),
                *(_range(one[figure].values, 1.0) for figure in SWEPT),
            ]
        )
    headings = ["coupling", "stable runs", *(heading for heading, _ in PRESSED.values())]
    headings += [heading for heading, _ in SWEPT.values()]
    return Grid("Over all channels, pressing", headings, rows)


def _range(values: np.ndarray, scale: float) -> str:
    known = scale * values[~np.isnan(values)]
    if known.size == 0:
        return "-"
    low, high = digits(float(known.min())), digits(float(known.max()))
    return low if low == high else f"{low} to {high}"


def channel(data: xr.Dataset, preset: str) -> Grid:
    """Tabulate the couplings over one channel, a row for each case."""
    there = data.sel(preset=preset)
    rows = []
    for name in data.coupling.values:
        for case in data.case.values:
            one = there.sel(coupling=name, case=case)
            stable = bool(one.stable)
            row = [name, case, "yes" if stable else "no"]
            row += [
                digits(scale * float(one[figure])) if told(figure, case, stable) else ""
                for figure, (_, scale) in PRESSED.items()
            ]
            row += [digits(float(one[figure])) if case == "wall" else "" for figure in SWEPT]
            rows.append(row)
    headings = ["coupling", "case", "stable", *(heading for heading, _ in PRESSED.values())]
    headings += [heading for heading, _ in SWEPT.values()]
    age = "; ".join(
        f"{_range(there[figure].values.ravel(), 1e3)} ms {word}"
        for figure, word in (("age_mean", "mean"), ("age_p99", "at 99 %"))
    )
    meaning = PRESETS[preset].meaning if preset in PRESETS else "a constant delay"
    return Grid(f"{preset}: {meaning}; age of information {age}", headings, rows)


def buffers(data: xr.Dataset) -> Grid:
    """Tabulate what a playout buffer gives back over the channels with jitter."""
    headings = ["channel", "coupling"]
    for figure in BUFFERED:
        heading = (PRESSED | SWEPT)[figure][0]
        headings += [heading, f"buffered {heading}"]
    rows = []
    for preset in data.preset.values:
        for name in data.coupling.values:
            one = data.sel(preset=preset, coupling=name)
            if not bool(one.buffered_contact.isnull()):
                row = [preset, name]
                for figure in BUFFERED:
                    plain, scale = one[figure], (PRESSED | SWEPT)[figure][1]
                    plain = plain.sel(case="wall") if "case" in plain.dims else plain
                    row += [digits(scale * float(x)) for x in (plain, one[f"buffered_{figure}"])]
                rows.append(row)
    depths = ", ".join(
        f"{1e3 * playout.depth:g} ms for {name}"
        for name in data.preset.values
        if has_jitter(name) and (playout := PRESETS[name].playout)
    )
    return Grid(f"The wall, without and through the recommended buffer: {depths}", headings, rows)


def told(figure: str, case: str, stable: bool) -> bool:
    """Whether a figure of a run means something."""
    return figure in ALWAYS or (stable and not (figure in TOUCHING and case == "free"))


def write(
    folder: Path, grids: Sequence[Grid], claims: Sequence[Claim], more: Sequence[str]
) -> None:
    """Write couplings.md, with further lines at its end."""
    folder.mkdir(parents=True, exist_ok=True)
    taking_part = ", ".join(f"{name} {version}" for name, version in versions().items())
    lines = ["# Bilateral couplings over the named channels", ""]
    lines += [
        f"{date.today().isoformat()}; {taking_part}.",
        "",
        "Written by `python benchmarks/couplings.py`.",
        "",
    ]
    lines += [line for text in LEGEND for line in (text, "")]
    lines += [f"- {sentence(claim)}" for claim in claims]
    lines += ["", *(line for grid in grids for line in grid.markdown()), *more]
    (folder / "couplings.md").write_text("\n".join(lines).rstrip() + "\n", encoding="utf-8")


def main(arguments: list[str] | None = None) -> None:
    """Run, print, and write where asked to."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("--jobs", type=int, help="runs side by side (default all cores)")
    parser.add_argument("--couplings", nargs="+", choices=COUPLINGS, default=list(COUPLINGS))
    parser.add_argument("--presets", nargs="+", choices=LINKS, default=list(LINKS))
    parser.add_argument("--output", type=Path, metavar="FOLDER", help="write couplings.md")
    options = parser.parse_args(arguments)
    if options.jobs is not None and options.jobs < 1:
        parser.error(f"--jobs {options.jobs}: allowed 1 or more")
    begin = time.perf_counter()
    experiment = run(
        couplings=options.couplings,
        presets=options.presets,
        cases=CASES,
        jobs=options.jobs,
    )
    data = experiment.data
    grids = [summary(data), buffers(data), *(channel(data, name) for name in data.preset.values)]
    console = Console()
    for grid in grids:
        grid.print(console)
    for claim in experiment.claims:
        console.print(f"{sentence(claim)}\n", highlight=False)
    if options.output:
        write(options.output, grids, experiment.claims, device_table.section(options.jobs))
        console.print(f"Results: {options.output / 'couplings.md'}")
    console.print(f"{time.perf_counter() - begin:.0f} s")


if __name__ == "__main__":
    main()
