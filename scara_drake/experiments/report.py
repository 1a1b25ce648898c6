"""Tables of claims and verdicts, for a notebook."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

import pandas as pd
from pandas.io.formats.style import Styler

from scara_drake.display import look
from scara_drake.experiments.claim import VERDICTS, Claim, Experiment

COLORS: Final = dict(zip(VERDICTS, look.VERDICTS, strict=True))


def claims_table(claims: Iterable[Claim]) -> Styler:
    """Return a table of claims, a row each, with the verdicts in their colours."""
    table = pd.DataFrame([vars(claim) for claim in claims])
    colors = table.verdict.map(lambda verdict: f"background-color: {COLORS[verdict]}")
    return wrapped(table.style.hide(axis="index")).apply(lambda _: colors, subset=["verdict"])


def wrapped(table: Styler) -> Styler:
    """Return a table of texts whose lines wrap and begin on the left."""
    return table.set_properties(
        **{"text-align": "left", "vertical-align": "top", "white-space": "normal"}
    ).set_table_styles([{"selector": "th", "props": "text-align: left"}])


def verdict_counts(experiments: Iterable[Experiment]) -> pd.DataFrame:
    """Return how many claims of each experiment got each verdict, and of all together."""
    rows = [(one.name, claim.verdict) for one in experiments for claim in one.claims]
    table = pd.DataFrame(rows, columns=["experiment", "verdict"])
    counts = pd.crosstab(table.experiment, table.verdict, margins=True)
    return counts.reindex(columns=[*VERDICTS, "All"], fill_value=0)
