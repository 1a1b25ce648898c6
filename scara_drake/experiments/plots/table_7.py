"""Picture of the search for Table 7: where the candidates lie, and how much each of them meets."""

from __future__ import annotations

from typing import Final

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from scara_drake.plotting import LAW

# Coefficient, its name in the paper, and what is drawn of it where that spreads more.
SHOWN: Final = {
    "inertia": "omega",
    "damping": "omega_d",
    "personal": "c1",
    "social": "c2",
    "speed": "v_max",
    "after": "iterations run on",
    "patience": "iterations of PSO-2",
}
LOGARITHMIC: Final = ("speed", "patience")


def table_7(data: xr.Dataset) -> Figure:
    """Draw each coefficient against the misfit, coloured by the statements met at once.

    The band holds 90 % of the posterior, the dashed line its median; the star is the best set.
    """
    figure = Figure(figsize=(13.0, 6.5), layout="constrained")
    axes = figure.subplots(2, 4).ravel()
    order = np.argsort(data.most_met.values, kind="stable")
    ran = order[data.distance.values[order] < data.sizes["statement"]]
    for ax, (name, symbol) in zip(axes, SHOWN.items(), strict=False):
        low, middle, high = data.posterior.sel(coefficient=name).values
        values = data.candidates.sel(coefficient=name).values
        if name in LOGARITHMIC:
            ax.set_xscale("log")
        ax.axvspan(low, high, color=LAW, alpha=0.15)
        ax.axvline(middle, color=LAW, linestyle="--", linewidth=1.0)
        points = ax.scatter(
            values[ran], data.distance.values[ran], c=data.most_met.values[ran], cmap="viridis",
            s=14, vmin=0, vmax=data.sizes["statement"],
        )  # fmt: skip
        ax.plot(values[0], data.distance.values[0], "*", color="crimson", markersize=13)
        ax.set_xlabel(symbol)
        ax.set_ylabel("misfit")
        ax.grid(alpha=0.25)
    axes[-1].axis("off")
    bar = figure.colorbar(points, ax=axes[-1], fraction=0.3)
    bar.set_label(f"statements that hold at once, of {data.sizes['statement']}")
    axes[-1].plot([], [], "*", color="crimson", markersize=13, label="best set")
    axes[-1].plot([], [], color=LAW, linestyle="--", label="median of the posterior")
    axes[-1].fill_between([], [], [], color=LAW, alpha=0.15, label="90 % of the posterior")
    axes[-1].legend(loc="center left", frameon=False)
    return figure
