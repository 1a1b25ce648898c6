"""The curves of recordings over each other: what the operator asks first, then the researcher."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from typing import Any, Final, NamedTuple

import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from scara_drake import plotting
from scara_drake.display import look
from scara_drake.metrics.curves import (
    AGES,
    COMMAND_ERRORS,
    CONTACT_FORCE,
    EFFORTS,
    FELT_FORCES,
    FORCE_JNDS,
    FORCE_OFFSETS,
    JOINT_ERRORS,
    SLIDING_VARIABLES,
    TOOL_ERROR,
    TOOL_OFFSETS,
    Curve,
)

Array = NDArray[np.float64]
COLORS: Final = (look.FIRST, look.SECOND, *colormaps["Dark2"].colors)  # type: ignore[attr-defined]  # it is a list of colours
MOST_POINTS: Final = 6000  # of a curve: twice the pixels across, so that nothing seen is lost
WIDTH: Final = 11.0  # [in]
LONGEST_LABEL: Final = 28  # characters of a name in a legend, which a path would fill


class Panel(NamedTuple):
    """A picture: a question, and the curves that answer it, each in axes of its own."""

    title: str
    curves: tuple[Curve, ...]


PANELS: Final = (
    Panel("Does the tool follow the command?", COMMAND_ERRORS),
    Panel("How hard does it press, and what is felt of it?", (CONTACT_FORCE, *FELT_FORCES)),
    Panel("Would the hand notice that the force is wrong?", (FORCE_JNDS,)),
    Panel("How old is what comes over the channel?", AGES),
    Panel("How late, and how wrong, is what is shown?", (*TOOL_OFFSETS, *FORCE_OFFSETS)),
    Panel("Does the tool follow its reference?", (TOOL_ERROR,)),
    Panel("Do the joints follow theirs?", JOINT_ERRORS),
    Panel("Do they stay on the sliding surface?", SLIDING_VARIABLES),
    Panel("What does it ask of the drives?", EFFORTS),
)


class Picture(NamedTuple):
    """A figure, its title, and what of it is not there."""

    title: str
    figure: Figure
    missing: tuple[str, ...]


def pictures(names: Sequence[str], recordings: Sequence[xr.Dataset]) -> Iterator[Picture]:
    """Yield the pictures that at least one of the recordings has something for."""
    yield from _path(names, recordings)
    for panel in PANELS:
        yield from _panel(panel, names, recordings)
    yield from _apart(names, recordings)


def _panel(
    panel: Panel, names: Sequence[str], recordings: Sequence[xr.Dataset]
) -> Iterator[Picture]:
    shown = {curve: [curve.shown(each) for each in recordings] for curve in panel.curves}
    shown = {curve: each for curve, each in shown.items() if any(one is not None for one in each)}
    if not shown:
        return
    figure, axes = _figure(len(shown))
    missing = []
    for ax, (curve, values) in zip(axes, shown.items(), strict=True):
        for index, (name, one) in enumerate(zip(names, values, strict=True)):
            if one is not None:
                x, y = thinned(one.time.values, one.values)
                ax.plot(x, y, label=_label(name), **_style(index))
        without = [name for name, one in zip(names, values, strict=True) if one is None]
        if without:
            missing.append(f"{curve.name}: not in {', '.join(without)}")
        plotting.finish(ax, "time [s]", f"{curve.name} [{curve.unit}]")
    yield Picture(panel.title, figure, tuple(missing))


def _path(names: Sequence[str], recordings: Sequence[xr.Dataset]) -> Iterator[Picture]:
    """The ways of the tools, seen from above and from the side."""
    have = [(i, each.p_WE_measured) for i, each in enumerate(recordings) if "p_WE_measured" in each]
    if not have:
        return
    figure, axes = _figure(2)
    for ax, (first, second) in zip(axes, (("x", "y"), ("x", "z")), strict=True):
        for index, path in have:
            x, y = (path.sel(axis=axis).values for axis in (first, second))
            ax.plot(x, y, label=_label(names[index]), **_style(index))
        # Walls reach beyond the picture: its limits are set, so that the box has to give way.
        walled = second == "y" and _add_walls(recordings, ax)
        ax.set_aspect("equal", adjustable="box" if walled else "datalim")
        plotting.finish(ax, f"{first} [m]", f"{second} [m]")
    missing = [n for n, each in zip(names, recordings, strict=True) if "p_WE_measured" not in each]
    said = (f"tool position: not in {', '.join(missing)}",) if missing else ()
    yield Picture("Which way does the tool go?", figure, said)


def _add_walls(recordings: Sequence[xr.Dataset], ax: Axes) -> bool:
    """Draw the walls of the first recording whose scenario has any; whether there is one."""
    for recording in recordings:
        with suppress(ValueError, LookupError):  # not of a run, or of one without a scenario
            if plotting.walls(recording):
                plotting.upright_walls(recording, ax)
                return True
    return False


def _apart(names: Sequence[str], recordings: Sequence[xr.Dataset]) -> Iterator[Picture]:
    """The distance of the tools from that of the first recording, at the times both have."""
    if not all("p_WE_measured" in each for each in recordings):
        return
    figure, (ax,) = _figure(1)
    for index, (name, each) in enumerate(zip(names, recordings, strict=True)):
        if index:
            apart = each.p_WE_measured - recordings[0].p_WE_measured  # where the times are the same
            distance = 1e3 * (apart**2).sum("axis", skipna=False) ** 0.5
            if distance.size:
                x, y = thinned(distance.time.values, distance.values)
                ax.plot(x, y, label=_label(name), **_style(index))
    plotting.finish(ax, "time [s]", f"tool from that of {names[0]} [mm]")
    yield Picture("How far apart are the tools?", figure, ())


def thinned(times: Array, values: Array, most: int = MOST_POINTS) -> tuple[Array, Array]:
    """Return a curve that looks the same, of at most `most` points and two.

    Of each stretch the smallest and the largest value stay, at their times.
    """
    stretch = -(-2 * times.size // most)
    if stretch <= 2:
        return times, values
    padded = np.pad(values, (0, -times.size % stretch), constant_values=np.nan)
    pieces = padded.reshape(-1, stretch)
    starts = stretch * np.arange(len(pieces))
    lowest = np.where(np.isnan(pieces), np.inf, pieces).argmin(axis=1)
    highest = np.where(np.isnan(pieces), -np.inf, pieces).argmax(axis=1)
    kept = np.unique([starts + lowest, starts + highest])
    return times[kept], values[kept]


def _label(name: str) -> str:
    """Return a name, or the end of one that is too long for a legend."""
    return name if len(name) <= LONGEST_LABEL else f"…{name[1 - LONGEST_LABEL :]}"


def _style(index: int) -> dict[str, Any]:
    """The first is broad, so that it is seen below another that is the same."""
    wide = {"linewidth": 3.0, "alpha": 0.45} if index == 0 else {"linewidth": 1.1}
    return {"color": COLORS[index % len(COLORS)], **wide}


def _figure(count: int) -> tuple[Figure, list[Axes]]:
    columns = min(count, 3) if count != 2 else 2
    rows = -(-count // columns)
    figure = Figure(figsize=(WIDTH, 3.4 if rows == 1 else 2.7 * rows), layout="constrained")
    axes = np.ravel(figure.subplots(rows, columns))
    return figure, list(axes)
