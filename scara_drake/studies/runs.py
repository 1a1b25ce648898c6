"""A study unfolded: its runs by number, each with its values and its seed.

What a run is depends on the study and its number alone, so it is the same wherever it runs.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from scara_drake.diagram import make_diagram
from scara_drake.recordings.labels import labelled
from scara_drake.scenario import Scenario, load_scenario, read_scenario
from scara_drake.simulation.steppers import COMPILED, why_not_compiled
from scara_drake.studies.parameters import shown_as, unit_of
from scara_drake.studies.study import Study, check_study

Array = NDArray[np.float64]


class Runs:
    """The runs of a study.

    Attributes:
        study: that it is.
        dims: sizes by name: those of a grid are its parameters, and `seed` where it has several;
            runs that are drawn are along `run`.
    """

    def __init__(self, study: Study) -> None:
        """Unfold a study.

        Raises:
            ValueError: a value of the study is out of its bounds.
        """
        check_study(study)
        self.study = study
        self.dims: dict[str, int]
        if study.is_grid:
            self._points = [parameter.points() for parameter in study.parameters]
            names = [parameter.label for parameter in study.parameters]
            self.dims = dict(zip(names, map(len, self._points), strict=True))
            if study.repeats > 1:
                self.dims["seed"] = study.repeats
        else:
            self._shares = shares(study)
            self.dims = {"run": study.samples}

    def __len__(self) -> int:
        return int(np.prod(list(self.dims.values())))

    def values(self, number: int) -> dict[str, Any]:
        """Return the values of the parameters of a run, by their names."""
        parameters = self.study.parameters
        if self.study.is_grid:
            places = np.unravel_index(number, tuple(self.dims.values()))
            rows = zip(parameters, self._points, places, strict=False)
            return {parameter.label: points[place] for parameter, points, place in rows}
        rows_drawn = zip(parameters, self._shares[number], strict=True)
        return {parameter.label: parameter.at(float(share)) for parameter, share in rows_drawn}

    def seed(self, number: int) -> int:
        """Return the seed of a run's scenario."""
        return self.study.seed + (number % self.study.repeats if self.study.is_grid else number)

    def scenario(self, number: int) -> Scenario:
        """Return the scenario of a run.

        Raises:
            ValueError: its values are not allowed together.
        """
        return read_scenario(*self._source(self.values(number), self.seed(number)))[0]

    def check(self) -> Scenario:
        """Accept parameters of which each value, beside the first ones of the others, is allowed.

        What is refused only in some combinations is found when these are run.

        Returns:
            The scenario of the first values.

        Raises:
            ValueError: an unknown path, or a value out of its bounds.
        """
        outermost = [parameter.outermost() for parameter in self.study.parameters]
        names = [parameter.label for parameter in self.study.parameters]
        first = {name: values[0] for name, values in zip(names, outermost, strict=True)}
        scenario = load_scenario(*self._source(first, self.study.seed))
        for name, values in zip(names, outermost, strict=True):
            for value in values[1:]:
                read_scenario(*self._source(first | {name: value}, self.study.seed))
        if self.study.engine == COMPILED:
            reason = why_not_compiled(make_diagram(scenario), scenario)
            if reason:
                raise ValueError(f"engine: {reason}, allowed auto, drake")
        return scenario

    def coordinates(self, scenario: Scenario) -> dict[str, xr.Variable]:
        """Return the coordinates of the result; the units are those of the fields of a scenario."""
        found: dict[str, xr.Variable] = {}
        numbers = range(len(self))
        for index, parameter in enumerate(self.study.parameters):
            if self.study.is_grid:
                dim, values = parameter.label, self._points[index]
            else:
                dim = "run"
                values = [parameter.at(float(share)) for share in self._shares[:, index]]
            shown = [shown_as(parameter, value) for value in values]
            unit = unit_of(scenario, parameter.paths[0])
            found[parameter.label] = labelled((dim,), shown, unit, ", ".join(parameter.paths))
        if "run" in self.dims:
            found["run"] = labelled(("run",), list(numbers), "1", "number of the run")
            found["seed"] = labelled(("run",), [*map(self.seed, numbers)], "1", "seed of the run")
        elif "seed" in self.dims:
            seeds = [self.seed(number) for number in range(self.study.repeats)]
            found["seed"] = labelled(("seed",), seeds, "1", "seed of the run")
        return found

    def _source(self, values: dict[str, Any], seed: int) -> tuple[str, dict[str, Any]]:
        """Return the scenario's name, and what is set in it."""
        study = self.study
        overrides = dict(study.overrides)
        if study.duration is not None:
            overrides["duration"] = study.duration
        for parameter in study.parameters:
            for path in parameter.paths:
                overrides[path] = values[parameter.label]
        return study.scenario, overrides | {"seed": seed}


def shares(study: Study) -> Array:
    """Return where each sample is in each parameter's draws (sample, parameter), within [0, 1)."""
    shape = (study.samples, len(study.parameters))
    if study.design == "random" or not study.parameters:
        return np.random.default_rng(study.seed).random(shape)
    from scipy.stats import qmc  # takes a while to import

    return qmc.LatinHypercube(shape[1], rng=study.seed).random(shape[0])
