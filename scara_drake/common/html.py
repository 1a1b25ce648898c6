"""Small pieces of HTML: what an object shows of itself in a notebook.

Text is escaped wherever it is put, unless it is `Markup` already. No piece sets the colour of a
text or of its background, but for `chip`, which sets both: so all are read on light and on dark.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from typing import Final

_LINE: Final = "1px solid rgba(128, 128, 128, .35)"
_CELL: Final = f"text-align:left;vertical-align:top;white-space:normal;border-bottom:{_LINE}"
_CARD: Final = f"border:{_LINE};border-radius:6px;padding:.6em .9em;margin:.3em 0;max-width:60em"
_CHIP: Final = "color:#000;padding:.1em .5em;border-radius:.8em;white-space:nowrap"


class Markup(str):
    """Text that is HTML, and is put as it is."""

    __slots__ = ()


def put(content: object) -> Markup:
    """Return a text as HTML; markup as it is."""
    return content if isinstance(content, Markup) else Markup(escape(str(content)))


def join(parts: Iterable[object], between: str = "") -> Markup:
    """Return pieces one after the other."""
    return Markup(between.join(put(part) for part in parts))


def card(title: object, *parts: object) -> Markup:
    """Return a frame with a title and whatever else it has."""
    return Markup(f'<div style="{_CARD}"><div><b>{put(title)}</b></div>{join(parts)}</div>')


def line(*parts: object) -> Markup:
    """Return pieces in a line of their own."""
    return Markup(f'<div style="margin:.25em 0">{join(parts)}</div>')


def chip(text: object, background: str) -> Markup:
    """Return a word in black on a light background, such as "#d9f2e6"."""
    return Markup(f'<span style="{_CHIP};background:{escape(background)}">{put(text)}</span>')


def code(text: object) -> Markup:
    """Return a text of several lines as it was typed."""
    style = "background:transparent;color:inherit;margin:.3em 0;overflow-x:auto"
    return Markup(f'<pre style="{style}">{put(text)}</pre>')


def table(rows: Iterable[Sequence[object]], head: Sequence[object] = ()) -> Markup:
    """Return rows of cells, whose lines wrap and begin on the left."""
    thead = f"<thead>{_row('th', head)}</thead>" if head else ""
    body = "".join(_row("td", row) for row in rows)
    style = "border-collapse:collapse;margin:.3em 0"
    return Markup(
        f'<div style="overflow-x:auto"><table style="{style}">{thead}<tbody>{body}</tbody>'
        "</table></div>"
    )


def _row(tag: str, cells: Iterable[object]) -> str:
    return "<tr>" + "".join(f'<{tag} style="{_CELL}">{put(c)}</{tag}>' for c in cells) + "</tr>"


def folded(title: object, *parts: object, opened: bool = False) -> Markup:
    """Return what opens at a click on its title."""
    state = " open" if opened else ""
    summary = f'<summary style="cursor:pointer">{put(title)}</summary>'
    inner = f'<div style="margin-left:1.2em">{join(parts)}</div>'
    return Markup(f"<details{state}>{summary}{inner}</details>")
