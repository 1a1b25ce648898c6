"""What a scenario, a study, a verdict and a recording show of themselves in a notebook."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import xarray as xr

from scara_drake.common.fields import KEY
from scara_drake.common.html import Markup, card, chip, code, folded, line, put, table
from scara_drake.display import look

if TYPE_CHECKING:
    from scara_drake.metrics.judgement import Verdict
    from scara_drake.scenario import Scenario
    from scara_drake.studies.study import Study

_GOOD, _REMARK, _BAD, _ = look.VERDICTS
LONGEST: Final = 90  # letters of a value
FIRST: Final = ("name", "description", "duration", "seed")  # told in the title
# What a summary of a recording tells of its attributes, in this order.
TOLD: Final = {
    "ended_by": "ended by",
    "engine": "engine",
    "engine_reason": "why not compiled",
    "seed": "seed",
    "created": "made",
}


def of_scenario(scenario: Scenario) -> Markup:
    """Return the card of a scenario: what differs from the defaults, part by part; YAML, folded."""
    from scara_drake.scenario import dump_scenario

    usual = type(scenario)()
    parts = [
        _field(name, getattr(scenario, name), getattr(usual, name), _unit(scenario, name))
        for name in (field.name for field in dataclasses.fields(scenario))
        if name not in FIRST
    ]
    return card(
        f"Scenario {scenario.name}",
        line(scenario.description),
        line(f"{scenario.duration:g} s, seed {scenario.seed}; what differs from the defaults:"),
        *parts,
        folded("all fields as YAML", code(dump_scenario(scenario))),
    )


def _field(name: str, value: Any, usual: Any, unit: str) -> Markup:
    """Return a line of a field that differs, or what of a part does, folded; nothing if nothing."""
    if dataclasses.is_dataclass(value):
        return _part(name, value, usual)
    if value == usual:
        return Markup()
    if isinstance(value, list) and value and all(map(dataclasses.is_dataclass, value)):
        named = [
            (str(getattr(part, "name", "") or index), part) for index, part in enumerate(value)
        ]
        parts = [_part(called, part, None) for called, part in named]
        return folded(put(name), *parts, opened=True)
    return line(f"{name}: {shown(value)}{' ' + unit if unit else ''}")


def _part(name: str, part: Any, usual: Any) -> Markup:
    kind = type(part)
    same = type(usual) is kind
    default = usual if same else _default(kind)
    inner = [
        _field(field.name, value, getattr(default, field.name, None), _unit(part, field.name))
        for field in dataclasses.fields(part)
        if (value := getattr(part, field.name)) is not None
    ]
    title = put(name) if same else Markup(f"{put(name)}: <b>{put(kind.__name__)}</b>")
    if any(inner):
        return folded(title, *inner)
    return Markup() if same else line(title)


def _default(kind: type[Any]) -> Any:
    """Return a part with its defaults, or none where a part of the user's has not got them all."""
    try:
        return kind()
    except TypeError:
        return None


def _unit(part: Any, name: str) -> str:
    metadata: Mapping[str, Any] = type(part).__dataclass_fields__[name].metadata
    return str(metadata[KEY].unit) if KEY in metadata else ""


def shown(value: Any) -> str:
    """Return a value of a field in one short line."""
    if isinstance(value, float):
        return f"{value:g}"
    if isinstance(value, list | tuple):
        text = f"[{', '.join(map(shown, value))}]"
    elif isinstance(value, dict):
        text = f"{{{', '.join(f'{key}: {shown(each)}' for key, each in value.items())}}}"
    else:
        text = str(value)
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 1]}…"


def of_study(study: Study) -> Markup:
    """Return the card of a study: what is varied, how many runs, what is kept."""
    from scara_drake.studies.parameters import Normal, Range, Values

    def described(parameter: Any) -> str:
        if isinstance(parameter, Values):
            return shown(parameter.labels or parameter.values)
        if isinstance(parameter, Range):
            count = f", {parameter.count} points" if study.is_grid else ""
            return f"{parameter.low:g} to {parameter.high:g}{count}, {parameter.scale}"
        if isinstance(parameter, Normal):
            return f"{parameter.mean:g} ± {parameter.deviation:g}, normal"
        return str(parameter)

    rows = [(p.label, ", ".join(p.paths), described(p)) for p in study.parameters]
    facts = [
        ("scenario", study.scenario),
        ("runs", f"{_runs(study)}, {study.design.replace('_', ' ')}, seed {study.seed}"),
        ("metrics", ", ".join(study.metrics)),
        ("engine", study.engine),
    ]
    if study.overrides:
        facts.append(("overrides", shown(study.overrides)))
    return card(
        f"Study {study.name}",
        line(study.description),
        table(facts),
        table(rows, ["varied", "fields", "values"]),
    )


def _runs(study: Study) -> int:
    if not study.is_grid:
        return study.samples
    return int(np.prod([len(p.points()) for p in study.parameters], dtype=int)) * study.repeats


def of_verdict(verdict: Verdict) -> Markup:
    """Return the card of a verdict: followed or not, why, and what else has to be known."""
    return card("Verdict", *_judged(verdict))


def _judged(verdict: Verdict) -> Iterator[Markup]:
    if verdict.good:
        yield line(chip(str(verdict), _GOOD))
    for sentence in verdict.failures:
        yield line(chip("lost" if verdict.lost else "failed", _BAD), " ", sentence)
    for sentence in verdict.remarks:
        yield line(chip("remark", _REMARK), " ", sentence)


@dataclass(frozen=True)
class Summary:
    """A recording in short: what it is of, how it ended, its verdict, its figures.

    Attributes:
        title: of the run.
        facts: what is known of how it was made, by name.
        verdict: on it.
        figures: of its joints and its tool, (name, value, unit).
    """

    title: str
    facts: tuple[tuple[str, str], ...]
    verdict: Verdict
    figures: tuple[tuple[str, float, str], ...]

    def __str__(self) -> str:
        lines = [self.title, *(f"{name}: {value}" for name, value in self.facts)]
        lines += [f"verdict: {self.verdict}", *(f"note: {each}" for each in self.verdict.remarks)]
        lines += [f"{name}: {value:.4g} {unit}" for name, value, unit in self.figures]
        return "\n".join(lines)

    __repr__ = __str__

    def _repr_html_(self) -> str:
        rows = [(name, f"{value:.4g}", unit) for name, value, unit in self.figures]
        return card(
            self.title,
            *_judged(self.verdict),
            table(self.facts),
            folded("figures, after the first second", table(rows, ["figure", "value", "unit"])),
        )


def summary(recording: xr.Dataset) -> Summary:
    """Return a recording in short: how it ended, whether the arm followed, and its figures.

    Printed it is some lines of text, in a notebook a card; the recording itself lists variables.

    Raises:
        ValueError: the recording has no samples.
    """
    from scara_drake.metrics.curves import settled
    from scara_drake.metrics.figures import figures
    from scara_drake.metrics.judgement import verdict

    if not recording.sizes.get("time"):
        raise ValueError("recording: no samples, allowed one with samples")
    attributes, time = recording.attrs, recording.time.values
    title = f"Recording of {attributes.get('scenario_name', 'a run')}, {time[-1] - time[0]:.2f} s"
    facts = [(told, str(attributes[key])) for key, told in TOLD.items() if attributes.get(key)]
    facts.append(("samples", f"{time.size}, of {len(recording.data_vars)} variables"))
    found = figures(settled(recording)).values()
    kept = tuple((each.name, each.value, each.unit) for each in found if np.isfinite(each.value))
    return Summary(title, tuple(facts), verdict(recording), kept)
