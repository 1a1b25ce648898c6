"""Claims as data: what a rule says of the paper's number, and how values and claims are written."""

import math
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from scara_drake.experiments import report
from scara_drake.experiments.claim import (
    IN_KIND,
    NOT_COMPARABLE,
    NOT_REPRODUCED,
    OURS,
    REPRODUCED,
    AnyOf,
    Claim,
    Criterion,
    Experiment,
    at_least,
    at_most,
    inside,
    ordered,
    within,
    within_factor,
)
from scara_drake.experiments.quantity import Quantity, number, parts, quantity, text

PAPER = quantity(2.0, "mm")


def claim(measured=2.1, **changes):
    value = quantity(measured, "mm")
    criterion = Criterion("within 10 %", within(value, 0.1), within_factor(value, 3.0))
    return replace(Claim("It hangs", PAPER, value, criterion, "It is heavy."), **changes)


@pytest.mark.parametrize(
    ("measured", "verdict"), [(2.1, REPRODUCED), (5.0, IN_KIND), (7.0, NOT_REPRODUCED)]
)
def test_the_verdict_follows_from_the_criterion(measured, verdict):
    assert claim(measured).verdict == verdict
    assert claim(measured, criterion=None).verdict == NOT_COMPARABLE


@given(st.floats(1e-3, 1e3), st.floats(-0.09, 0.09))
def test_ten_times_the_paper_s_number_changes_the_verdict(value, off):
    measured = quantity(value * (1.0 + off), "mm")
    rule = within(measured, 0.1)
    paper = quantity(value, "mm")
    assert rule(paper)
    assert not rule(paper.scaled(10.0))
    assert not rule(paper.scaled(0.1))


def test_rules():
    two = quantity((1.0, 4.0), "s")
    bounds = quantity((0.5, 4.0), "s")
    assert inside(two)(bounds)
    assert not inside(two)(quantity((2.0, 5.0), "s"))
    assert at_most(two)(bounds)
    assert not at_most(two)(quantity(3.0, "s"))
    assert at_most(two, share=0.5)(quantity(3.0, "s"))
    assert at_most(two, 2.0)(quantity(2.0, "s"))
    assert at_least(two)(quantity(1.0, "s"))
    assert not at_least(two)(quantity(2.0, "s"))
    assert at_least(two, 0.5)(quantity(2.0, "s"))
    assert within_factor(two, 2.0)(quantity(2.0, "s"))
    assert not within_factor(two, 1.9)(quantity(2.0, "s"))


def test_an_order_is_compared_across_units_and_follows_one_changed_number():
    paper = quantity({"IJ": 2.0, "DPSO": 2.89, "DPSOIJ": 2.25}, "s")
    rule = ordered(quantity({"IJ": 100, "DPSO": 9000, "DPSOIJ": 500}, "evaluations"))
    assert rule(paper)
    assert not rule(paper.scaled(10.0, which=0))
    assert rule(paper.scaled(10.0))
    never = ordered(quantity({"IJ": 1.0, "DPSO": math.inf, "DPSOIJ": math.inf}))
    assert not never(paper)


def test_all_of_a_tuple_and_any_of_some():
    small, large = within(quantity(2.0, "mm"), 0.1), within(quantity(9.0, "mm"), 0.1)
    assert claim(criterion=Criterion("", (small, True))).verdict == REPRODUCED
    assert claim(criterion=Criterion("", (small, large))).verdict == NOT_REPRODUCED
    assert claim(criterion=Criterion("", AnyOf((small, large)))).verdict == REPRODUCED
    assert claim(criterion=Criterion("", False, np.bool_(True))).verdict == IN_KIND


@pytest.mark.parametrize(
    "paper", [None, "smooth", quantity(2.0, "m"), quantity({"other": 2.0}, "mm")]
)
def test_a_rule_without_a_number_of_its_unit_and_names_is_refused(paper):
    with pytest.raises(ValueError, match="allowed a number in mm"):
        _ = claim(paper=paper).verdict


def test_the_part_of_the_paper_s_value_with_the_same_unit_is_taken():
    assert claim(paper=("about", quantity(7.0, "rad"), PAPER)).verdict == REPRODUCED


def test_equal_claims_are_equal():
    assert claim() == claim()
    assert claim() != claim(2.2)
    assert quantity(math.nan) == quantity(np.array([np.nan]))


def test_a_source_is_the_paper_or_ours():
    with pytest.raises(ValueError, match=r"source: .*theirs.*, allowed"):
        claim(source="theirs")
    with pytest.raises(ValueError, match="names: 1, allowed 2"):
        Quantity((1.0, 2.0), names=("a",))


@pytest.mark.parametrize(
    ("value", "written"),
    [
        (2.0, "2"), (0.92153, "0.922"), (999.7, "1000"), (2345.4, "2345"), (3e-4, "0.0003"),
        (1.234e-9, "1.23e-09"), (-0.0, "0"), (-12.345, "-12.3"), (99.96, "100"),
    ],
)  # fmt: skip
def test_numbers_have_three_digits(value, written):
    assert number(value) == written


def test_quantities_are_written_in_one_way():
    assert str(quantity(5, "mm", bound="below")) == "below 5 mm"
    assert str(quantity((0.5, 2.0), "mm", "median")) == "0.5 to 2 mm (median)"
    assert str(quantity((2.0, 2.0), "mm")) == "2 mm"
    assert str(quantity({"rise": 2.3, "settling": math.inf}, "s", missing="never")) == (
        "rise 2.3 s, settling never"
    )
    assert str(quantity(math.nan, "s")) == "none"
    assert str(quantity(xr.DataArray([1.0, 3.0]))) == "1 to 3"
    assert text((PAPER, "smooth")) == "2 mm; smooth"
    assert text(None) == "not given"
    assert parts(None) == ()


def experiment(*claims):
    return Experiment("Figure 0", xr.Dataset(), list(claims))


def test_the_report_makes_the_sentence():
    assert report.sentence(claim()) == (
        "It hangs: 2 mm in the paper, 2.1 mm here; reproduced. Criterion: within 10 %. It is heavy."
    )
    own = claim(7.0, source=OURS)
    assert report.sentence(own) == (
        "It hangs: 7 mm. Criterion of our own, not met: within 10 %. It is heavy."
    )
    assert report.sentence(claim(criterion=None, paper=None)) == (
        "It hangs: not given in the paper, 2.1 mm here; not comparable. It is heavy."
    )


def test_tables_have_a_row_for_each_claim():
    one, two = experiment(claim()), experiment(claim(5.0), claim(7.0, source=OURS, paper=PAPER))
    table = report.table(one)
    assert list(table.columns) == ["statement", "paper", "measured", "verdict", "reason"]
    assert table.reason[0] == "Criterion: within 10 %. It is heavy."
    both = report.table(one, two)
    assert list(both.verdict) == [REPRODUCED, IN_KIND, NOT_REPRODUCED]
    assert set(both.index) == {"Figure 0"}
    lines = report.markdown(one, two).splitlines()
    assert sum(line.startswith("| It hangs | 2 mm |") for line in lines) == 3
    assert sum(line.startswith("## Figure 0") for line in lines) == 2
