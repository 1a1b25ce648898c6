"""Every table, figure and numbered equation of the paper, and where each is here, as data.

The data are in the folder `index`, a file a kind. `ENTRIES` is all of them, in the paper's order.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from scara_drake.common import checks
from scara_drake.common.yaml_text import read_yaml

# What the paper numbers, and how many of each.
NUMBERED: Final = {"table": 12, "figure": 30, "equation": 53}
FOLDER: Final = Path(__file__).with_name("index")


@dataclass(frozen=True)
class Entry:
    """Some tables, figures or equations that belong together; often one.

    Attributes:
        kind: one of NUMBERED.
        numbers: theirs, rising.
        title: what it is.
        paper: what the paper states or shows, in our words.
        here: what is there in this project, and how it is read where the paper is silent.
        where: files, below `scara_drake/` or at the top of the project.
        test: that holds it, as "FILE::FUNCTION" below `tests/`.
        experiment: that judges it, of EXPERIMENTS; "" where none does.
        contradiction: why the paper cannot be right, with the numbers; "" where it can.
        pictures: shipped pictures that stand in the place of a drawing or a photograph.
    """

    kind: str
    numbers: tuple[int, ...]
    title: str
    paper: str
    here: str
    where: tuple[str, ...]
    test: str
    experiment: str = ""
    contradiction: str = ""
    pictures: tuple[str, ...] = ()

    @property
    def heading(self) -> str:
        """Such as "Table 8", "Figures 16 and 17" or "Equations 2 to 5"."""
        kind = self.kind.capitalize()
        if len(self.numbers) == 1:
            return f"{kind} {self.numbers[0]}"
        return f"{kind}s {runs(self.numbers)}"


def runs(numbers: tuple[int, ...]) -> str:
    """Return rising numbers in words: "16 and 17", "20, 21 and 23 to 27"."""
    parts: list[list[int]] = []
    for number in numbers:
        if parts and number == parts[-1][-1] + 1:
            parts[-1].append(number)
        else:
            parts.append([number])
    words = []
    for part in parts:
        words += [f"{part[0]} to {part[-1]}"] if len(part) > 2 else [str(each) for each in part]
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def read_entries(kind: str, text: str) -> list[Entry]:
    """Return the entries of a file of the index.

    Raises:
        ValueError: it is no list of maps with the fields of `Entry`.
    """
    fields = {field.name: field for field in dataclasses.fields(Entry) if field.name != "kind"}
    needed = {name for name, field in fields.items() if field.default is dataclasses.MISSING}
    entries = []
    for place, data in enumerate(read_yaml(text, f"{kind}s.yaml")):
        missing, unknown = needed - set(data), set(data) - set(fields)
        if missing or unknown:
            said = ", ".join(sorted(missing | unknown))
            raise ValueError(f"{kind}s.yaml[{place}]: {said}, allowed {', '.join(fields)}")
        values: dict[str, Any] = {
            name: tuple(value) if isinstance(value, list) else value for name, value in data.items()
        }
        for number in values["numbers"]:
            checks.number(f"{kind}s.yaml[{place}].numbers", number, 1, NUMBERED[kind])
        entries.append(Entry(kind=kind, **values))
    return entries


ENTRIES: Final = tuple(
    entry
    for kind in NUMBERED
    for entry in read_entries(kind, (FOLDER / f"{kind}s.yaml").read_text(encoding="utf-8"))
)
