"""What claims and experiments show of themselves in a notebook."""

from __future__ import annotations

from typing import Final

from scara_drake.common.html import Markup, card, chip, folded, join, line, put, table
from scara_drake.display import look
from scara_drake.experiments import report
from scara_drake.experiments.claim import VERDICTS, Claim, Experiment
from scara_drake.experiments.quantity import text
from scara_drake.experiments.reading import OpenQuestion

GROUNDS: Final = dict(zip(VERDICTS, look.VERDICTS, strict=True))  # colours behind the verdicts


def of_claim(claim: Claim) -> Markup:
    """Return the card of a claim: what the paper has, what is here, the verdict and why."""
    rows = [("paper", report.paper(claim)), ("here", text(claim.measured))]
    return card(
        claim.statement, line(verdict(claim.verdict)), table(rows), line(report.explanation(claim))
    )


def of_experiment(experiment: Experiment) -> Markup:
    """Return the card of an experiment: its claims, and folded its open questions and its data."""
    rows = [
        (
            join([claim.statement, folded("why", report.explanation(claim))]),
            report.paper(claim),
            text(claim.measured),
            verdict(claim.verdict),
        )
        for claim in experiment.claims
    ]
    data = [
        (name, " × ".join(f"{dim} {experiment.data.sizes[dim]}" for dim in variable.dims))
        for name, variable in experiment.data.data_vars.items()
    ]
    return card(
        experiment.name,
        table(rows, ["statement", "paper", "here", "verdict"]),
        *(folded(question.question, _readings(question)) for question in experiment.questions),
        folded(f"data: {len(data)} variables", table(data, ["variable", "over"])),
    )


def of_question(question: OpenQuestion) -> Markup:
    """Return the card of an open question: its readings side by side."""
    return card(question.question, line(f"It decides: {question.claim}"), _readings(question))


def _readings(question: OpenQuestion) -> Markup:
    rows = [report.reading_row(reading) for reading in question.readings]
    return table(
        [(*cells, verdict(judged)) for *cells, judged in rows], report.reading_columns(question)
    )


def verdict(word: str) -> Markup:
    """Return a verdict in its colour; what is none as it is."""
    return chip(word, GROUNDS[word]) if word in GROUNDS else put(word)
