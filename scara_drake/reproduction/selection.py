"""What `--only` asks for: tables, figures, equations and experiments by their names."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable
from dataclasses import dataclass

from scara_drake.common.checks import nearest, shown
from scara_drake.reproduction.index import ENTRIES, NUMBERED, Entry


@dataclass(frozen=True)
class Selection:
    """What is to be reproduced.

    Attributes:
        entries: of the index, in its order.
        experiments: to be run, in the order of EXPERIMENTS.
    """

    entries: tuple[Entry, ...]
    experiments: tuple[str, ...]


def select(names: Iterable[str], known: Collection[str]) -> Selection:
    """Return what some names ask for; everything if there is none.

    Args:
        names: such as "table_10", "figures_16_17" (16 to 17), "equation_47" or "stability".
        known: the names of the experiments.

    Raises:
        ValueError: a name is unknown.
    """
    wanted, chosen = list(names), set[str]()
    entries: list[Entry] = []
    for name in wanted:
        numbered = _numbered(name)
        if numbered:
            entries += numbered
        elif name in known:
            chosen.add(name)
            entries += [entry for entry in ENTRIES if experiment_of(entry, known) == name]
        else:
            raise ValueError(
                f"--only: {shown(name)}, allowed table_1 to table_12, figure_1 to figure_30, "
                f"equation_1 to equation_53, figures_16_17 and the like, {', '.join(known)}"
                f"{nearest(name, known)}"
            )
    if not wanted:
        return Selection(ENTRIES, tuple(known))
    chosen |= {experiment_of(entry, known) for entry in entries}
    kept = tuple(entry for entry in ENTRIES if entry in entries)
    return Selection(kept, tuple(name for name in known if name in chosen))


def experiment_of(entry: Entry, known: Collection[str]) -> str:
    """Return the experiment that judges an entry: the named one, else the one with its numbers."""
    if entry.experiment:
        return entry.experiment
    first, last = entry.numbers[0], entry.numbers[-1]
    name = f"{entry.kind}_{first}" if first == last else f"{entry.kind}s_{first}_{last}"
    return name if name in known else ""


def _numbered(name: str) -> list[Entry]:
    """Return the entries with the numbers of such a name; none if it has another form."""
    found = re.fullmatch(rf"({'|'.join(NUMBERED)})s?_(\d{{1,3}})(?:_(\d{{1,3}}))?", name)
    if not found:
        return []
    kind, first, last = found[1], int(found[2]), int(found[3] or found[2])
    if not 1 <= first <= last <= NUMBERED[kind]:
        return []
    numbers = set(range(first, last + 1))
    return [entry for entry in ENTRIES if entry.kind == kind and numbers & set(entry.numbers)]
