"""What is left open stands in one table, with one reading chosen."""

import html

import pytest

from scara_drake.experiments import NOT_REPRODUCED, REPRODUCED, report
from scara_drake.experiments.quantity import quantity
from scara_drake.experiments.reading import OpenQuestion, Reading


def reading(name, chosen=False, consequence="error"):
    return Reading(name, "m", {consequence: "1 mm"}, chosen=chosen)


@pytest.mark.parametrize("chosen", [(False, False), (True, True)])
def test_one_reading_is_chosen(chosen):
    with pytest.raises(ValueError, match=r"^chosen: .*, allowed one reading$"):
        OpenQuestion("q", "c", tuple(reading(f"r{i}", one) for i, one in enumerate(chosen)))


def test_readings_have_the_same_columns():
    with pytest.raises(ValueError, match=r"^consequences of b: time, allowed error$"):
        OpenQuestion("q", "c", (reading("a", True), reading("b", consequence="time")))


def asked():
    readings = (
        Reading("a | b", "it is cut", {"delay": quantity(0.2, "s")}, NOT_REPRODUCED, chosen=True),
        Reading("c", "it is not", {"delay": quantity((0.0, 2.0), "s")}, REPRODUCED),
        Reading("d", "nobody can tell", {"delay": "none"}),
    )
    return OpenQuestion("Which delay?", "it is late", readings)


def test_a_question_is_a_table_of_one_row_a_reading():
    question = asked()
    assert report.reading_columns(question) == ["reading", "meaning", "delay", "verdict"]
    assert [report.reading_row(reading) for reading in question.readings] == [
        [f"a | b {report.CHOSEN}", "it is cut", "0.2 s", NOT_REPRODUCED],
        ["c", "it is not", "0 to 2 s", REPRODUCED],
        ["d", "nobody can tell", "none", report.NOT_JUDGED],
    ]


def test_markdown_and_notebook_show_the_same_rows():
    question = asked()
    page = html.unescape(question._repr_html_())
    lines = report.reading_markdown(question).splitlines()
    for reading in question.readings:
        for cell in report.reading_row(reading):
            assert f">{cell}<" in page
    assert lines[0] == "Which delay? Judged: it is late."
    assert len(lines) == 2 + 2 + len(question.readings)
    assert "| a \\| b (ours) | it is cut | 0.2 s | not reproduced |" in lines
