from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.layout import REST, Cell, Layout

Array = NDArray[np.float64]


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
