"""The index names every table, figure and equation of the paper once, with what is there."""

import re
from pathlib import Path

import pytest

from scara_drake.common.resources import resource
from scara_drake.experiments import EXPERIMENTS
from scara_drake.reproduction.contents import slug
from scara_drake.reproduction.index import ENTRIES, NUMBERED, read_entries, runs
from scara_drake.reproduction.run import DRAWN
from scara_drake.reproduction.selection import experiment_of, select

ROOT = Path(__file__).parents[1]
GOOD = """\
- numbers: [1]
  title: a
  paper: b
  here: c
  where: [kinematics.py]
  test: test_kinematics.py::test_x
"""


@pytest.mark.parametrize(("kind", "last"), [("table", 12), ("figure", 30), ("equation", 53)])
def test_each_is_named_once(kind, last):
    named = sorted(n for entry in ENTRIES if entry.kind == kind for n in entry.numbers)
    assert named == list(range(1, last + 1))
    assert NUMBERED[kind] == last


@pytest.mark.parametrize("entry", ENTRIES, ids=lambda entry: slug(entry.heading))
def test_what_an_entry_names_is_there(entry):
    assert list(entry.numbers) == sorted(entry.numbers)
    for path in entry.where:
        assert any((folder / path).exists() for folder in (ROOT, ROOT / "scara_drake")), path
    assert all(resource(path) for path in entry.pictures)
    ((file, function),) = re.findall(r"^(\w+\.py)::(\w+)$", entry.test)
    assert re.search(rf"^def {function}\(", (ROOT / "tests" / file).read_text(), re.M), entry.test
    assert entry.experiment in ("", *EXPERIMENTS)
    assert all([entry.title, entry.paper, entry.here, entry.where])


def test_every_experiment_on_the_paper_judges_an_entry():
    judged = {experiment_of(entry, EXPERIMENTS) for entry in ENTRIES}
    assert {name for name in EXPERIMENTS if re.match(r"table|figure", name)} <= judged


def test_each_picture_is_drawn_by_what_judges_it():
    for kind, pictures in DRAWN.items():
        for number, picture in pictures.items():
            (entry,) = (e for e in ENTRIES if e.kind == kind and number in e.numbers)
            assert experiment_of(entry, EXPERIMENTS) == picture.experiment, (kind, number)


def test_drawings_and_photographs_have_a_picture_in_their_place():
    first = [entry for entry in ENTRIES if entry.kind == "figure" and entry.numbers[0] <= 7]
    assert len(first) == 7
    assert all(entry.pictures for entry in first)


@pytest.mark.parametrize(
    ("numbers", "words"),
    [
        ((8,), "8"),
        ((8, 9), "8 and 9"),
        ((2, 3, 4, 5), "2 to 5"),
        ((20, 21, 23, 24, 25, 26, 27), "20, 21 and 23 to 27"),
    ],
)
def test_numbers_in_words(numbers, words):
    assert runs(numbers) == words


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (GOOD.replace("title", "titel"), "titel, title, allowed numbers, title"),
        (GOOD.replace("[1]", "[13]"), r"tables.yaml\[0\].numbers: 13, allowed 1 to 12"),
        (GOOD.replace("  here: c\n", ""), "here, allowed"),
    ],
)
def test_an_entry_that_is_none_is_refused_in_one_line(text, said):
    assert read_entries("table", GOOD)[0].title == "a"
    with pytest.raises(ValueError, match=said) as error:
        read_entries("table", text)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("names", "headings", "experiments"),
    [
        (["table_10"], ["Table 10"], ["table_10"]),
        (["figure_16"], ["Figures 16 and 17"], ["figures_16_17"]),
        (["figures_16_17"], ["Figures 16 and 17"], ["figures_16_17"]),
        (["equation_47"], ["Equation 47"], ["equivalent_control"]),
        (["equation_2"], ["Equations 2 to 5"], []),
        (["windup"], [], ["windup"]),
        (["tables_1_2", "figure_1"], ["Table 1", "Table 2", "Figure 1"], ["table_1", "table_2"]),
        (
            ["figures_20_27"],
            ["Figures 20, 21 and 23 to 27", "Figure 22"],
            ["figures_20_27", "figure_22"],
        ),
    ],
)
def test_names_are_understood(names, headings, experiments):
    found = select(names, EXPERIMENTS)
    assert [entry.heading for entry in found.entries] == headings
    assert list(found.experiments) == experiments


def test_without_a_name_it_is_everything():
    found = select([], EXPERIMENTS)
    assert found.entries == ENTRIES
    assert list(found.experiments) == list(EXPERIMENTS)


@pytest.mark.parametrize(
    "name",
    ["table_13", "figure_0", "equation_54", "figures_17_16", "tabel_1", "tables", "", "x\ny"],
)
def test_an_unknown_name_is_answered_by_those_there_are(name):
    with pytest.raises(ValueError, match=r"^--only: '.*', allowed table_1 to table_12, ") as error:
        select([name], EXPERIMENTS)
    assert "\n" not in str(error.value)
    assert all(each in str(error.value) for each in EXPERIMENTS if not each[-1].isdigit())


@pytest.mark.parametrize(("name", "near"), [("figure_99", ""), ("TABLE_3", "table_3")])
def test_a_number_that_is_not_in_the_paper_is_near_to_no_other(name, near):
    with pytest.raises(ValueError, match=r"^--only: ") as error:
        select([name], EXPERIMENTS)
    assert str(error.value).partition("did you mean ")[2] == (f"'{near}'?" if near else "")
