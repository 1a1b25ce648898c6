"""Claims as text: a sentence, and tables for a terminal, for Markdown and for notebooks."""

from __future__ import annotations

from collections.abc import Iterable
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
    colours = claims.verdict.map(lambda word: f"color: black; background-color: {shades[word]}")
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
        lines += [f"## {experiment.name}", "", f"| {' | '.join(COLUMNS)} |"]
        lines += ["|" + "---|" * len(COLUMNS)]
        for claim in experiment.claims:
            cells = [cell.replace("|", "\\|") for cell in row(claim)]
            lines.append(f"| {' | '.join(cells)} |")
        lines.append("")
    return "\n".join(lines)


def terminal(*experiments: Experiment) -> list[Table]:
    """Return the claims as tables for a `rich` console, one for each experiment."""
    tables = []
    for experiment in experiments:
        made = Table(*COLUMNS, title=experiment.name, title_justify="left")
        for claim in experiment.claims:
            made.add_row(*row(claim), style=COLOURS[claim.verdict])
        tables.append(made)
    return tables


def row(claim: Claim) -> tuple[str, ...]:
    """Return the cells of a claim, see COLUMNS."""
    measured = text(claim.measured)
    return (claim.statement, paper(claim), measured, claim.verdict, explanation(claim))
