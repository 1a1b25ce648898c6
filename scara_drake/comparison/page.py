"""A comparison as one page that needs no network."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterator
from html import escape
from pathlib import Path
from typing import Final

from matplotlib.figure import Figure

from scara_drake.common.files import write_whole
from scara_drake.comparison import report
from scara_drake.comparison.comparison import Comparison
from scara_drake.comparison.plots import pictures

DOTS_PER_INCH: Final = 130
STYLE: Final = """
body { font: 15px/1.45 system-ui, sans-serif; color: #222; max-width: 1100px; margin: 2em auto;
       padding: 0 1em; }
h1 { font-size: 1.5em; } h2 { font-size: 1.15em; margin: 2em 0 .5em; }
table { border-collapse: collapse; font-size: 13px; }
th, td { padding: .2em .8em; border-bottom: 1px solid #ddd; text-align: right; }
th:first-child, td:first-child { text-align: left; }
thead th { border-bottom: 2px solid #888; }
.words td { text-align: left; } .scroll { overflow-x: auto; }
img { width: 100%; } .missing { color: #666; font-size: 13px; }
"""


def save_page(comparison: Comparison, path: str | Path) -> None:
    """Write the page, whole or not at all; its folder is made if need be.

    Raises:
        ValueError: the name does not end in .html.
        OSError: the page cannot be written.
    """
    target = Path(path)
    if target.suffix != ".html":
        raise ValueError(f"html: '{target}', allowed a file that ends in .html")
    text = page(comparison)
    target.parent.mkdir(parents=True, exist_ok=True)
    write_whole(target, text)


def page(comparison: Comparison) -> str:
    """Return the page: what differs, the curves, the tables."""
    title = escape(" · ".join(comparison.names))
    body = "".join([f"<h1>{title}</h1>", _summary(comparison), *_plots(comparison)])
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{title}</title>'
        f"<style>{STYLE}</style></head><body>{body}{tables(comparison)}</body></html>\n"
    )


def tables(comparison: Comparison) -> str:
    """Return the tables of a comparison as HTML."""
    parts = []
    if len(comparison.scenario):
        rows = [[str(name), *row] for name, row in comparison.scenario.iterrows()]
        parts.append("<h2>What differs in how they were made</h2>")
        parts.append(table(["field", *comparison.names], rows, "words"))
    rows = [
        [
            f"{name} [{row.unit}]",
            *report.figure_cells([float(row[each]) for each in comparison.names]),
        ]
        for name, row in comparison.figures.iterrows()
    ]
    parts.append(f"<h2>Figures: {escape(report.figures_title(comparison))}</h2>")
    parts.append(table(["figure", *comparison.names], rows))
    for name, variables in comparison.variables.items():
        parts.append(f"<h2>{escape(report.variables_title(comparison, name))}</h2>")
        rows = [[each.name, *report.variable_cells(each)] for each in variables]
        parts.append(table([*report.VARIABLE_HEAD], rows, "words"))
    return "".join(parts)


def _summary(comparison: Comparison) -> str:
    sentences = [
        *report.equality(comparison),
        *(f"Verdict on {name}: {said}" for name, said in comparison.verdicts.items()),
        *(f"Note: {remark}" for remark in comparison.remarks),
    ]
    return "<ul>" + "".join(f"<li>{escape(each)}.</li>" for each in sentences) + "</ul>"


def _plots(comparison: Comparison) -> Iterator[str]:
    for title, figure, missing in pictures(comparison.names, comparison.recordings):
        said = f'<p class="missing">{escape("; ".join(missing))}.</p>' if missing else ""
        yield f"<h2>{escape(title)}</h2>{image(figure, title)}{said}"


def image(figure: Figure, title: str) -> str:
    """Return a figure as HTML that holds it."""
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=DOTS_PER_INCH)
    data = base64.b64encode(file.getvalue()).decode()
    return f'<img alt="{escape(title)}" src="data:image/png;base64,{data}">'


def table(head: list[str], rows: list[list[str]], kind: str = "") -> str:
    """Return a table as HTML, its cells escaped."""
    titles = "".join(f"<th>{escape(each)}</th>" for each in head)
    lines = "".join(
        "<tr>" + "".join(f"<td>{escape(str(cell))}</td>" for cell in row) + "</tr>" for row in rows
    )
    return (
        f'<div class="scroll"><table class="{kind}"><thead><tr>{titles}</tr></thead>'
        f"<tbody>{lines}</tbody></table></div>"
    )
