"""The couplings on devices that exist, as a section of Markdown for `couplings.md`.

What is run, and what each figure means, is told by
`scara_drake.experiments.teleoperation.devices`. Alone it prints the section::

    python benchmarks/device_table.py
"""

from __future__ import annotations

import xarray as xr

from scara_drake.experiments.report import sentence
from scara_drake.experiments.teleoperation import devices
from scara_drake.operator.kinesthetic_devices import DEVICES

HEADINGS = (
    "device", "scale", "coupling", "channel", "stable", "asked [N]", "felt [N]", "tool [N]",
    "at its limit [%]", "energy left [mJ]",
)  # fmt: skip
LEGEND = (
    "A shorter press of the same hand, on devices that exist and on the own one of 40 N. Scale "
    "full: a newton at the tool is one in the hand; natural: the device's force stands for 40 N at "
    "the tool, its workspace for 75 mm. Asked: mean force asked of the device in the last quarter "
    "of the hold; felt: that within its limit; tool: at the tool, in the master's units; at its "
    "limit: share of the press. Of an unstable run only the energy is given."
)


def section(jobs: int | None = None) -> list[str]:
    """Run the experiment, and return the lines of its section.

    Args:
        jobs: runs side by side; all cores if None.
    """
    experiment = devices.run(jobs=jobs)
    rule = "|---|---|---|---|---|" + "---:|" * (len(HEADINGS) - 5)
    lines = ["## Devices that exist", "", LEGEND, ""]
    for claim in experiment.claims:
        lines += [f"- {sentence(claim)}"]
    return [*lines, "", f"| {' | '.join(HEADINGS)} |", rule, *_rows(experiment.data), ""]


def _rows(data: xr.Dataset) -> list[str]:
    rows = []
    stacked = data.stack(run=("device", "scale", "coupling", "preset"))
    for run in stacked.run.values:
        if run[0] not in DEVICES and run[1] != devices.SCALES[0]:
            continue  # the own device has one scale
        one = stacked.sel(run=run)
        calm = bool(one.stable)
        figures = [
            f"{scale * float(one[name]):.{digits}f}" if calm or name == "energy_margin" else "-"
            for name, scale, digits in (
                ("asked", 1.0, 2),
                ("felt", 1.0, 2),
                ("tool", 1.0, 2),
                ("cut", 1e2, 0),
                ("energy_margin", 1e3, 1),
            )
        ]
        rows.append(f"| {' | '.join([*map(str, run), 'yes' if calm else 'no', *figures])} |")
    return rows


if __name__ == "__main__":
    print("\n".join(section()))
