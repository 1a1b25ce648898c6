"""Writes docs/recordings.md: every variable of a recording, from the declarations themselves.

Run ``python docs/make_recording_reference.py`` after a change to what is recorded.
"""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Iterator
from pathlib import Path

from scara_drake.exports.formats import FORMATS
from scara_drake.joints import JOINT_NAMES, JOINT_UNITS
from scara_drake.recordings import journal
from scara_drake.recordings.attributes import ATTRIBUTES
from scara_drake.recordings.signals import (
    JOINT_QUANTITIES,
    PRESENT,
    SIGNALS,
    Signal,
)
from scara_drake.vectors import BUTTON_NAMES, ORIENTATION_NAMES, STICK_NAMES

PAGE = Path(__file__).with_name("recordings.md")
HEAD = """# Recordings

What is in a recording. This page is made by `python docs/make_recording_reference.py` from the
declarations in the code. A recording is an `xarray.Dataset`, and a file of one is NetCDF 4 (HDF5),
compressed, with a checksum of each chunk and of the whole; SI units throughout. W is the world, z
up; E is the tool frame; `p_WE` is the position of E in W. The sample at t is of the state at t,
before the updates of that tick (see "One tick" in [architecture.md](architecture.md#one-tick)).

## Reading it

```python
import xarray as xr

import scara_drake as sd

made = sd.simulate(sd.load_scenario("joint_sine"), duration=0.5)
sd.save_recording(made, "joint_sine.nc")
recording = sd.load_recording("joint_sine.nc")  # its checksum is looked at
error = (recording.q_desired - recording.q_measured).sel(joint="theta2")  # [rad]
print(float(abs(error).max()))

table = sd.to_table(recording)  # pandas: a row a sample
print(table["q_measured_d1"].iloc[-1], table.attrs["units"]["q_measured_d1"])

with xr.open_dataset("joint_sine.nc", engine="netcdf4") as lazy:  # nothing of ours is needed
    print(lazy.tau_applied.sel(time=0.25, joint="d1").item())  # [N]
```

In MATLAB and Octave, where the dimensions stand in reverse order (joint, time):

```matlab
q = ncread("joint_sine.nc", "q_measured");
t = ncread("joint_sine.nc", "time");
plot(t, q(2, :))
ncreadatt("joint_sine.nc", "/", "scenario")
```

In R, `ncdf4::ncvar_get(ncdf4::nc_open("joint_sine.nc"), "q_measured")`. For programs that read none
of this, `scara-drake export joint_sine.nc --to csv` and the other formats below.
"""


def _listed(names: Iterable[str]) -> str:
    return ", ".join(f"`{name}`" for name in names)


DIMS = {
    "time": ("one a sample, decimals of seconds", "s"),
    "joint": (_listed(JOINT_NAMES), ""),
    "axis": ("`x`, `y`, `z`", ""),
    "stick": (_listed(STICK_NAMES), ""),
    "motor": ("`low`, `high`", ""),
    "rotation": (_listed(ORIENTATION_NAMES), ""),
    "button": (_listed(BUTTON_NAMES), ""),
    "surface": ("the names of the scenario's surfaces; not there without one", ""),
}


def present(signal: Signal) -> str:
    """Say in which recordings a variable is there."""
    if "surface" in signal.dims:
        return "where there is a surface"
    return "always" if signal.always else f"where {PRESENT[signal.source]}"


def rows() -> Iterator[str]:
    """Yield the lines of the table of variables."""
    for name, signal in SIGNALS.items():
        dims = ", ".join(("time", *signal.dims))
        units = f"of `{signal.units}`" if signal.units in JOINT_QUANTITIES else signal.units
        source = f"`{signal.source}`" if signal.source else "worked out from the joints"
        cells = [f"`{name}`", dims, units, signal.long_name, present(signal), source]
        yield table_row(cells)


def table_row(cells: list[str]) -> str:
    """Return a line of a table."""
    return f"| {' | '.join(cells)} |"


def page() -> str:
    """Return the whole page."""
    first, other = JOINT_UNITS[0], JOINT_UNITS[1]
    journal_format = inspect.cleandoc(journal.__doc__ or "").partition("\n\n")[2]
    text = [HEAD, "## Dimensions\n", "| dimension | its labels | unit |", "|---|---|---|"]
    text += [table_row([f"`{name}`", *said]) for name, said in DIMS.items()]
    text.append("""
## Variables

A variable that is there always, and that the Diagram has no signal for, is NaN throughout: a run
without a stick has no `joystick_axes`. The attribute `period` [s] says how often its signal
changes. `source` is the output port of the Diagram.

| variable | dimensions | unit | what it is | there | source |
|---|---|---|---|---|---|""")
    text += rows()
    text.append(f"""
The unit of a joint is in a coordinate, by the variable's attribute `units_in`; the others have
theirs in `units`.

| coordinate | `{JOINT_NAMES[0]}` | `{JOINT_NAMES[1]}` to `{JOINT_NAMES[-1]}` |
|---|---|---|""")
    text += [
        table_row([f"`{name}`", quantity[first], quantity[other]])
        for name, quantity in JOINT_QUANTITIES.items()
    ]
    text.append("\n## Attributes\n\n| attribute | what it says |\n|---|---|")
    text += [table_row([f"`{name}`", said]) for name, said in ATTRIBUTES.items()]
    text.append("""
## Other formats

By `scara-drake export FILE.nc --to FORMAT` or `sd.export(recording, path)`. In a table a variable
makes a column for each entry: `q_measured_d1`, `f_env_on_tool_W_x`, `delay_up`.

| format | suffix | what it is | needs |
|---|---|---|---|""")
    for name, each in FORMATS.items():
        needs = f"the extra `{each.extra}`" if each.extra else ""
        text.append(table_row([f"`{name}`", f"`{each.suffix}`", each.what, needs]))
    text.append(f"""
## The journal of a run

{journal_format}

`scara-drake recover` makes a recording of a journal; `sd.load_recording`, `compare`, `export` and
`replay` take it as it is.
""")
    return "\n".join(text)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
