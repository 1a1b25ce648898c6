"""docs/paper.md names every table, figure and equation, with what is there."""

import re
from pathlib import Path

import pytest

from scara_drake.experiments import EXPERIMENTS

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "paper.md").read_text()
# What the paper numbers.
NUMBERED = {"table": 12, "figure": 30, "equation": 53}


def rows(kind):
    block = re.findall(rf"^\| {kind} \|.*?\n\n|^\| {kind} \|.*\Z", PAGE, re.M | re.S)[0]
    lines = block.strip().splitlines()[2:]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


ROWS = [(kind, *row) for kind in NUMBERED for row in rows(kind)]


def numbers(text):
    """Numbers of a cell such as "1, 10" or "34 to 36"."""
    for part in text.split(", "):
        first, _, last = part.partition(" to ")
        yield from range(int(first), int(last or first) + 1)


@pytest.mark.parametrize(("kind", "last"), NUMBERED.items())
def test_each_is_named_once(kind, last):
    named = sorted(n for row in ROWS if row[0] == kind for n in numbers(row[1]))
    assert named == list(range(1, last + 1))


@pytest.mark.parametrize(("kind", "number", "what", "where", "test"), ROWS)
def test_what_a_row_names_is_there(kind, number, what, where, test):
    paths = re.findall(r"`([\w/]+(?:\.\w+)?/?)`", where)
    assert paths
    for path in paths:
        assert any((folder / path).exists() for folder in (ROOT, ROOT / "scara_drake")), path
    ((file, function),) = re.findall(r"^`(\w+\.py)::(\w+)`$", test)
    assert re.search(rf"^def {function}\(", (ROOT / "tests" / file).read_text(), re.M), test


def test_every_experiment_on_the_paper_has_a_row():
    for name in EXPERIMENTS:
        if re.match(r"table|figure", name):
            assert f"/{name}.py`" in PAGE, name


def test_the_readme_names_every_experiment():
    text = (ROOT / "README.md").read_text()
    assert [name for name in EXPERIMENTS if f"`{name}`" not in text] == []
