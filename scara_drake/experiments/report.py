"""Claims and readings as text: sentences, rows of tables, and Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Final

import pandas as pd

from scara_drake.experiments.claim import (
    IN_KIND,
    NOT_REPRODUCED,
    OURS,
    REPRODUCED,
    VERDICTS,
    Claim,
    Experiment,
)
from scara_drake.experiments.quantity import text
from scara_drake.experiments.reading import OpenQuestion, Reading

# What a verdict is called where the criterion is our own.
OWN_WORDS: Final = {REPRODUCED: "met", IN_KIND: "met in kind", NOT_REPRODUCED: "not met"}
# Marks of a reading: the one that the claims are judged by, and one without a verdict.
CHOSEN: Final = "(ours)"
NOT_JUDGED: Final = "not judged"
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


def row(claim: Claim, clock: bool = True) -> tuple[str, ...]:
    """Return the cells of a claim, see COLUMNS.

    Args:
        claim: any.
        clock: writes what was measured by the clock, too, which differs from run to run.
    """
    measured = text(claim.measured, clock=clock)
    return (claim.statement, paper(claim), measured, claim.verdict, explanation(claim))


def table(*experiments: Experiment) -> pd.DataFrame:
    """Return the claims as a table of COLUMNS; `reason` tells the criterion too.

    The rows of several experiments are named by them.
    """
    rows = [row(claim) for experiment in experiments for claim in experiment.claims]
    names = [experiment.name for experiment in experiments for _ in experiment.claims]
    index = pd.Index(names, name="experiment") if len(experiments) > 1 else None
    return pd.DataFrame(rows, columns=list(COLUMNS), index=index)


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


def reading_columns(question: OpenQuestion) -> list[str]:
    """Return the heads of the table of a question: reading, what it does, consequences, verdict."""
    return ["reading", "meaning", *question.readings[0].consequences, "verdict"]


def reading_row(reading: Reading, clock: bool = True) -> list[str]:
    """Return the cells of a reading, see `reading_columns`; ours is marked; `clock` as in `row`."""
    name = f"{reading.name} {CHOSEN}" if reading.chosen else reading.name
    values = [text(value, clock=clock) for value in reading.consequences.values()]
    return [name, reading.meaning, *values, reading.verdict or NOT_JUDGED]


def reading_caption(question: OpenQuestion) -> str:
    """Return a question, and the statement whose verdict hangs on it."""
    return f"{question.question} Judged: {question.claim}."


def reading_markdown(question: OpenQuestion, clock: bool = True) -> str:
    """Return a question as a table of Markdown, below its caption; `clock` as in `row`."""
    rows = [reading_row(reading, clock) for reading in question.readings]
    table = markdown_table(reading_columns(question), rows)
    return f"{reading_caption(question)}\n\n{table}"


def markdown_table(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table of texts as Markdown."""
    lines = [_cells(columns), "|" + "---|" * len(columns), *map(_cells, rows)]
    return "\n".join([*lines, ""])


def _cells(texts: Iterable[str]) -> str:
    escaped = [cell.replace("|", "\\|") for cell in texts]
    return f"| {' | '.join(escaped)} |"
