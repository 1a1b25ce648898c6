"""Scenarios as YAML texts: any field within its bounds, and texts that were tampered with."""

import dataclasses
import math
import typing
from collections.abc import Iterator
from typing import Any

from hypothesis import strategies as st

from scara_drake.common.fields import KEY, Spec
from scara_drake.common.schema import alternatives
from scara_drake.scenario import Scenario

FAR = 1e4  # where a field has no bound


def fields_of(schema: type, path: str = "") -> Iterator[tuple[str, str, Spec]]:
    """Yield the dotted key, the tags on the way to it and the spec of every field below a schema.

    The tags are the settings that choose the kinds of parts, ";"-separated.
    """
    yield from _fields(schema, path, "")


def _fields(schema: type, path: str, tags: str) -> Iterator[tuple[str, str, Spec]]:
    hints = typing.get_type_hints(schema)
    for entry in dataclasses.fields(schema):
        where = f"{path}{entry.name}"
        if KEY in entry.metadata:
            yield where, tags, entry.metadata[KEY]
            continue
        for kind in alternatives(hints[entry.name]):
            if dataclasses.is_dataclass(kind) and isinstance(kind, type):
                tag = f"{where}=!{kind.__name__} {{}}"
                several = sum(map(dataclasses.is_dataclass, alternatives(hints[entry.name]))) > 1
                chosen = f"{tags};{tag}" if several else tags
                yield from _fields(kind, f"{where}.", chosen)


FIELDS = sorted(fields_of(Scenario))


def numbers(spec: Spec) -> st.SearchStrategy[float]:
    """Numbers within the bounds of a field, the bounds among them."""
    low = spec.low if math.isfinite(spec.low) else -FAR
    high = spec.high if math.isfinite(spec.high) else FAR
    if float(high) > high:  # a whole number that no float is
        high = math.nextafter(float(high), 0.0)
    return st.one_of(st.sampled_from([low, high]), st.floats(low, high))


def values(spec: Spec) -> st.SearchStrategy[Any]:
    """Values of a field: numbers, words, or lists of them."""
    one: st.SearchStrategy[Any] = st.sampled_from(spec.choices) if spec.choices else numbers(spec)
    if spec.width:
        return st.lists(st.lists(one, min_size=spec.width, max_size=spec.width), max_size=3)
    if spec.size == 0:
        return one
    most = 4 if spec.size is None else spec.size
    return st.lists(one, min_size=spec.size or 0, max_size=most)


@st.composite
def settings_within_bounds(draw: st.DrawFn, most: int = 3) -> dict[str, Any]:
    """Settings for `load_scenario`, each within the bounds of its field."""
    chosen: dict[str, Any] = {}
    for key, tags, spec in draw(st.lists(st.sampled_from(FIELDS), min_size=1, max_size=most)):
        for setting in filter(None, tags.split(";")):
            where, _, tag = setting.partition("=")
            chosen.setdefault(where, tag)
        chosen[key] = draw(values(spec))
    return chosen


def fields_in(part: Any, path: str = "") -> Iterator[tuple[str, Spec, Any]]:
    """Yield the dotted key, the spec and the value of every field of a scenario as it is."""
    for entry in dataclasses.fields(part):
        where, value = f"{path}{entry.name}", getattr(part, entry.name)
        if KEY in entry.metadata:
            yield where, entry.metadata[KEY], value
        elif dataclasses.is_dataclass(value):
            yield from fields_in(value, f"{where}.")
        elif isinstance(value, list):
            for index, one in enumerate(value):
                if dataclasses.is_dataclass(one):
                    yield from fields_in(one, f"{where}.{index}.")


def near(spec: Spec, value: Any) -> st.SearchStrategy[Any]:
    """Values of a field within a factor of two of one, and within its bounds."""
    if spec.choices:
        return st.sampled_from(spec.choices)
    if isinstance(value, list):
        if spec.size is None or spec.width:  # their order may matter
            return st.just(value)
        return st.tuples(*(near(Spec(low=spec.low, high=spec.high), one) for one in value)).map(
            list
        )
    if isinstance(value, int):
        return st.integers(int(max(spec.low, 0)), int(min(spec.high, 1000)))
    factors = st.floats(-1.0, 1.0).map(lambda power: 2.0**power)
    return factors.map(lambda factor: min(max(value * factor, spec.low), spec.high))


@st.composite
def settings_near(draw: st.DrawFn, scenario: Scenario, most: int = 8) -> dict[str, Any]:
    """Settings of what a scenario has, near the values that it has; its parts stay the same."""
    fields = st.sampled_from([field for field in fields_in(scenario) if field[0] != "duration"])
    return {
        key: draw(near(spec, value)) for key, spec, value in draw(st.lists(fields, max_size=most))
    }


NASTY = (
    "1" + "0" * 400, "-" + "9" * 5000, "1e999", ".nan", "-.inf", "0x" + "f" * 400, "1_0", "~", "''",
    "!", "! {}", "!! {}", "!Odd {}", "!Odd 3", "!!python/object:os.system {}", "!!binary aGk=",
    "!!float x", "!!set {a, b}", "2001-99-99", "2001-01-01", "{}", "[]", "[[[[[[]]]]]]", "{{}: 1}",
    "{_tag: !Pid {}}", "{_tag: ''}", "{a: 1, a: 2}", "{? [1, 2] : 3}", "&a [*a]", "*nothing",
    "\"\\u0007\\e[31mred\\n\"", "\"a]b\\\\c'd\"", "yes", "x" * 3000, "[" * 3000, "<<: 3",
    "!<> {}", "!<tag:yaml.org,2002:map> {}", "=", "[1, 2, 3, 4, 5, 6, 7]", "\x00", "é", "💣",
)  # fmt: skip


def bomb(levels: int) -> str:
    """A short text whose aliases write out to 10 ** levels entries."""
    nested = ["&a0 [x, x, x, x, x, x, x, x, x, x]"]
    nested += [f"&a{k} [{', '.join([f'*a{k - 1}'] * 10)}]" for k in range(1, levels)]
    return f"description: [{', '.join(nested)}]"


@st.composite
def tampered(draw: st.DrawFn, text: str) -> str:
    """A scenario's text with a value, a line or some characters of it changed."""
    lines = text.splitlines()
    at = draw(st.integers(0, len(lines) - 1))
    how = draw(st.sampled_from(["value", "double", "drop", "indent", "characters", "key"]))
    key, colon, rest = lines[at].partition(":")
    if how == "value":
        lines[at] = f"{key}{colon} {draw(st.sampled_from(NASTY))}"
    elif how == "double":
        lines.insert(at, lines[at])
    elif how == "drop":
        del lines[at]
    elif how == "indent":
        lines[at] = " " * draw(st.integers(0, 9)) + lines[at]
    elif how == "characters":
        place = draw(st.integers(0, len(lines[at])))
        lines[at] = lines[at][:place] + draw(st.text(max_size=4)) + lines[at][place:]
    else:
        lines[at] = f"{draw(st.sampled_from(NASTY))}: {rest}"
    return "\n".join(lines)
