"""A study as data: a scenario, what is varied in it, and the figures that are kept of each run."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from scara_drake.common import checks
from scara_drake.common.checks import shown
from scara_drake.common.fields import check, choice, number
from scara_drake.common.resources import resource
from scara_drake.common.schema import build
from scara_drake.common.yaml_text import read_yaml
from scara_drake.simulation.steppers import ENGINES
from scara_drake.studies.figures import METRICS
from scara_drake.studies.parameters import Normal, Range, Values

DESIGNS: Final = ("grid", "random", "latin_hypercube")
MOST_RUNS: Final = 1_000_000
# Names in the result that are not of parameters.
TAKEN: Final = ("run", "seed", "failed", "ended_by", "missing", "engine")


@dataclass
class Study:
    """A scenario run many times over.

    Attributes:
        name: of the study; that of the file if empty.
        description: one line.
        scenario: name of a shipped one, or path of a YAML file.
        overrides: dotted keys to values, for all runs.
        duration: of a run [s]; the scenario's if empty.
        parameters: what is varied.
        design: every combination (grid), draws (random), or draws of which each of as many equal
            shares of every parameter has one (latin_hypercube).
        samples: how many runs are drawn; of no use in a grid.
        repeats: how often each point of a grid is run, with one seed after the other.
        seed: of the draws and of the first run. In a grid all points have the same seeds, so they
            meet the same noise; a run that is drawn has the seed `seed` + its number.
        metrics: figures that are kept, by their names in `METRICS`.
        after: the figures count from here on [s], but for those of a whole run.
        engine: "auto", "drake" or "compiled", see `simulate`.
    """

    name: str = ""
    description: str = ""
    scenario: str = "teleoperation"
    overrides: dict[str, Any] = field(default_factory=dict)
    duration: float | None = None
    parameters: list[Values | Range | Normal] = field(default_factory=list)
    design: str = choice("grid", DESIGNS)
    samples: int = number(100, "", 1, MOST_RUNS)
    repeats: int = number(1, "", 1, MOST_RUNS)
    seed: int = number(0, "", 0, 2**62)
    metrics: list[str] = field(default_factory=list)
    after: float = number(0.0, "s", 0.0, 86400.0)
    engine: str = choice("auto", ENGINES)

    @property
    def is_grid(self) -> bool:
        """Whether it runs every combination."""
        return self.design == "grid"

    def check_together(self, name: str) -> None:
        """Check the metrics, the names, and that there is something to vary, and not too much.

        Raises:
            ValueError: one line that names the field, its value and what is allowed.
        """
        if not isinstance(self.overrides, dict):
            raise ValueError(f"overrides: {shown(self.overrides)}, allowed dotted keys to values")
        if self.name:
            checks.word("name", self.name)
        if not self.metrics:
            raise ValueError(f"metrics: 0 entries, allowed 1 or more of {', '.join(METRICS)}")
        for metric in self.metrics:
            if metric not in METRICS:
                raise ValueError(
                    f"metrics: {shown(metric)}, allowed {', '.join(METRICS)}"
                    f"{checks.nearest(metric, METRICS)}"
                )
        _check_once("metrics", self.metrics)
        self._check_names()
        self._check_size()

    def _repr_html_(self) -> str:
        from scara_drake.display.cards import of_study

        return of_study(self)

    def _check_names(self) -> None:
        labels = [parameter.label for parameter in self.parameters]
        _check_once("parameters", labels)
        for label in labels:
            checks.word("parameters.name", label)
            if label in (*TAKEN, *METRICS):
                raise ValueError(f"parameters: name '{label}', allowed another: this one is taken")
        paths = [path for parameter in self.parameters for path in parameter.paths]
        _check_once("parameters.paths", paths)
        for path, instead in (("seed", "seed and repeats"), ("duration", "duration")):
            if path in self.overrides or (path in paths and path == "seed"):
                raise ValueError(f"{path}: a field to set, allowed by the study's {instead}")

    def _check_size(self) -> None:
        if not self.is_grid:
            if self.repeats != 1:
                raise ValueError(
                    f"repeats: {self.repeats}, allowed 1 where runs are drawn: samples"
                )
            if not self.parameters and self.samples == 1:
                raise ValueError("parameters: 0 entries, allowed 1 or more, or samples above 1")
            return
        if not self.parameters and self.repeats == 1:
            raise ValueError("parameters: 0 entries, allowed 1 or more, or repeats above 1")
        runs = self.repeats * math.prod(len(p.points()) for p in self.parameters)
        checks.number("parameters: runs of the grid", runs, 1, MOST_RUNS)


def study_names() -> list[str]:
    """Return the names of the shipped studies."""
    return sorted(path.stem for path in resource("diagrams", "studies").glob("*.yaml"))


def load_study(name_or_path: str | Path) -> Study:
    """Load a study by the name of a shipped one or by the path of a YAML file, and check it.

    A scenario that it names by a path is looked for from the study's folder.

    Raises:
        ValueError: no such study, unknown key, wrong type, or a value out of its bounds.
    """
    path = Path(name_or_path)
    if path.suffix in (".yaml", ".yml"):
        if not path.is_file():
            raise ValueError(f"study: {shown(str(path))}, allowed a YAML file that exists")
    else:
        checks.choice("study", str(name_or_path), study_names())
        path = resource("diagrams", "studies", f"{name_or_path}.yaml")
    file = shown(path.name, quotes=False)
    try:
        data = read_yaml(path.read_text(encoding="utf-8"), file)
    except (OSError, UnicodeDecodeError) as error:
        raise ValueError(f"{file}: {shown(error, 160)}, allowed a text in UTF-8") from None
    if not isinstance(data, dict):
        raise ValueError(f"{file}: {type(data).__name__}, allowed a map of a study's fields")
    study = build(Study, data)
    study.name = study.name or re.sub(r"[^\w.,+=()-]|^\W", "_", path.stem)[:100]
    if Path(study.scenario).suffix:
        study.scenario = str(path.parent / study.scenario)
    check_study(study)
    return study


def check_study(study: Study) -> None:
    """Check every field against its bounds, and the rules between them.

    Raises:
        ValueError: one line that names the field, its value and what is allowed.
    """
    check(study, "")


def _check_once(name: str, words: list[str]) -> None:
    for word in words:
        if words.count(word) > 1:
            raise ValueError(f"{name}: '{word}' twice, allowed each once")
