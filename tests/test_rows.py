"""Tables whose rows have names."""

from typing import NamedTuple

import numpy as np
import pytest
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.layout import Rows

Array = NDArray[np.float64]


class Inner(NamedTuple):
    a: Array
    b: Array


class Outer(NamedTuple):
    first: Array
    inner: Array
    last: Array


INNER = Rows(Inner)
OUTER = Rows(Outer, inner=INNER.size)
inner_of, outer_of = INNER.reader(), OUTER.reader()


@njit
def change(table):
    o = outer_of(table)
    i = inner_of(o.inner)
    for j in range(o.first.size):
        o.last[j] = o.first[j] + 10.0 * i.a[j] + 100.0 * i.b[j]


@pytest.mark.parametrize("n", [1, 3])
@pytest.mark.parametrize("flat", [False, True])
def test_a_kernel_reads_and_writes_the_rows_by_name(n, flat):
    first = np.arange(1.0, n + 1.0)
    inner = INNER.pack(a=2.0, b=3.0 * first)
    table = OUTER.pack(first=first, inner=inner, last=0.0)
    assert table.shape == (OUTER.size, n) == (4, n)
    memory = table.ravel() if flat else table
    change(memory)
    names = OUTER.unpack(memory)
    np.testing.assert_array_equal(names.last, first + 20.0 + 300.0 * first)
    np.testing.assert_array_equal(INNER.unpack(names.inner).b, 3.0 * first)


def test_what_is_unpacked_are_views():
    table = INNER.pack(a=[1.0, 2.0], b=0.0)
    INNER.unpack(table).b[:] = 5.0
    np.testing.assert_array_equal(table, [[1.0, 2.0], [5.0, 5.0]])


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"a": 1.0}, "^Inner: b, allowed a, b"),
        ({"a": 1.0, "b": 1.0, "c": 1.0}, "^Inner: c, allowed a, b"),
        ({"a": [1.0, 2.0], "b": [1.0, 2.0, 3.0]}, "broadcast"),
    ],
)
def test_what_does_not_fit_is_refused(values, message):
    with pytest.raises(ValueError, match=message):
        INNER.pack(**values)
