"""What is left open stands in one table, with one reading chosen."""

import pytest

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
