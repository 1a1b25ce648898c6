import re

import xarray as xr

from scara_drake.experiments.claim import (
    IN_KIND,
    NOT_COMPARABLE,
    NOT_REPRODUCED,
    REPRODUCED,
    Claim,
    Criterion,
    Experiment,
)
from scara_drake.experiments.report import verdict_counts

BELOW, EXACT = Criterion("below 2 s", True), Criterion("no more than 0.1 mm", False)
CLAIMS = [
    Claim("it is fast", "2 s", "3 ms", BELOW, "the drives are strong"),
    Claim("it is exact", "0 mm", "1 mm", EXACT, "the encoder is coarse"),
]


def test_a_claim_is_a_row_with_all_that_it_says():
    page = Experiment("one", xr.Dataset(), CLAIMS)._repr_html_()
    for claim, criterion in zip(CLAIMS, (BELOW, EXACT), strict=True):
        for text in (claim.statement, claim.paper, claim.measured, claim.verdict, claim.reason):
            assert str(text) in page
        assert criterion.text in page


def test_each_verdict_has_a_colour_of_its_own():
    verdicts = {
        REPRODUCED: Criterion("", True),
        IN_KIND: Criterion("", False, True),
        NOT_REPRODUCED: Criterion("", False),
        NOT_COMPARABLE: None,
    }
    claims = [Claim("s", "p", "o", criterion, "r") for criterion in verdicts.values()]
    assert [claim.verdict for claim in claims] == list(verdicts)
    page = Experiment("one", xr.Dataset(), claims)._repr_html_()
    assert len(set(re.findall(r"background:(#\w+)", page))) == 4


def test_verdicts_are_counted_by_experiment():
    one = Experiment("one", xr.Dataset(), CLAIMS)
    two = Experiment("two", xr.Dataset(), CLAIMS[:1])
    table = verdict_counts([one, two])
    assert list(table.columns) == [REPRODUCED, IN_KIND, NOT_REPRODUCED, NOT_COMPARABLE, "All"]
    assert table.loc["one"].tolist() == [1, 0, 1, 0, 2]
    assert table.loc["two"].tolist() == [1, 0, 0, 0, 1]
    assert table.loc["All"].tolist() == [2, 0, 1, 0, 3]
    assert table.to_numpy().dtype == int
