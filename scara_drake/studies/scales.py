"""The axes and the colours of the picture of a study."""

from __future__ import annotations

from typing import Final, Literal

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, LinearSegmentedColormap, LogNorm, Normalize
from numpy.typing import NDArray

from scara_drake.display import look

Array = NDArray[np.float64]

WIDE: Final = 50.0  # largest over smallest, from which on a scale is logarithmic
WIDEST: Final = 1e6  # largest over smallest that has a colour of its own
NO, YES = look.VERDICTS[2], look.VERDICTS[0]


def is_flag(values: xr.DataArray) -> bool:
    """Whether a figure is yes or no."""
    return "flag_meanings" in values.attrs


def is_wide(values: xr.DataArray) -> bool:
    """Whether numbers are above zero and spread over decades."""
    low, high = float(values.min()), float(values.max())
    return bool(low > 0.0 and high > WIDE * low)


def is_even_in_log(coordinate: xr.DataArray) -> bool:
    """Whether the values of a coordinate are evenly spaced on a logarithmic axis."""
    values = coordinate.values
    if values.dtype.kind != "f" or values.size < 3 or values.min() <= 0.0:
        return False
    ratios = np.diff(np.log(np.sort(values)))
    return bool(np.ptp(ratios) < 0.01 * ratios.max() and values.max() > 2.0 * values.min())


def places_of(coordinate: xr.DataArray) -> Array:
    """Return where values stand on an axis: numbers where they are, words one after the other."""
    values = coordinate.values
    if values.dtype.kind in "fi":
        return np.asarray(values, dtype=np.float64)
    words = list(dict.fromkeys(values.tolist()))
    return np.array([words.index(value) for value in values.tolist()], dtype=np.float64)


def edges_of(coordinate: xr.DataArray) -> Array:
    """Return the edges of the cells around values, amid them."""
    places = places_of(coordinate)
    if is_even_in_log(coordinate):
        return np.asarray(np.exp(_amid(np.log(places))))
    return _amid(places)


def _amid(places: Array) -> Array:
    half = 0.5 * np.diff(places)
    middles = places[:-1] + half
    return np.concatenate([[places[0] - half[0]], middles, [places[-1] + half[-1]]])


def scale_axis(ax: Axes, coordinate: xr.DataArray, axis: Literal["x", "y"]) -> None:
    """Name an axis, and give it words where its values are words."""
    ax.set(**{f"{axis}label": _name(coordinate)})
    if coordinate.dtype.kind not in "fi":
        words = list(dict.fromkeys(map(str, coordinate.values)))
        ax.set(**{f"{axis}ticks": range(len(words)), f"{axis}ticklabels": words})
        ax.tick_params(axis=axis, labelsize="small", rotation=30 if axis == "x" else 0)
    elif is_even_in_log(coordinate):
        ax.set(**{f"{axis}scale": "log"})


def scale_values(ax: Axes, values: xr.DataArray) -> None:
    """Name the axis of a figure, and scale it as its numbers are spread."""
    ax.set_ylabel(label_of(values), fontsize="small")
    if is_flag(values):
        ax.set(yticks=(0.0, 1.0), yticklabels=("no", "yes"), ylim=(-0.1, 1.1))
    elif is_wide(values):
        ax.set_yscale("log")
    ax.grid(alpha=0.3)


def _name(values: xr.DataArray) -> str:
    units = values.attrs.get("units", "")
    return f"{values.name} [{units}]" if units not in ("", "1") else str(values.name)


def label_of(values: xr.DataArray) -> str:
    """Return the name of a figure with its unit."""
    return _name(values).replace("_", " ")


def colors_of(values: xr.DataArray) -> tuple[Colormap, Normalize]:
    """Return the colours of a figure, the same in all its panels."""
    import matplotlib as mpl

    if is_flag(values):
        return LinearSegmentedColormap.from_list("no_yes", [NO, YES]), Normalize(0.0, 1.0)
    above = values.where(values > 0.0)
    if float(values.min()) >= 0.0 and is_wide(above):
        low, high = float(above.min()), float(values.max())
        return mpl.colormaps["viridis"], LogNorm(max(low, high / WIDEST), high)
    low, high = float(values.min()), float(values.max())
    if not np.isfinite(low):  # there is none
        low, high = 0.0, 1.0
    return mpl.colormaps["viridis"], Normalize(low, high)
