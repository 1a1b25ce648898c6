from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scara_drake.common.fields import (
    ABOVE_ZERO,
    check,
    check_sampling,
    choice,
    number,
    resolve_files,
    spec_of,
    vector,
    words,
)


@dataclass
class Spring:
    stiffness: float = number(1.0, "N/m", ABOVE_ZERO, 10.0, symbol="K", equation="(52)")
    free: float = number(0.0, "m")
    mode: list[str] = words(["soft", "hard"], ("soft", "hard"))

    def check_together(self, name: str) -> None:
        if self.free > self.stiffness:
            raise ValueError(f"{name}.free: {self.free}, allowed up to the stiffness")

    def check_sampling(self, name: str, period: float) -> None:
        if self.stiffness * period > 1.0:
            raise ValueError(f"{name}.stiffness: {self.stiffness}, allowed up to 1 / period")


@dataclass
class Whole:
    law: str = choice("a", ("a", "b"))
    gains: list[float] = vector([1.0, 2.0], "1/s", 0.0)
    marks: list[float] = vector([], "s", 0.0, size=None)
    spring: Spring | None = None
    springs: list[Spring] = field(default_factory=list)
    name: str = ""


BAD = [
    (Whole(law="c"), r"w\.law: 'c', allowed a, b"),
    (Whole(gains=[1.0]), r"w\.gains: 1 entries, allowed 2"),
    (Whole(gains=[1.0, -1.0]), r"w\.gains\[1\]: -1\.0, allowed 0 or more, finite"),
    (Whole(marks=[0.0, math.nan]), r"w\.marks\[1\]: nan, allowed 0 or more, finite"),
    (Whole(spring=Spring(stiffness=0.0)), r"w\.spring\.stiffness: 0\.0, allowed above 0, up to 10"),
    (Whole(spring=Spring(mode=["soft", "x"])), r"w\.spring\.mode\[1\]: 'x', allowed soft, hard"),
    (Whole(spring=Spring(free=math.inf)), r"w\.spring\.free: inf, allowed any finite number"),
    (Whole(spring=Spring(free=2.0)), r"w\.spring\.free: 2\.0, allowed up to the stiffness"),
    (Whole(springs=[Spring(), Spring(20.0)]), r"w\.springs\[1\]\.stiffness: 20\.0, allowed above"),
]


@pytest.mark.parametrize(("part", "message"), BAD)
def test_what_is_out_of_its_bounds_is_named(part, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        check(part, "w")


def test_what_is_within_them_is_accepted_and_the_path_may_be_empty():
    check(Whole(spring=Spring(), springs=[Spring()], marks=[3.0] * 5), "w")
    with pytest.raises(ValueError, match=r"^spring\.stiffness: -1"):
        check(Whole(spring=Spring(-1.0)), "")


@given(st.floats(), st.floats(-1e9, 1e9), st.floats(-1e9, 1e9))
def test_a_number_is_accepted_exactly_within_its_bounds(value, one, other):
    low, high = min(one, other), max(one, other)

    @dataclass
    class Bounded:
        x: float = number(low, "1", low, high)

    inside = math.isfinite(value) and low <= value <= high
    if inside:
        check(Bounded(value), "b")
    else:
        with pytest.raises(ValueError, match=r"^b\.x: "):
            check(Bounded(value), "b")


def test_a_default_list_is_nobody_else_s():
    Whole().gains.append(3.0)
    assert Whole().gains == [1.0, 2.0]


def test_the_time_step_is_asked_of_every_part_below():
    check_sampling(Whole(spring=Spring(2.0)), "w", 0.5)
    with pytest.raises(ValueError, match=r"^w\.spring\.stiffness: 2\.0, allowed up to 1 / period"):
        check_sampling(Whole(spring=Spring(2.0)), "w", 0.6)


def test_a_spec_is_found_by_name():
    spec = spec_of(Spring, "stiffness")
    assert (spec.unit, spec.high, spec.symbol, spec.equation) == ("N/m", 10.0, "K", "(52)")
    assert spec_of(Whole(), "gains").size == 2
    with pytest.raises(ValueError, match=r"^name: not a field with bounds"):
        spec_of(Whole, "name")


def test_files_are_looked_for_in_the_folder_of_the_scenario():
    @dataclass
    class Trace:
        file: str = "a.csv"

        def resolve_files(self, folder: Path) -> None:
            self.file = str(folder / self.file)

    @dataclass
    class Top:
        trace: Trace = field(default_factory=Trace)

    top = Top()
    resolve_files(top, Path("/data"))
    assert top.trace.file == str(Path("/data/a.csv"))
