"""Writes docs/scenario.md: every field of a scenario, from the declarations themselves.

Run ``python docs/make_scenario_reference.py`` after a change to a part of a scenario.
"""

from __future__ import annotations

import dataclasses
import inspect
import math
import re
import typing
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from scara_drake.common.fields import ABOVE_ZERO, KEY, Spec
from scara_drake.common.schema import alternatives
from scara_drake.scenario import Scenario

PAGE = Path(__file__).with_name("scenario.md")
HEAD = """# Scenario fields

Every field that a scenario file may have, with its default, unit and bounds. This page is made by
`python docs/make_scenario_reference.py` from the declarations in the code. A part with several
kinds is chosen by its tag, `controller: !Pid {}`; without a tag it is the first. In a list of six,
the first number is that of the mast, in m, the others are those of the arm, in rad; where a unit
has two, "N | N m", they are for the mast and for the others. One number for a list sets all of it.
"""


def kinds_of(hint: Any) -> list[type]:
    """Return the parts that a field can hold, itself or in a list."""
    found: list[type] = []
    for kind in alternatives(hint):
        if typing.get_origin(kind) is list:
            found += kinds_of(typing.get_args(kind)[0])
        elif dataclasses.is_dataclass(kind) and isinstance(kind, type):
            found.append(kind)
    return found


def parts(schema: type, path: str = "") -> Iterator[tuple[str, type]]:
    """Yield each part below a schema with its path, depth first."""
    for name, hint in typing.get_type_hints(schema).items():
        for kind in kinds_of(hint):
            where = f"{path}{name}"
            yield where, kind
            yield from parts(kind, f"{where}.")


def meanings(part: type) -> dict[str, str]:
    """Return what the ``Attributes`` of a class, and of its bases, say of each field."""
    found: dict[str, str] = {}
    for base in reversed(part.__mro__):
        _, _, section = (inspect.cleandoc(base.__doc__ or "")).partition("Attributes:\n")
        for name, text in re.findall(r"^    (\w+): (.*(?:\n {5,}.*)*)", section, re.MULTILINE):
            found[name] = " ".join(text.split())
    return found


def allowed(spec: Spec) -> str:
    """Return the values that a field may have, in words."""
    if spec.choices:
        return ", ".join(f"`{word}`" for word in spec.choices)
    low, high = spec.low, spec.high
    if math.isinf(low) and math.isinf(high):
        return "any"
    if math.isinf(high):
        return "above 0" if low == ABOVE_ZERO else f"{low:g} or more"
    if low == ABOVE_ZERO:
        return f"above 0, up to {high:g}"
    return f"{low:g} to {high:g}"


def written(value: Any) -> str:
    """Return a default as one writes it in YAML."""
    if value is None:
        return "none"
    if dataclasses.is_dataclass(value):
        return f"`!{type(value).__name__}`"
    if isinstance(value, list):
        if value and dataclasses.is_dataclass(value[0]):
            return ", ".join(written(entry) for entry in value)
        entries = [_row(entry) if isinstance(entry, list) else written(entry) for entry in value]
        one = len(set(entries)) == 1 and not isinstance(value[0], list)
        return entries[0] if one else f"[{', '.join(entries)}]"
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.6g}" if isinstance(value, float | int) else (f'"{value}"')


def _row(values: list[float]) -> str:
    return f"[{', '.join(map(written, values))}]"


def rows(part: type) -> Iterator[str]:
    """Yield the lines of the table of a part."""
    defaults, told = part(), meanings(part)
    for entry in dataclasses.fields(part):
        spec = entry.metadata.get(KEY, Spec())
        bounds = allowed(spec) if KEY in entry.metadata else ""
        source = f"{spec.symbol} {spec.equation}".strip()
        cells = [f"`{entry.name}`", written(getattr(defaults, entry.name)), spec.unit, bounds]
        cells += [source, told.get(entry.name, "")]
        yield f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"


def page() -> str:
    """Return the whole page."""
    places: dict[type, list[str]] = {Scenario: ["the top of the file"]}
    for where, part in parts(Scenario):
        places.setdefault(part, []).append(f"`{where}`")
    text = [HEAD]
    for part, found in places.items():
        summary = inspect.cleandoc(part.__doc__ or "").partition("\n\n")[0].replace("\n", " ")
        text.append(f"## {part.__name__}\n")
        text.append(f"{summary} Stands at {', '.join(dict.fromkeys(found))}.\n")
        if dataclasses.fields(part):
            text.append("| field | default | unit | allowed | symbol | meaning |")
            text.append("|---|---|---|---|---|---|")
            text += rows(part)
        text.append("")
    return "\n".join(text)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
