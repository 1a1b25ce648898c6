"""The after-action report as one page that needs no network."""

from __future__ import annotations

import math
from collections.abc import Iterator
from html import escape
from pathlib import Path
from typing import Any, Final

import xarray as xr

from scara_drake import metrics
from scara_drake.common.files import write_whole
from scara_drake.comparison.page import STYLE, image, table
from scara_drake.debrief.pictures import pictures
from scara_drake.debrief.told import events
from scara_drake.recordings.surfaces import KIND, read_scenario

MORE_STYLE: Final = """
.score { font-size: 2.6em; font-weight: 600; } .of { color: #666; }
.grave td { color: #a4243b; } td.said, th.said { text-align: left; }
.verdict { margin: .3em 0 1em; } h2 { border-top: 1px solid #eee; padding-top: .6em; }
"""


def save_report(recording: xr.Dataset, path: str | Path, name: str = "") -> None:
    """Write the report of a recording, whole or not at all; its folder is made if need be.

    Raises:
        ValueError: the name does not end in .html, or the recording has no samples.
        OSError: the page cannot be written.
    """
    target = Path(path)
    if target.suffix != ".html":
        raise ValueError(f"html: '{target}', allowed a file that ends in .html")
    if not recording.sizes.get("time"):
        raise ValueError("recording: no samples, allowed one with samples")
    text = page(recording, name or str(recording.attrs.get("scenario_name", "a run")))
    target.parent.mkdir(parents=True, exist_ok=True)
    write_whole(target, text)


def page(recording: xr.Dataset, name: str) -> str:
    """Return the page: the score, what happened, the pictures, how it was made."""
    title = escape(f"{name}: after-action report")
    body = "".join(
        [f"<h1>{title}</h1>", *_score(recording), *_pictures(recording), *_told(recording)]
    )
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{title}</title>'
        f"<style>{STYLE}{MORE_STYLE}</style></head><body>{body}{_facts(recording)}</body></html>\n"
    )


def _score(recording: xr.Dataset) -> Iterator[str]:
    verdict = metrics.verdict(recording)
    said = "; ".join([str(verdict), *verdict.remarks])
    found = metrics.score(recording)
    if found is None:
        yield '<p class="missing">This scenario has no task, so there is no score.</p>'
        yield f'<p class="verdict">Verdict: {escape(said)}.</p>'
        return
    done = f"done in {found.seconds:.1f} s" if found.done else f"{100 * found.share:.0f} % done"
    yield f'<p><span class="score">{found.total:.0f}</span> <span class="of">of 100</span> · '
    yield f"{escape(found.task)}, {done}</p>"
    yield f'<p class="verdict">Verdict: {escape(said)}.</p>'
    rows = [
        [
            each.name,
            _with_unit(each.value, each.unit),
            _with_unit(each.best, each.unit),
            _with_unit(each.worst, each.unit),
            f"{found.share * each.points:.1f} of {each.weight:g}",
        ]
        for each in found.criteria
    ]
    yield table(["criterion", "value", "full points at", "none at", "points"], rows)
    if found.share < 1.0:
        yield '<p class="missing">All points count in proportion to the share done.</p>'


def _with_unit(value: float, unit: str) -> str:
    if not math.isfinite(value):
        return "-"
    if unit == "m":
        return f"{1e3 * value:.3g} mm"
    size = f"{value:.0f}" if abs(value) >= 1e3 else f"{value:.3g}"
    return size if unit == "1" else f"{size} {unit.replace('^2', '²')}"


def _pictures(recording: xr.Dataset) -> Iterator[str]:
    missing = []
    for title, picture in pictures(recording):
        if isinstance(picture, str):
            missing.append(picture)
        else:
            yield f"<h2>{escape(title)}</h2>{image(picture, title)}"
    if missing:
        yield f'<p class="missing">{escape(" ".join(missing))}</p>'


def _told(recording: xr.Dataset) -> Iterator[str]:
    yield "<h2>What happened, and what was the operator told?</h2>"
    found = events(recording)
    if not found:
        yield '<p class="missing">Nothing was told.</p>'
        return
    lines = "".join(
        f"<tr{' class=grave' if each.grave else ''}><td>{each.time:.2f}</td>"
        f'<td class="said">{each.source}</td><td class="said">{escape(each.said)}</td></tr>'
        for each in found
    )
    yield (
        '<table class="words"><thead><tr><th>time [s]</th>'
        '<th class="said">source</th><th class="said">what</th></tr></thead>'
        f"<tbody>{lines}</tbody></table>"
    )


def _facts(recording: xr.Dataset) -> str:
    attributes = recording.attrs
    rows = [
        [label, str(attributes[key])]
        for label, key in (
            ("scenario", "scenario_name"),
            ("device", "device"),
            ("seed", "seed"),
            ("engine", "engine"),
            ("ended by", "ended_by"),
            ("ended at [s]", "ended_at"),
        )
        if attributes.get(key) not in (None, "")
    ]
    try:
        scenario = read_scenario(str(attributes.get("scenario", "")))
    except ValueError:
        scenario = {}
    rows += [[label, text] for label, text in _of_scenario(scenario) if text]
    return f"<h2>How was it made?</h2>{table(['', ''], rows, 'words')}"


def _of_scenario(scenario: dict[str, Any]) -> Iterator[tuple[str, str]]:
    yield "description", str(scenario.get("description") or "")
    for part in ("operator", "task", "controller"):
        kind = scenario.get(part)
        if isinstance(kind, dict):
            preset = f", {kind['preset']}" if kind.get("preset") else ""
            yield part, f"{kind.get(KIND, '')}{preset}"
    channel = scenario.get("channel")
    if isinstance(channel, dict):
        for way in ("up", "down"):
            link = channel.get(way)
            if isinstance(link, dict):
                numbers = ", ".join(f"{k} {v:g}" for k, v in link.items() if isinstance(v, float))
                yield f"channel {way}", f"{link.get(KIND, '')} {numbers}".strip()
