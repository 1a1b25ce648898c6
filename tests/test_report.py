import re

import pytest
import xarray as xr
from matplotlib.figure import Figure

from scara_drake.experiments import EXPERIMENTS, __main__
from scara_drake.experiments.claim import (
    IN_KIND,
    NOT_COMPARABLE,
    NOT_REPRODUCED,
    REPRODUCED,
    Claim,
    Criterion,
    Experiment,
)
from scara_drake.experiments.plots import Picture
from scara_drake.experiments.report import claims_table, verdict_counts

BELOW, EXACT = Criterion("below 2 s", True), Criterion("no more than 0.1 mm", False)
CLAIMS = [
    Claim("it is fast", "2 s", "3 ms", BELOW, "the drives are strong"),
    Claim("it is exact", "0 mm", "1 mm", EXACT, "the encoder is coarse"),
]


def test_a_claim_is_a_row_with_all_that_it_says():
    page = claims_table(Experiment("one", xr.Dataset(), CLAIMS)).to_html()
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
    page = claims_table(Experiment("one", xr.Dataset(), claims)).to_html()
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


def test_all_are_run_in_one_table(monkeypatch, capsys, tmp_path):
    def made(seed):
        return Experiment("Table 0", xr.Dataset(), [*CLAIMS, Claim("s", "p", "o", None, "r")])

    monkeypatch.setattr(__main__, "EXPERIMENTS", {"table_0": made, "other": made})
    monkeypatch.setenv("COLUMNS", "200")  # no sentence is broken, wherever the tests are run
    assert __main__.main([]) == 0
    out = capsys.readouterr().out
    assert out.count("Table 0") == 2
    assert out.count("it is exact") == 2
    counts = "6 claims: 2 reproduced, 0 reproduced in kind, 2 not reproduced, 2 not comparable"
    assert out.endswith(counts + "\n")
    picture = Picture("other", lambda data: Figure(), "nothing")
    monkeypatch.setattr(__main__, "FIGURES", {99: picture})
    assert __main__.main(["other", "--reasons", "--pictures", str(tmp_path)]) == 0
    assert [path.name for path in tmp_path.iterdir()] == ["figure_99.png"]
    assert "the encoder is coarse" in capsys.readouterr().out


def test_a_folder_that_is_not_there_is_refused_before_the_run(capsys, tmp_path):
    with pytest.raises(SystemExit) as stopped:
        __main__.main(["--pictures", str(tmp_path / "none")])
    assert stopped.value.code == 2
    assert "allowed a folder that exists" in capsys.readouterr().err


def test_an_unknown_name_is_answered_by_those_there_are(capsys):
    with pytest.raises(SystemExit) as stopped:
        __main__.main(["table_99"])
    assert stopped.value.code == 2
    error = capsys.readouterr().err
    assert "NAME: table_99, allowed" in error
    assert all(name in error for name in EXPERIMENTS)
