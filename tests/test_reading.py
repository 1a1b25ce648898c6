"""What is left open stands in one table, with one reading chosen."""

import html
import io

import pytest
from rich.console import Console

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
    table = report.reading_table(asked())
    assert list(table.columns) == ["reading", "meaning", "delay", "verdict"]
    assert table.values.tolist() == [
        [f"a | b {report.CHOSEN}", "it is cut", "0.2 s", NOT_REPRODUCED],
        ["c", "it is not", "0 to 2 s", REPRODUCED],
        ["d", "nobody can tell", "none", report.NOT_JUDGED],
    ]


def test_terminal_markdown_and_notebook_show_the_same_rows():
    question = asked()
    console = Console(width=200, record=True, file=io.StringIO())
    console.print(report.reading_terminal(question))
    shown = console.export_text()
    page = html.unescape(report.reading_styler(question).to_html())
    lines = report.reading_markdown(question).splitlines()
    for row in report.reading_table(question).values:
        for cell in row:
            assert cell in shown
            assert cell in page
    assert report.reading_caption(question) in shown
    assert lines[0] == "Which delay? Judged: it is late."
    assert len(lines) == 2 + 2 + len(question.readings)
    assert "| a \\| b (ours) | it is cut | 0.2 s | not reproduced |" in lines
