from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numba import njit

from scara_drake.common.layout import Array, Cell, Layout


class Mixed(NamedTuple):
    period: float
    x: Array
    count: Cell
    rows: Array
    last: float


MIXED = Layout(Mixed, x=3, count=(), rows=(2, 3))
mixed_of = MIXED.reader()


@njit
def change(row: Array) -> None:
    m = mixed_of(row)
    m.count[()] += m.period
    for i in range(m.x.size):
        m.rows[1, i] = m.x[i] + m.last


def test_entries_follow_each_other_without_a_gap():
    assert MIXED.size == 1 + 3 + 1 + 6 + 1
    stops = [where.stop for where in MIXED.slices.values()]
    starts = [where.start for where in MIXED.slices.values()]
    assert starts == [0, *stops[:-1]]


@given(st.lists(st.floats(allow_nan=False), min_size=12, max_size=12))
def test_packing_what_was_unpacked_gives_the_array_back(values):
    row = np.array(values)
    np.testing.assert_array_equal(MIXED.pack(**MIXED.unpack(row)._asdict()), row)


def test_a_kernel_reads_by_name_and_writes_through():
    row = MIXED.zeros(period=0.5, x=[1.0, 2.0, 3.0], last=10.0)
    change(row)
    change(row)
    names = MIXED.unpack(row)
    assert names.count == 1.0
    np.testing.assert_array_equal(names.rows, [[0.0, 0.0, 0.0], [11.0, 12.0, 13.0]])
    assert (names.period, names.last) == (0.5, 10.0)


def test_what_does_not_fit_is_named():
    with pytest.raises(ValueError, match=r"^Mixed: 'y', allowed period, x, count, rows, last$"):
        Layout(Mixed, y=3)
    with pytest.raises(ValueError, match=r"^Mixed\.count: no shape, allowed one for an array$"):
        Layout(Mixed, x=3, rows=(2, 3))
    with pytest.raises(ValueError, match=r"^Mixed: last, allowed period"):
        MIXED.pack(period=0.0, x=np.zeros(3), count=0.0, rows=np.zeros((2, 3)))
    with pytest.raises(ValueError, match=r"^x: shape \(2,\), allowed \(3,\)$"):
        MIXED.zeros(x=[1.0, 2.0])
