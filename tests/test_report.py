import re

import pytest
import xarray as xr

from scara_drake.experiments.claim import (
    IN_KIND,
    NOT_COMPARABLE,
    NOT_REPRODUCED,
    REPRODUCED,
    Claim,
    Experiment,
)
from scara_drake.experiments.report import claims_table, verdict_counts

CLAIMS = [
    Claim("it is fast", "2 s", "3 ms", REPRODUCED, "below 2 s"),
    Claim("it is exact", "0 mm", "1 mm", NOT_REPRODUCED, "above 0"),
]


def test_a_claim_is_a_row_with_all_that_it_says():
    page = claims_table(CLAIMS).to_html()
    for claim in CLAIMS:
        for text in vars(claim).values():
            assert text in page


def test_each_verdict_has_a_colour_of_its_own():
    verdicts = [REPRODUCED, IN_KIND, NOT_REPRODUCED, NOT_COMPARABLE]
    page = claims_table([Claim("s", "p", "o", verdict, "r") for verdict in verdicts]).to_html()
    assert len(set(re.findall(r"background-color: (#\w+)", page))) == 4


def test_verdicts_are_counted_by_experiment():
    one = Experiment("one", xr.Dataset(), CLAIMS)
    two = Experiment("two", xr.Dataset(), CLAIMS[:1])
    table = verdict_counts([one, two])
    assert list(table.columns) == [REPRODUCED, IN_KIND, NOT_REPRODUCED, NOT_COMPARABLE, "All"]
    assert table.loc["one"].tolist() == [1, 0, 1, 0, 2]
    assert table.loc["two"].tolist() == [1, 0, 0, 0, 1]
    assert table.loc["All"].tolist() == [2, 0, 1, 0, 3]
    assert table.to_numpy().dtype == int


def test_an_unknown_verdict_is_refused():
    with pytest.raises(ValueError, match="verdict"):
        Claim("s", "p", "o", "perhaps", "r")
