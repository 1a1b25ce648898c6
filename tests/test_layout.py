from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numba import njit

from scara_drake.common.layout import REST, Array, Cell, Layout


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


class Row(NamedTuple):
    gain: float
    count: Cell
    table: Array
    rest: Array


ROW = Layout(Row, count=(), table=(2, 3), rest=REST)
row_of = ROW.reader()


@njit
def step(row: Array) -> float:
    r = row_of(row)
    r.count[()] += 1.0
    r.table[1] *= r.gain
    r.rest[-1] = r.rest.size
    return r.gain


@pytest.mark.parametrize("length", [1, 4])
def test_a_kernel_reads_and_writes_by_name(length: int) -> None:
    row = ROW.pack(gain=3.0, count=7.0, table=np.arange(6.0).reshape(2, 3), rest=np.zeros(length))
    assert (ROW.size, row.size) == (8, 8 + length)
    assert step(row) == 3.0
    assert row.tolist() == [3.0, 8.0, 0.0, 1.0, 2.0, 9.0, 12.0, 15.0, *[0.0] * (length - 1), length]
    names = ROW.unpack(row)
    assert (names.gain, float(names.count)) == (3.0, 8.0)
    assert names.table.tolist() == [[0.0, 1.0, 2.0], [9.0, 12.0, 15.0]]
    assert names.rest.size == length


def test_zeros_leaves_the_rest_empty() -> None:
    assert ROW.zeros(gain=2.0).tolist() == [2.0, *[0.0] * 7]


def test_wrong_fields_are_named() -> None:
    with pytest.raises(ValueError, match=r"^Row\.rest: no shape, allowed one for an array$"):
        Layout(Row, count=(), table=(2, 3))
    with pytest.raises(ValueError, match=r"^Row\.table: REST, allowed for the last field$"):
        Layout(Row, count=(), table=REST, rest=2)
    with pytest.raises(ValueError, match=r"^table: shape \(3,\), allowed \(2, 3\)$"):
        ROW.zeros(table=np.zeros(3))
    with pytest.raises(ValueError, match=r"^rest: shape \(1, 2\), allowed \(2,\)$"):
        ROW.zeros(rest=np.zeros((1, 2)))
    with pytest.raises(ValueError, match=r"^Row: size, allowed gain, count, table, rest$"):
        ROW.zeros(size=1.0)


def test_readers_have_names_of_their_own() -> None:
    # numba links cached kernels by name: two readers of one name would read by one's layout.
    def name(layout: Layout[Row]) -> str:
        return str(layout.reader().py_func.__name__)  # type: ignore[attr-defined]  # a dispatcher

    longer = Layout(Row, count=(), table=(3, 3), rest=REST)
    assert name(ROW) != name(longer)
    assert name(ROW) == name(Layout(Row, count=(), table=(2, 3), rest=REST))


class Grown(NamedTuple):
    c: Array
    leak: Array = np.zeros(2)


def test_a_field_that_is_not_given_has_its_default():
    layout = Layout(Grown, c=2, leak=2)
    assert layout.pack(c=[1.0, 2.0]).tolist() == [1.0, 2.0, 0.0, 0.0]
    assert layout.pack(c=[1.0, 2.0], leak=[3.0, 4.0]).tolist() == [1.0, 2.0, 3.0, 4.0]
