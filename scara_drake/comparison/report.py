"""A comparison as tables on the terminal."""

from __future__ import annotations

import io
from collections.abc import Iterator
from typing import Any, Final

import numpy as np
from rich.console import Console, Group, RenderableType
from rich.table import Table
from rich.text import Text

from scara_drake.comparison.comparison import Comparison
from scara_drake.comparison.differences import Difference

NOTHING: Final = "-"  # what a recording does not have
VARIABLE_HEAD: Final = ("variable", "relative difference", "there", "first", "")
WORTH_TELLING: Final = 5e-4  # of the first one's value: less is told as "~"


def report(comparison: Comparison) -> RenderableType:
    """Return the tables: scenarios, figures, variables, verdicts."""
    return Group(*_parts(comparison))


def as_text(comparison: Comparison) -> str:
    """Return the tables as plain text."""
    file = io.StringIO()
    Console(file=file, width=120).print(report(comparison))
    return file.getvalue().rstrip()


def _parts(comparison: Comparison) -> Iterator[RenderableType]:
    if len(comparison.scenario):
        table = _table("What differs in how they were made", "field", comparison.names)
        for name, row in comparison.scenario.iterrows():
            table.add_row(str(name), *(Text(value) for value in row))
        yield table
    table = _table(figures_title(comparison), "figure", comparison.names)
    for name, row in comparison.figures.iterrows():
        values = [float(row[each]) for each in comparison.names]
        table.add_row(f"{name} [{row.unit}]".replace("[", r"\["), *figure_cells(values))
    yield table
    for name, variables in comparison.variables.items():
        yield from _variables(comparison, name, variables)
    for name, sentence in comparison.verdicts.items():
        yield Text(f"Verdict on {name}: {sentence}.")
    for remark in comparison.remarks:
        yield Text(f"Note: {remark}.")
    for sentence in equality(comparison):
        yield Text(f"{sentence}.")


def figures_title(comparison: Comparison) -> str:
    """Say which time the figures are of."""
    first = comparison.names[0]
    return f"{comparison.start:.6g} s to {comparison.end:.6g} s, in brackets against {first}"


def variables_title(comparison: Comparison, name: str) -> str:
    """Say which recordings' variables are compared."""
    return f"Variables of {name} against {comparison.names[0]}, at the times that both have"


def figure_cells(values: list[float]) -> list[str]:
    """Write the values of a figure, the first plain, the others with how they differ from it."""
    cells = [number(values[0])]
    for value in values[1:]:
        change = change_of(values[0], value)
        cells.append(f"{number(value)} ({change})" if change else number(value))
    return cells


def change_of(first: float, value: float) -> str:
    """Say how a value differs from the first; "" where one of them is missing."""
    if not (np.isfinite(first) and np.isfinite(value)):
        return ""
    if value == first:
        return "="
    if first == 0.0:
        return "not 0"
    ratio = value / first
    if abs(ratio - 1.0) < WORTH_TELLING:
        return "~"
    return f"{100.0 * (ratio - 1.0):+.1f} %" if 0.0 < ratio < 10.0 else f"x {ratio:.3g}"


def number(value: float) -> str:
    """Write a value of a figure."""
    if not np.isfinite(value):
        return NOTHING
    return f"{value:.4g}" if abs(value) < 1e4 else f"{value:.0f}"


def variable_cells(difference: Difference) -> list[str]:
    """Write the largest relative difference of a variable, where it is, and when the first is."""
    if not np.isfinite(difference.relative) and not difference.where:
        return [NOTHING, "", "", difference.remark]
    if not difference.where:
        return ["equal", "", "", difference.remark]
    relative = "no number" if np.isinf(difference.largest) else f"{difference.relative:.2g}"
    return [relative, difference.where, f"{difference.first:.6g} s", difference.remark]


def equality(comparison: Comparison) -> list[str]:
    """Say of each other recording whether it is equal to the first, to the bit."""
    if comparison.equal:
        return ["Equal to the bit: all variables at all times"]
    return [
        f"{name} against {comparison.names[0]}: {_agreement(variables)}"
        for name, variables in comparison.variables.items()
    ]


def _agreement(variables: list[Difference]) -> str:
    equal = sum(difference.equal for difference in variables)
    worst = max((d.relative for d in variables if np.isfinite(d.relative)), default=0.0)
    told = f"; largest relative difference {worst:.2g}" if worst > 0.0 else ""
    which = "all" if equal == len(variables) else f"{equal} of"
    return f"{which} {len(variables)} variables equal to the bit at the times that both have{told}"


def _variables(comparison: Comparison, name: str, variables: list[Difference]) -> Iterator[Any]:
    title = variables_title(comparison, name)
    different = [difference for difference in variables if not difference.equal]
    if different:
        table = Table(title=title, title_justify="left")
        remarked = any(difference.remark for difference in different)
        for column in VARIABLE_HEAD[: None if remarked else -1]:
            table.add_column(column)
        for difference in different:
            cells = [difference.name, *variable_cells(difference)]
            table.add_row(*map(Text, cells[: len(table.columns)]))
        yield table
    equal = [difference.name for difference in variables if difference.equal]
    yield Text(f"Equal in {name} and {comparison.names[0]}: {', '.join(equal) or 'nothing'}.")


def _table(title: str, what: str, names: tuple[str, ...]) -> Table:
    table = Table(title=title, title_justify="left")
    table.add_column(what)
    for name in names:
        table.add_column(Text(name), justify="right")
    return table
