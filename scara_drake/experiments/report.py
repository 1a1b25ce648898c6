"""Claims as text: a sentence, and tables for a terminal, for Markdown and for notebooks."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Final

import pandas as pd
from pandas.io.formats.style import Styler
from rich.table import Table

from scara_drake.display import look
from scara_drake.experiments.claim import (
    IN_KIND,
    NOT_COMPARABLE,
    NOT_REPRODUCED,
    OURS,
    REPRODUCED,
    VERDICTS,
    Claim,
    Experiment,
)
from scara_drake.experiments.quantity import text
from scara_drake.experiments.reading import OpenQuestion

# What a verdict is called where the criterion is our own.
OWN_WORDS: Final = {REPRODUCED: "met", IN_KIND: "met in kind", NOT_REPRODUCED: "not met"}
COLOURS: Final = {
    REPRODUCED: "green",
    IN_KIND: "yellow",
    NOT_REPRODUCED: "red",
    NOT_COMPARABLE: "dim",
}
COLUMNS: Final = ("statement", "paper", "measured", "verdict", "reason")


def sentence(claim: Claim) -> str:
    """Return a claim as sentences: statement, values, verdict, criterion, reason."""
    here = text(claim.measured)
    if claim.source == OURS:
        return f"{claim.statement}: {here}. {explanation(claim)}"
    return f"{claim.statement}: {paper(claim)} in the paper, {here} here; {claim.verdict}. " + (
        explanation(claim)
    )


def paper(claim: Claim) -> str:
    """Return the paper's value, or what stands for it where it gives none."""
    missing = "not treated" if claim.source == OURS else "not given"
    return text(claim.paper, missing)


def explanation(claim: Claim) -> str:
    """Return the criterion of a claim, and its reason."""
    if claim.criterion is None:
        return claim.reason
    head = "Criterion"
    if claim.source == OURS:
        head = f"Criterion of our own, {OWN_WORDS[claim.verdict]}"
    return f"{head}: {claim.criterion.text}. {claim.reason}"


def table(*experiments: Experiment) -> pd.DataFrame:
    """Return the claims as a table of COLUMNS; `reason` tells the criterion too.

    The rows of several experiments are named by them.
    """
    rows = [row(claim) for experiment in experiments for claim in experiment.claims]
    names = [experiment.name for experiment in experiments for _ in experiment.claims]
    index = pd.Index(names, name="experiment") if len(experiments) > 1 else None
    return pd.DataFrame(rows, columns=list(COLUMNS), index=index)


def claims_table(*experiments: Experiment) -> Styler:
    """Return `table` for a notebook, with the verdicts in their colours."""
    claims = table(*experiments)
    shades = dict(zip(VERDICTS, look.VERDICTS, strict=True))
    colours = claims.verdict.map(lambda verdict: f"background-color: {shades[verdict]}")
    return wrapped(claims.style.hide(axis="index")).apply(lambda _: colours, subset=["verdict"])


def wrapped(texts: Styler) -> Styler:
    """Return a table of texts whose lines wrap and begin on the left."""
    return texts.set_properties(
        **{"text-align": "left", "vertical-align": "top", "white-space": "normal"}
    ).set_table_styles([{"selector": "th", "props": "text-align: left"}])


def verdict_counts(experiments: Iterable[Experiment]) -> pd.DataFrame:
    """Return how many claims of each experiment got each verdict, and of all together."""
    claims = table(*experiments)
    counts = pd.crosstab(claims.index.rename("experiment"), claims.verdict, margins=True)
    return counts.reindex(columns=[*VERDICTS, "All"], fill_value=0)


def markdown(*experiments: Experiment) -> str:
    """Return the claims as Markdown, a table for each experiment."""
    lines = []
    for experiment in experiments:
        rows = [row(claim) for claim in experiment.claims]
        lines += [f"## {experiment.name}", "", markdown_table(COLUMNS, rows)]
    return "\n".join(lines)


def markdown_table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table of texts as Markdown."""
    lines = [f"| {' | '.join(head)} |", "|" + "---|" * len(head)]
    for cells in rows:
        lines.append(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |")
    return "\n".join(lines) + "\n"


def readings(question: OpenQuestion, clock: bool = True) -> tuple[list[str], list[list[str]]]:
    """Return the readings of a question side by side: the head of a table, and its rows."""
    rows = [
        [
            f"{one.name} (chosen)" if one.chosen else one.name,
            one.meaning,
            *(text(value, clock=clock) for value in one.consequences.values()),
            one.verdict or "cannot be judged",
        ]
        for one in question.readings
    ]
    return ["reading", "what it means", *question.readings[0].consequences, "verdict"], rows


def terminal(*experiments: Experiment) -> list[Table]:
    """Return the claims as tables for a `rich` console, one for each experiment."""
    tables = []
    for experiment in experiments:
        made = Table(*COLUMNS, title=experiment.name, title_justify="left")
        for claim in experiment.claims:
            made.add_row(*row(claim), style=COLOURS[claim.verdict])
        tables.append(made)
    return tables


def row(claim: Claim, clock: bool = True) -> tuple[str, ...]:
    """Return the cells of a claim, see COLUMNS; `clock` as in `quantity.text`."""
    measured = text(claim.measured, clock=clock)
    return (claim.statement, paper(claim), measured, claim.verdict, explanation(claim))
