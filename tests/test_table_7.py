"""Table 7: the search for it, the file of its candidates, and how the experiment judges."""

from dataclasses import replace

import numpy as np
import pytest
from small_experiments import small

from scara_drake.experiments import IN_KIND, NOT_REPRODUCED, REPRODUCED
from scara_drake.experiments.inverse_kinematics import swarm_search, swarm_sets, table_7
from scara_drake.experiments.inverse_kinematics.swarm_law import Coefficients, Law
from scara_drake.experiments.inverse_kinematics.swarm_reported import STATEMENTS
from scara_drake.experiments.inverse_kinematics.swarm_statements import COUNTS, Size
from scara_drake.experiments.plots.table_7 import table_7 as picture
from scara_drake.experiments.quantity import Quantity
from scara_drake.ik import PAPER

OWN = Law(False, False, False, False, False, 48)
FEW = Size(1, 1, 1)
OTHERS = [table_7.PACKAGE, table_7.LISTING]


def experiment():
    return small("table_7")


def searched(monkeypatch, seed):
    monkeypatch.setattr(swarm_search, "HOPELESS", np.inf)
    monkeypatch.setattr(swarm_search, "FEWEST", 1)
    first, ended = swarm_search.first_generation(seed, 4, FEW, [OWN], stops=True)
    assert not ended
    return first, list(swarm_search.search(seed, first, 4, 1, FEW, laws=[OWN]))


def test_a_seed_gives_the_same_candidates_to_the_bit(monkeypatch):
    first, later = searched(monkeypatch, 3)
    again, later_again = searched(monkeypatch, 3)
    for one, other in zip(sum(later, first), sum(later_again, again), strict=True):
        assert one.coefficients == other.coefficients
        assert np.array_equal(one.misfits, other.misfits)
        assert one.weight == other.weight
    assert all(one.coefficients.after == 0 and one.law == OWN for one in first)
    other, _ = searched(monkeypatch, 4)
    assert other[0].coefficients != first[0].coefficients


def test_places_in_the_cube_are_the_stated_ranges():
    low = swarm_search.coefficients_at(np.zeros(7), OWN)
    high = swarm_search.coefficients_at(np.ones(7), OWN)
    assert low == pytest.approx((0.3, 0.999, 0.0, 0.1, 0.005, 0, 5))
    assert high == pytest.approx((1.2, 0.9, 3.0, 4.0, 1.0, 100, 150))
    middle = swarm_search.coefficients_at(np.full(7, 0.5), OWN)
    assert middle.damping == pytest.approx(1.0 - np.sqrt(0.1 * 0.001))
    assert middle.speed == pytest.approx(np.sqrt(0.005))
    literal = swarm_search.coefficients_at(np.ones(7), OWN._replace(literal=True))
    assert literal.speed == pytest.approx(2.0)


def test_the_file_gives_back_what_was_written(tmp_path):
    rows = swarm_sets.read()
    swarm_sets.write(rows, tmp_path / "again.csv")
    assert (tmp_path / "again.csv").read_text() == swarm_sets.FILE.read_text()
    first = rows[0]
    assert first.check == min(row.check for row in rows if row.check == row.check)
    assert sum(row.weight for row in rows) == pytest.approx(1.0, abs=0.01)
    bad = swarm_sets.FILE.read_text().replace(f",{first.counting},{first.phase}", ",99,x", 1)
    (tmp_path / "bad.csv").write_text(bad)
    with pytest.raises(ValueError, match=rf"^count: 99, allowed 0 to {len(COUNTS) - 1}$"):
        swarm_sets.read(tmp_path / "bad.csv")


def test_a_row_keeps_the_largest_sets_of_statements_that_hold_at_once():
    missed = np.ones((len(COUNTS), len(STATEMENTS)))
    missed[0, :2] = missed[1, 0] = missed[2, 3] = 0.0
    one = swarm_search.Candidate(OWN, np.full(7, 0.5), missed, 1.0, 0.25)
    names = list(STATEMENTS)
    row = swarm_sets.found(one, "posterior")
    assert set(row.met) == {frozenset(names[:2]), frozenset([names[3]])}
    assert (row.counting, row.weight) == (0, 0.25)
    assert swarm_sets.found(one, "first").weight == 0.0


def test_the_listing_is_the_matlab_one():
    assert Coefficients(1.0, 0.99, 1.5, 2.0, 0.1, 0, 150) == table_7.LISTED


def test_the_parameter_set_paper_is_the_nearest_under_the_packages_reading():
    rows = [row for row in swarm_sets.read() if row.phase == "package"]
    nearest = min((row for row in rows if row.check == row.check), key=lambda row: row.check)
    assert nearest.law == OWN
    for swarm in (PAPER.pso1, PAPER.single, PAPER.fallback):
        assert swarm[2:7] == nearest.coefficients[:5]
    assert PAPER.pso2[2:7] == (*nearest.coefficients[:2], 0.0, *nearest.coefficients[3:5])
    assert PAPER.pso2.iterations == nearest.coefficients.patience


def verdicts(data):
    return [claim.verdict for claim in table_7.claims(data)]


def test_verdicts():
    data = experiment().data
    missed = data.misfit.sel(set=table_7.BEST).values
    for k, (name, claim) in enumerate(zip(STATEMENTS, experiment().claims[1:], strict=False)):
        # What the search called met, and nothing else, is reproduced.
        assert (claim.verdict == REPRODUCED) == (missed[k] == 0.0), name
    assert verdicts(data)[0] == NOT_REPRODUCED
    assert verdicts(data)[-2:] == [NOT_REPRODUCED] * 2


def test_it_judges_what_it_is_given():
    data = experiment().data.copy(deep=True)
    n = len(STATEMENTS)
    data.most_met[0] = n
    data.misfit.loc[{"set": table_7.BEST}] = 0.0
    data.misfit.loc[{"set": OTHERS}] = 0.0
    data.statistic.loc[{"set": table_7.BEST}] = [v for s in STATEMENTS.values() for v in s.paper]
    assert verdicts(data)[: n + 4] == [REPRODUCED] * (n + 4)
    data.misfit.loc[{"set": table_7.BEST, "statement": ["times", "second"]}] = 0.5
    data.misfit.loc[{"set": OTHERS, "statement": ["times", "second"]}] = 0.7
    data.check[0] = 0.7
    assert [verdicts(data)[k] for k in (0, n + 1, n + 2, n + 3)] == [IN_KIND] * 4
    data.misfit.loc[{"set": table_7.BEST}] = 0.5
    data.misfit.loc[{"set": OTHERS}] = 1.0
    far = dict.fromkeys(STATEMENTS, 500.0) | {"solved": 0.1, "fewer": 1.0, "second": 50.0}
    data.statistic.loc[{"set": table_7.BEST}] = [
        far[name] for name, s in STATEMENTS.items() for _ in s.paper
    ]
    second = 1 + list(STATEMENTS).index("second")
    expected = [NOT_REPRODUCED] * (n + 4)
    expected[second] = REPRODUCED
    assert verdicts(data)[: n + 4] == expected
    data.statistic.loc[{"set": table_7.BEST, "value": ["second 1", "second 3"]}] = [60.0, 40.0]
    data.statistic.loc[{"set": table_7.BEST, "value": ["second 2", "second 4"]}] = [30.0, 70.0]
    assert verdicts(data)[second] == IN_KIND
    data.statistic.loc[{"set": table_7.BEST, "value": ["second 3", "second 4"]}] = 0.0
    assert verdicts(data)[second] == NOT_REPRODUCED
    work, path = table_7.claims(data)[-2:]
    for claim, factor in ((work, 0.7), (path, 6.0)):
        assert claim.verdict == NOT_REPRODUCED
        assert isinstance(claim.paper, Quantity)
        assert replace(claim, paper=claim.paper.scaled(factor)).verdict == REPRODUCED


def test_the_two_contradictions_are_of_the_papers_own_numbers():
    work, path = experiment().claims[-2:]
    # By hand: 0.25625 s over 0.2455 s, against 52 of 66; 50 * 80 * 55 evaluations of 77.5 µs.
    assert work.paper.values[0] == pytest.approx(0.25625 / 0.2455)
    assert path.measured.values[0] == pytest.approx(50 * 80 * 55 * 0.2455 / 66 / 48)


def test_the_readings_stand_beside_each_other():
    data = experiment().data
    for question in experiment().questions:
        counted = [reading.consequences["candidates"].values[0] for reading in question.readings]
        assert sum(counted) == data.sizes["candidate"]
        shares = [reading.consequences["posterior"].values[0] for reading in question.readings]
        assert sum(shares) == pytest.approx(100.0)


def test_the_picture_shows_each_coefficient():
    figure = picture(experiment().data)
    labels = [ax.get_xlabel() for ax in figure.axes]
    assert labels[:5] == ["omega", "omega_d", "c1", "c2", "v_max"]
    assert all(len(ax.collections) == 1 and len(ax.patches) == 1 for ax in figure.axes[:7])
