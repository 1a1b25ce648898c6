"""Runs experiments side by side in processes, and draws the paper's figures from their data."""

from __future__ import annotations

import dataclasses
import functools
import io
import time
import traceback
import warnings
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import Final

import xarray as xr
from matplotlib.figure import Figure

from scara_drake.experiments import EXPERIMENTS, Experiment
from scara_drake.experiments.plots import EQUATIONS, FIGURES, TABLES
from scara_drake.reproduction.workers import Workers

# Begin before the others, in this order: a long one that begins last would run alone.
LONGEST: Final = (
    "couplings",
    "operators_under_delay",
    "displayed_impedance",
    "delay_against_loss",
    "table_7",
    "stability",
    "figures_29_30",
    "windup",
    "perturbation_observer",
    "figures_20_27",
    "figure_22",
    "table_10",
)
DOTS_PER_INCH: Final = 80
# Pictures by the numbers of what they belong to.
DRAWN: Final = {"table": TABLES, "figure": FIGURES, "equation": EQUATIONS}


@dataclass(frozen=True)
class Outcome:
    """What became of an experiment.

    Attributes:
        name: in EXPERIMENTS.
        experiment: without its data; None where it broke off.
        pictures: PNG, by what they belong to, such as "figure_16".
        error: why it, or a picture of it, broke off; one line.
        trace: where, for whoever mends it.
        seconds: how long it took.
        notes: its warnings.
    """

    name: str
    experiment: Experiment | None = None
    pictures: dict[str, bytes] = field(default_factory=dict)
    error: str = ""
    trace: str = ""
    seconds: float = 0.0
    notes: tuple[str, ...] = ()


def run_experiments(
    names: Iterable[str],
    seed: int,
    jobs: int,
    began: Callable[[str], None] = lambda name: None,
) -> Iterator[Outcome]:
    """Yield what became of each experiment as it ends, the longest begun first.

    Args:
        names: of EXPERIMENTS.
        seed: of all that is drawn.
        jobs: how many side by side.
        began: is told of each as it begins.
    """
    order = sorted(names, key=lambda name: (*LONGEST, name).index(name))
    with Workers(functools.partial(run_one, seed=seed), jobs) as workers:
        for name, outcome in workers.each(order, began):
            yield outcome or Outcome(name, error="its process ended")


def run_one(name: str, seed: int) -> Outcome:
    """Run an experiment and draw its figures; whatever it raises is told by the outcome."""
    begin = time.perf_counter()
    experiment: Experiment | None = None
    pictures: dict[str, bytes] = {}
    what, error, trace = "", "", ""
    with warnings.catch_warnings(record=True) as noted:
        warnings.simplefilter("default")
        try:
            experiment = EXPERIMENTS[name](seed=seed)
            for kind, drawn in DRAWN.items():
                for number, picture in drawn.items():
                    if picture.experiment == name:
                        what = f"{kind} {number}: "
                        pictures[f"{kind}_{number}"] = png(picture.draw(experiment.data))
        except Exception as raised:  # it goes on with the others, and is told by name
            error = what + (" ".join(str(raised).split()) or type(raised).__name__)
            trace = traceback.format_exc()
    return Outcome(
        name,
        experiment and dataclasses.replace(experiment, data=xr.Dataset()),  # may be large
        pictures,
        error,
        trace,
        time.perf_counter() - begin,
        tuple(dict.fromkeys(str(note.message) for note in noted)),
    )


def png(figure: Figure) -> bytes:
    """Return a picture as PNG, the same bytes for the same picture."""
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=DOTS_PER_INCH, metadata={"Software": None})
    return file.getvalue()
