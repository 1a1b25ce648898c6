"""What claims and experiments show of themselves in a notebook."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scara_drake.common.html import Markup, card, chip, folded, join, line, table
from scara_drake.display import look
from scara_drake.experiments.quantity import text

if TYPE_CHECKING:
    from scara_drake.experiments.claim import Claim, Experiment
    from scara_drake.experiments.reading import OpenQuestion


def of_claim(claim: Claim) -> Markup:
    """Return the card of a claim: what the paper has, what is here, the verdict and why."""
    from scara_drake.experiments.report import explanation, paper

    rows = [("paper", paper(claim)), ("here", text(claim.measured))]
    return card(
        claim.statement, line(verdict(claim.verdict)), table(rows), line(explanation(claim))
    )


def of_experiment(experiment: Experiment) -> Markup:
    """Return the card of an experiment: its claims, and folded its open questions and its data."""
    from scara_drake.experiments.report import explanation, paper

    rows = [
        (
            join([claim.statement, folded("why", explanation(claim))]),
            paper(claim),
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
    rows = [
        (
            f"{reading.name}{' (chosen)' if reading.chosen else ''}",
            reading.meaning,
            *(text(value) for value in reading.consequences.values()),
            verdict(reading.verdict) if reading.verdict else "",
        )
        for reading in question.readings
    ]
    consequences = question.readings[0].consequences
    return table(rows, ["reading", "meaning", *consequences, "verdict"])


def verdict(word: str) -> Markup:
    """Return a verdict in its colour."""
    from scara_drake.experiments.claim import VERDICTS

    return chip(word, dict(zip(VERDICTS, look.VERDICTS, strict=True))[word])
