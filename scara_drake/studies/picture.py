"""The picture of a study: maps over two parameters, curves over one, points where runs are drawn.

Nothing is filled in: where a figure is missing there is a hatched cell or a cross, one kind for
runs that broke off and one for runs that do not have the figure.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle
from numpy.typing import NDArray

from scara_drake.common import checks
from scara_drake.display import look
from scara_drake.studies.scales import (
    NO,
    YES,
    colors_of,
    edges_of,
    is_flag,
    label_of,
    places_of,
    scale_axis,
    scale_values,
)

Array = NDArray[np.float64]

MOST_PANELS: Final = 12  # in a row
HATCHES: Final = {"run failed": "xxxx", "no figure": "////"}
PANEL: Final = (2.7, 2.5)  # [inch]


def study_map(result: xr.Dataset, figure: Figure, metrics: Sequence[str] | None = None) -> None:
    """Draw the figures of a study, a row of panels for each.

    Of a grid the last two parameters with numbers are the axes of a map, or the only one is that of
    curves; each combination of the others is a panel, or a curve. Over several seeds the mean is
    drawn, with the range around a curve. Runs that were drawn are points.

    Args:
        result: of `sweep`; `result.sel(...)` leaves parameters out.
        figure: is filled, and gets a size that suits.
        metrics: to draw, in this order; all if None.

    Raises:
        ValueError: no such figure, or too many panels.
    """
    known = [str(name) for name in result.data_vars if result[name].dtype.kind == "f"]
    names = known if metrics is None else list(metrics)
    for name in names:
        checks.choice("metrics", name, known)
    if "run" in result.dims:
        kinds = _draw_points(result, figure, names)
    else:
        kinds = _draw_grid(result, figure, names)
    if kinds:
        figure.legend(handles=kinds, loc="outside lower right", ncols=4, fontsize="small")


def _draw_grid(result: xr.Dataset, figure: Figure, names: Sequence[str]) -> list[Artist]:
    dims = [str(dim) for dim in result.dims if dim != "seed" and result.sizes[dim] > 1]
    result = result.squeeze([d for d in result.dims if result.sizes[d] == 1], drop=False)
    axes_of = [dim for dim in dims if result[dim].dtype.kind == "f"][-2:]
    if len(axes_of) < 2 and len(dims) == 2 and not axes_of:
        axes_of = dims
    if not axes_of:
        axes_of = dims[-1:] or ["seed"]
    others = [dim for dim in dims if dim not in axes_of]
    indices = product(*(range(result.sizes[dim]) for dim in others))
    picks = [dict(zip(others, pick, strict=True)) for pick in indices]
    if len(axes_of) == 1:
        return _draw_curves(result, figure, names, axes_of[0], picks)
    if len(picks) > MOST_PANELS:
        raise ValueError(
            f"result: {len(picks)} maps of each figure, allowed {MOST_PANELS}: choose by .sel()"
        )
    alone = len(picks) == 1  # then the figures are side by side
    if alone:
        panels = [[ax] for ax in _panels(figure, 1, len(names), (4.0, 3.2))[0]]
    else:
        panels = _panels(figure, len(names), len(picks))
    kinds: dict[str, Artist] = {}
    y, x = axes_of
    for row, name in zip(panels, names, strict=True):
        colors, norm = colors_of(result[name])
        for ax, pick in zip(row, picks, strict=True):
            part = result.isel(pick)
            _draw_map(part, name, ax, x, y, colors=colors, norm=norm)
            kinds |= _hatch_missing(part, name, ax, x, y)
            if ax is not row[0]:
                ax.tick_params(labelleft=False)
                ax.set_ylabel("")
            if row is panels[0]:
                ax.set_title(_title(result, pick), fontsize="medium")
            if row is not panels[-1] and not alone:
                ax.tick_params(labelbottom=False)
                ax.set_xlabel("")
        _explain_colors(result[name], figure, row, colors, norm)
    return list(kinds.values())


def _draw_map(
    part: xr.Dataset, name: str, ax: Axes, x: str, y: str, *, colors: Colormap, norm: Normalize
) -> None:
    values = _over_seeds(part[name]).transpose(y, x)
    if isinstance(norm, LogNorm):
        values = values.clip(min=norm.vmin)  # zero has no place on a logarithmic scale
    ax.pcolormesh(edges_of(part[x]), edges_of(part[y]), values, cmap=colors, norm=norm)
    scale_axis(ax, part[x], "x")
    scale_axis(ax, part[y], "y")


def _hatch_missing(part: xr.Dataset, name: str, ax: Axes, x: str, y: str) -> dict[str, Artist]:
    """Hatch the cells in which a run of any seed has no figure; return what the hatches mean."""
    left, bottom = edges_of(part[x]), edges_of(part[y])
    kinds: dict[str, Artist] = {}
    for kind, where in _missing(part, name).items():
        rows = where.any("seed") if "seed" in where.dims else where
        for j, i in np.argwhere(rows.transpose(y, x).values):
            size = left[i + 1] - left[i], bottom[j + 1] - bottom[j]
            style: dict[str, Any] = {"hatch": HATCHES[kind], "edgecolor": "0.4", "linewidth": 0.0}
            ax.add_patch(Rectangle((left[i], bottom[j]), *size, fill=False, **style))
            kinds[kind] = Patch(facecolor="none", label=kind, **style)
    return kinds


def _draw_curves(
    result: xr.Dataset,
    figure: Figure,
    names: Sequence[str],
    x: str,
    picks: Sequence[dict[str, int]],
) -> list[Artist]:
    panels = _panels(figure, 1, len(names), (4.2, 3.4))[0]
    kinds: dict[str, Artist] = {}
    for ax, name in zip(panels, names, strict=True):
        if is_flag(result[name]) and len(picks) > 1 and len(picks[0]) == 1:
            # Curves between no and yes would hide each other.
            (other,) = picks[0]
            colors, norm = colors_of(result[name])
            _draw_map(result, name, ax, x, other, colors=colors, norm=norm)
            kinds |= _hatch_missing(result, name, ax, x, other)
            _explain_colors(result[name], figure, [ax], colors, norm)
            continue
        for pick in picks:
            part = result.isel(pick)
            places, values = places_of(part[x]), _over_seeds(part[name])
            (line,) = ax.plot(places, values, marker=".", label=_title(result, pick))
            if "seed" in part[name].dims and x != "seed":
                low, high = part[name].min("seed"), part[name].max("seed")
                ax.fill_between(places, low, high, color=line.get_color(), alpha=0.2, linewidth=0)
            kinds |= _cross_missing(part, name, ax, x, line.get_color())
        scale_axis(ax, result[x], "x")
        scale_values(ax, result[name])
        if len(picks) > 1:
            ax.legend(loc="best", fontsize="small")
    return list(kinds.values())


def _cross_missing(part: xr.Dataset, name: str, ax: Axes, x: str, color: Any) -> dict[str, Artist]:
    """Mark at the foot of a plot where there is no figure; return what the marks mean."""
    kinds: dict[str, Artist] = {}
    for (kind, where), marker in zip(_missing(part, name).items(), ("x", "|"), strict=True):
        rows = where.any([dim for dim in where.dims if dim != x])
        places = np.asarray(places_of(part[x]))[rows.values]
        if places.size:
            foot = ax.get_xaxis_transform()
            ax.plot(places, np.full(places.size, 0.02), marker, color=color, transform=foot)
            kinds[kind] = Line2D([], [], color="0.4", marker=marker, linestyle="", label=kind)
    return kinds


def _draw_points(result: xr.Dataset, figure: Figure, names: Sequence[str]) -> list[Artist]:
    parameters = [str(name) for name in result.coords if name not in ("run", "seed")] or ["run"]
    kinds: dict[str, Artist] = {}
    panels = _panels(figure, len(names), len(parameters), (3.2, 2.7))
    for row, name in zip(panels, names, strict=True):
        for ax, parameter in zip(row, parameters, strict=True):
            places = places_of(result[parameter])
            ax.plot(places, result[name], ".", color=look.FIRST, alpha=0.7)
            kinds |= _cross_missing(result, name, ax, "run", "0.4") if parameter == "run" else {}
            if parameter != "run":
                kinds |= _cross_missing(
                    result.assign_coords(run=("run", places)), name, ax, "run", "0.4"
                )
            scale_axis(ax, result[parameter], "x")
            scale_values(ax, result[name])
            if ax is not row[0]:
                ax.set_ylabel("")
    return list(kinds.values())


def _panels(
    figure: Figure, rows: int, columns: int, size: tuple[float, float] = PANEL
) -> list[list[Axes]]:
    figure.set_size_inches(size[0] * columns + 1.3, size[1] * rows + 0.7)
    return [list(row) for row in figure.subplots(rows, columns, squeeze=False)]


def _missing(part: xr.Dataset, name: str) -> dict[str, xr.DataArray]:
    """Return where a figure is missing, by the kinds of `HATCHES`."""
    none = part[name].isnull()
    return {"run failed": none & part.failed, "no figure": none & ~part.failed}


def _over_seeds(values: xr.DataArray) -> xr.DataArray:
    return values.mean("seed") if values.ndim > 1 and "seed" in values.dims else values


def _explain_colors(
    values: xr.DataArray, figure: Figure, row: Sequence[Axes], colors: Colormap, norm: Normalize
) -> None:
    from matplotlib.cm import ScalarMappable

    if is_flag(values) and "seed" not in values.dims:
        shades = [Patch(facecolor=NO, label="no"), Patch(facecolor=YES, label="yes")]
        row[-1].legend(
            handles=shades,
            title=label_of(values),
            loc="center left",
            bbox_to_anchor=(1.02, 0.5),
            fontsize="small",
            title_fontsize="small",
        )
        return
    below = "min" if float(values.min()) < (norm.vmin or 0.0) else "neither"
    bar = figure.colorbar(ScalarMappable(norm, colors), ax=list(row), extend=below)
    bar.set_label(label_of(values))


def _title(result: xr.Dataset, pick: dict[str, int]) -> str:
    parts = []
    for dim, index in pick.items():
        value = result[dim].values[index]
        is_number = isinstance(value, np.floating)
        parts.append(f"{dim} {value:g}" if is_number else str(value))
    return ", ".join(parts)
