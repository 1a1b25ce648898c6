"""The report as Markdown, with its pictures beside it; the same text from run to run."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from scara_drake.common.files import whole_file, write_whole
from scara_drake.experiments import report
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

PICTURES = "reproduction"  # folder beside the page


def save_markdown(found: Contents, folder: Path) -> Path:
    """Write the page and its pictures into a folder, each whole or not at all; return its path.

    Raises:
        OSError: it cannot be written.
    """
    pictures = folder / PICTURES
    pictures.mkdir(parents=True, exist_ok=True)
    for section in _sections(found):
        for image in section.images:
            if not _is_below(image, folder):
                with whole_file(pictures / image.name) as partial:
                    partial.write_bytes(image.content())
    path = folder / "reproduction.md"
    write_whole(path, markdown(found, folder))
    return path


def markdown(found: Contents, folder: Path) -> str:
    """Return the page, as it is written into a folder."""
    lines = [f"# {TITLE}", "", INTRODUCTION, ""]
    lines += [f"Made by `scara-drake reproduce` with {versions(found.seed)}.", ""]
    lines += [report.markdown_table(*counts_table(found))]
    if found.failed:
        lines += ["**Broke off:**", ""]
        lines += [f"- `{each.name}`: {each.error}" for each in found.failed] + [""]
    if found.differences:
        lines += [f"**{DIFFERENT}**", ""]
        lines += [f"- {each}" for each in found.differences] + [""]
    for title, sections in found.chapters.items():
        lines += [f"- {title}: {', '.join(_link(section) for section in sections)}"]
    for title, sections in found.chapters.items():
        lines += ["", f"## {title}"]
        for section in sections:
            lines += ["", f"### {section.heading}", ""]
            lines += _section(section, folder)
    return "\n".join(lines).rstrip() + "\n"


def _sections(found: Contents) -> Iterator[Section]:
    for sections in found.chapters.values():
        yield from sections


def _link(section: Section) -> str:
    """Return a link to a section, by its numbers alone where it has some."""
    name = section.heading.partition(" ")[2] if section.entry else section.heading
    return f"[{name}](#{section.anchor})"


def _section(section: Section, folder: Path) -> Iterator[str]:
    entry = section.entry
    yield f"**{section.title}.**"
    yield ""
    if entry:
        yield f"- The paper: {entry.paper}"
        yield f"- Here: {entry.here}"
        if entry.contradiction:
            yield f"- The paper cannot be right: {entry.contradiction}"
        where = ", ".join(f"`{path}`" for path in entry.where)
        yield f"- Where: {where}; test `{entry.test}`"
        if section.told:
            link = f"[{section.told}](#{slug(section.told)})"
            yield f"- Judged with {link}: {told_counts(section.counts)}"
        yield ""
    for image in section.images:
        yield f"![{image.caption}]({_address(image, folder)})"
        yield ""
        yield f"*{image.caption}*"
        yield ""
    outcome = section.outcome
    if outcome and outcome.error:
        yield f"**Broke off**: {outcome.error}"
        yield ""
    if outcome and outcome.experiment:
        yield f"Experiment `{outcome.name}`:"
        yield ""
        rows = [report.row(claim, clock=False) for claim in outcome.experiment.claims]
        yield report.markdown_table(report.COLUMNS, rows)
        for question in outcome.experiment.questions:
            yield report.reading_markdown(question, clock=False)


def _is_below(image: Image, folder: Path) -> bool:
    """Whether a shipped picture is in that folder already, as those of docs are."""
    return image.shipped is not None and image.shipped.is_relative_to(folder.resolve())


def _address(image: Image, folder: Path) -> str:
    if image.shipped and _is_below(image, folder):
        return os.path.relpath(image.shipped, folder.resolve())
    return f"{PICTURES}/{image.name}"
