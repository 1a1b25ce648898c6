from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scara_drake.common.schema import build, data_of, yaml_of


@dataclass
class Soft:
    stiffness: float = 1.0


@dataclass
class Hard:
    stiffness: float = 2.0
    count: int = 1


@dataclass
class Whole:
    part: Soft | Hard = field(default_factory=Soft)
    gains: list[float] = field(default_factory=lambda: [1.0, 2.0])
    words: list[str] = field(default_factory=lambda: ["a", "b"])
    limit: float | None = None
    quiet: bool = False
    free: list[float] = field(default_factory=list)


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_number_in_any_writing_is_that_number(value):
    data = {"part": {"_tag": "!Hard", "stiffness": f"{value:.17e}"}, "gains": repr(value)}
    made = build(Whole, data)
    assert made == Whole(part=Hard(stiffness=value), gains=[value, value])


def test_a_word_is_spread_and_nothing_else_is_changed():
    data = {"words": "c", "limit": None, "quiet": True, "free": [1]}
    assert build(Whole, data) == Whole(words=["c", "c"], quiet=True, free=[1.0])


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ({"other": 1}, "other: unknown field, allowed part, gains"),
        ({"part": {"_tag": "!Odd"}}, "part: 'Odd', allowed Soft, Hard"),
        ({"part": {"_tag": "!Hard", "count": 1.5}}, "part.count: 1.5, allowed a whole number"),
        ({"part": 3}, "part: 3, allowed the fields of Soft or Hard"),
        ({"gains": [1.0, "x"]}, r"gains\[1\]: x, allowed a number"),
        ({"gains": None}, "gains: empty, allowed list"),
        ({"quiet": 1}, "quiet: 1, allowed true or false"),
        ({"free": 3}, "free: 3, allowed a list"),
        ({"limit": True}, "limit: True, allowed a number"),
    ],
)
def test_what_does_not_fit_is_named(data, message):
    with pytest.raises(ValueError, match=f"^top\\.{message}"):
        build(Whole, data, "top.")


def test_numbers_of_numpy_are_written_as_numbers():
    numbers: dict[str, Any] = {"gains": np.array([1.0, 3.0]), "limit": np.float32(2.0)}
    made = Whole(part=Hard(stiffness=np.float64(2.5)), **numbers)
    assert data_of(made)["gains"] == [1.0, 3.0]
    assert yaml_of(made) == (
        "part: !Hard\n  stiffness: 2.5\n  count: 1\ngains: [1.0, 3.0]\nwords: [a, b]\n"
        "limit: 2.0\nquiet: false\nfree: []\n"
    )
