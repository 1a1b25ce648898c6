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
from numpy.typing import NDArray

Array = NDArray[np.float64]

MOST_DIMENSIONS = 3


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


@intrinsic
def pointer_to(typing_context: Any, address: Any) -> Any:
    """Return an address as a pointer, for `carray`."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.inttoptr(arguments[0], cgutils.voidptr_t)

    return types.voidptr(types.int64), code


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
    shape = [f"places[{row}, {1 + axis}]" for axis in range(dimensions)]
    end = " * ".join(shape)
    text = f"{name} = memory[places[{row}, 0] : places[{row}, 0] + {end}]"
    return text if dimensions == 1 else f"{text}.reshape(({', '.join(shape)}))"
