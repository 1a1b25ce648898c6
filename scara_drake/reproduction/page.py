"""The report as one page that needs no network, with its pictures in it."""

from __future__ import annotations

import base64
from collections.abc import Iterator, Sequence
from html import escape
from pathlib import Path
from typing import Final

from scara_drake.common.files import write_whole
from scara_drake.experiments import NOT_COMPARABLE, NOT_REPRODUCED, VERDICTS, report
from scara_drake.experiments.reading import OpenQuestion
from scara_drake.reproduction.contents import (
    DIFFERENT,
    INTRODUCTION,
    TITLE,
    Contents,
    Image,
    Section,
    counts_table,
    slug,
    told_counts,
    versions,
)
from scara_drake.reproduction.run import Outcome

STYLE: Final = Path(__file__).with_name("page.css")
TYPES: Final = {".png": "image/png", ".svg": "image/svg+xml"}
ALL: Final = "all"  # the filter that hides nothing


def save_page(found: Contents, folder: Path) -> Path:
    """Write the page into a folder, whole or not at all; return its path.

    Raises:
        OSError: it cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "reproduction.html"
    write_whole(path, page(found))
    return path


def page(found: Contents) -> str:
    """Return the page."""
    parts = [
        f"<h1>{TITLE}</h1>",
        f"<p>{_emphasis(INTRODUCTION)}</p>",
        _table(*counts_table(found), "stacked"),
    ]
    parts += [*_failures(found), _table_of_contents(found), _filter()]
    for chapter, sections in found.chapters.items():
        parts.append(f"<h2>{escape(chapter)}</h2>")
        for section in sections:
            parts += ["".join(_section(section))]
    made = escape(versions(found.seed))
    parts.append(f'<p class="quiet">Made by <code>scara-drake reproduce</code> with {made}.</p>')
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{TITLE}</title><style>{STYLE.read_text(encoding='utf-8')}{_hiding()}</style></head>"
        f"<body>{''.join(parts)}</body></html>\n"
    )


def _emphasis(text: str) -> str:
    """Return a text with *emphasis* as HTML."""
    pieces = escape(text).split("*")
    return "".join(f"<em>{p}</em>" if i % 2 else p for i, p in enumerate(pieces))


def _failures(found: Contents) -> Iterator[str]:
    for outcome in found.failed:
        yield f'<p class="broke">Broke off: {escape(outcome.name)}: {escape(outcome.error)}</p>'
    if found.differences:
        lines = "".join(f"<li>{escape(str(each))}</li>" for each in found.differences)
        yield f'<p class="broke">{DIFFERENT}</p>'
        yield f"<ul>{lines}</ul>"


def _table_of_contents(found: Contents) -> str:
    lines = []
    for chapter, sections in found.chapters.items():
        chips = [
            (number, section)
            for section in sections
            for number in (section.entry.numbers if section.entry else (section.heading,))
        ]
        links = "".join(
            f'<a class="chip {_worst(section)}" href="#{section.anchor}" '
            f'title="{escape(section.title)}">{escape(str(number))}</a>'
            for number, section in sorted(chips, key=_by_number)
        )
        lines.append(f"<p>{escape(chapter)} {links}</p>")
    told = "Coloured by the worst verdict on them; grey ones have none of their own."
    return f'<nav>{"".join(lines)}<p class="quiet">{told}</p></nav>'


def _by_number(chip: tuple[int | str, Section]) -> tuple[int, str]:
    number, _ = chip
    return (number, "") if isinstance(number, int) else (0, "")


def _worst(section: Section) -> str:
    """Return the class of the worst verdict of what is told in a section."""
    if not section.outcome:
        return ""
    found = [verdict for verdict in VERDICTS[:-1] if section.counts.get(verdict)]
    return slug(found[-1] if found else NOT_COMPARABLE) if section.counts else slug(NOT_REPRODUCED)


def _filter() -> str:
    choices = "".join(
        f'<label><input type="radio" name="verdict" value="{slug(each)}"'
        f"{' checked' if each == ALL else ''}> {each}</label>"
        for each in (ALL, *VERDICTS)
    )
    return f'<fieldset class="filter"><legend>Show claims that are</legend>{choices}</fieldset>'


def _hiding() -> str:
    """Return the style that hides the claims of other verdicts than the chosen one."""
    rules = []
    for verdict in map(slug, VERDICTS):
        chosen = f'body:has(input[value="{verdict}"]:checked)'
        rules.append(f"{chosen} .claim:not(.{verdict}), ")
        rules.append(f"{chosen} section:not(:has(.claim.{verdict})) {{ display: none; }}\n")
    return "".join(rules)


def _section(section: Section) -> Iterator[str]:
    outcome, entry = section.outcome, section.entry
    seconds = f'<span class="seconds">{outcome.seconds:.1f} s</span>' if outcome else ""
    yield f'<section id="{section.anchor}"><h3>{seconds}{escape(section.heading)} '
    yield f'<span class="title">{escape(section.title)}</span></h3>'
    if entry:
        where = ", ".join(f"<code>{escape(path)}</code>" for path in entry.where)
        rows = [("The paper", escape(entry.paper)), ("Here", escape(entry.here))]
        if entry.contradiction:
            told = f'<div class="against">{escape(entry.contradiction)}</div>'
            rows.append(("The paper cannot be right", told))
        rows.append(("Where", f"{where}; test <code>{escape(entry.test)}</code>"))
        if section.told:
            link = f'<a href="#{slug(section.told)}">{escape(section.told)}</a>'
            rows.append(("Judged with", f"{link}: {told_counts(section.counts)}"))
        yield f"<dl>{''.join(f'<dt>{name}</dt><dd>{text}</dd>' for name, text in rows)}</dl>"
    yield from map(_image, section.images)
    if outcome:
        yield from _outcome(outcome)
    yield "</section>\n"


def _outcome(outcome: Outcome) -> Iterator[str]:
    if outcome.error:
        yield f'<p class="broke">Broke off: {escape(outcome.error)}</p>'
        yield f"<details><summary>where</summary><pre>{escape(outcome.trace)}</pre></details>"
    if outcome.experiment:
        claims = outcome.experiment.claims
        kinds = [f"claim {slug(claim.verdict)}" for claim in claims]
        rows = [report.row(claim) for claim in claims]
        yield f'<p class="quiet">Experiment <code>{escape(outcome.name)}</code></p>'
        yield _table(report.COLUMNS, rows, "claims stacked", kinds)
        yield from map(_question, outcome.experiment.questions)


def _question(question: OpenQuestion) -> str:
    rows = [report.reading_row(reading) for reading in question.readings]
    kinds = [slug(reading.verdict) for reading in question.readings]
    table = _table(report.reading_columns(question), rows, "stacked", kinds)
    return f"<p>{escape(report.reading_caption(question))}</p>{table}"


def _table(
    head: Sequence[str],
    rows: Sequence[Sequence[str]],
    kind: str = "",
    kinds: Sequence[str] | None = None,
) -> str:
    """Return a table; each cell names its column, for a screen that is too narrow for it."""
    titles = "".join(f"<th>{escape(each)}</th>" for each in head)
    lines = []
    for row, one in zip(rows, kinds or [""] * len(rows), strict=True):
        cells = "".join(
            f'<td data-label="{escape(name)}"{_class(name)}><span>{escape(cell)}</span></td>'
            for name, cell in zip(head, row, strict=True)
        )
        lines.append(f'<tr class="{one}">{cells}</tr>')
    return (
        f'<div class="scroll"><table class="{kind}"><thead><tr>{titles}</tr></thead>'
        f"<tbody>{''.join(lines)}</tbody></table></div>"
    )


def _class(column: str) -> str:
    return ' class="verdict"' if column == "verdict" else ""


def _image(image: Image) -> str:
    kind = TYPES[Path(image.name).suffix]
    data = base64.b64encode(image.content()).decode()
    caption = escape(image.caption)
    return (
        f'<figure><img alt="{caption}" src="data:{kind};base64,{data}">'
        f"<figcaption>{caption}</figcaption></figure>"
    )
