"""The paper's figures, drawn from our data: `FIGURES[number].draw(experiment.data)`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, NamedTuple

import xarray as xr
from matplotlib.figure import Figure

from scara_drake.experiments.plots import simulated


class Picture(NamedTuple):
    """How a figure of the paper is drawn.

    Attributes:
        experiment: its name in EXPERIMENTS.
        draw: of its data.
        caption: what is seen, a sentence.
    """

    experiment: str
    draw: Callable[[xr.Dataset], Figure]
    caption: str


# By the number of the paper's figure. Those that are no curves (1 to 7) are not here.
FIGURES: Final[dict[int, Picture]] = {
    16: Picture("figures_16_17", simulated.figures_16_17, "The mast on its polynomial."),
    18: Picture("figures_18_19", simulated.figures_18_19, "Joints 2 and 4 on their sines."),
    20: Picture("figures_20_27", simulated.figures_20_27, "The tool and its error by cause."),
    29: Picture("figures_29_30", simulated.figures_29_30, "Joint 2 by ISMC and by SMC."),
}
