"""All arrays of a run in one piece of memory, which the compiled function has by its address.

An array that numba gets from Python counts its references, and so does each view of it: atomic
operations that cost as much as a small kernel. One made of an address counts none.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.arrayobj import populate_array
from numpy.typing import NDArray

Array = NDArray[np.float64]

MOST_DIMENSIONS = 3
ITEM = 8  # bytes of a number


class Store:
    """Arrays side by side.

    Attributes:
        memory: all of them (n,).
        places: where each is: its start and its shape, rows (n arrays, 1 + `MOST_DIMENSIONS`).
        views: of the arrays, by name.

    Args:
        values: what the arrays hold at the start, by name, in order.
    """

    def __init__(self, values: Mapping[str, Array]) -> None:
        ends = np.cumsum([0, *(value.size for value in values.values())])
        self.memory = np.empty(ends[-1])
        self.places = np.ones((len(values), 1 + MOST_DIMENSIONS), dtype=np.int64)
        self.views: dict[str, Array] = {}
        for place, start, (name, value) in zip(self.places, ends, values.items(), strict=False):
            place[0], place[1 : 1 + value.ndim] = start, value.shape
            view = self.memory[start : start + value.size].reshape(value.shape)
            view[...] = value
            self.views[name] = view

    @property
    def address(self) -> int:
        """Where the memory begins."""
        return self.memory.ctypes.data


def _viewing(dimensions: int) -> Any:
    """Return what gives a compiled function an array of a store, by its row in `places`.

    One operation for all of it: as slices of one array a hundred of them take as long to compile
    as all else.
    """
    kind = types.Array(types.float64, dimensions, "C")

    @intrinsic
    def view(typing_context: Any, address: Any, places: Any, row: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            table = context.make_array(places)(context, builder, arguments[1])

            def word(column: int) -> Any:
                at = [arguments[2], context.get_constant(types.intp, column)]
                return builder.load(cgutils.get_item_pointer(context, builder, places, table, at))

            step = context.get_constant(types.intp, ITEM)
            begin = builder.add(arguments[0], builder.mul(word(0), step))
            shape, strides = [word(1 + axis) for axis in range(dimensions)], [step]
            for length in reversed(shape[1:]):
                strides.insert(0, builder.mul(strides[0], length))
            array = context.make_array(kind)(context, builder)
            data = builder.inttoptr(begin, array.data.type)
            populate_array(array, data, shape, strides, step, meminfo=None)
            return array._getvalue()

        return kind(types.int64, places, types.int64), code

    return view


VIEWS = {f"view_{n}": _viewing(n) for n in range(1, 1 + MOST_DIMENSIONS)}


def is_stored(value: object) -> bool:
    """Whether a value is an array that a store takes."""
    return isinstance(value, np.ndarray) and 0 < value.ndim <= MOST_DIMENSIONS


def reading(name: str, row: int, dimensions: int) -> str:
    """Return the line that gives an array in the store its name.

    Args:
        name: in the text.
        row: of `places`.
        dimensions: of the array.
    """
    return f"{name} = view_{dimensions}(address, places, {row})"
