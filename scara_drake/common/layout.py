"""Names for the entries of an array: one array crosses into a kernel, inside it is read by name.

A layout is written as a NamedTuple; a field is a number (`float`) or an array of some shape. `pack`
makes the array outside, `reader` the compiled function that gives the names back inside::

    class Gains(NamedTuple):
        c: Array
        period: float

    GAINS = Layout(Gains, c=6)
    gains_of = GAINS.reader()

    @njit(cache=True)
    def law(gains: Array, ...) -> None:
        g = gains_of(gains)  # g.c is a view (6,), g.period a number

Numbers are copies. What a kernel writes has to be an array, be it a `Cell`, of shape ().

`Rows` does the same for a table with a column a joint, for as many joints as it has columns.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Generic, TypeAlias, TypeVar, get_type_hints

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Names = TypeVar("Names", bound=tuple[Any, ...])
Shape = int | tuple[int, ...]
# A number in memory: an array of shape (), read and written as `cell[()]`; the type checker takes
# what is read from it for an array.
Cell: TypeAlias = Any


class Layout(Generic[Names]):
    """Where each field of a NamedTuple stands in an array (size,).

    Args:
        names: the NamedTuple.
        shapes: of its fields that are arrays; every other field is a number.

    Raises:
        ValueError: a shape for a field that is not there, or none for one that is an array.
    """

    def __init__(self, names: type[Names], **shapes: Shape) -> None:
        self.names = names
        fields: tuple[str, ...] = names._fields  # type: ignore[attr-defined]  # a NamedTuple
        hints = get_type_hints(names)
        self.shapes: dict[str, tuple[int, ...] | None] = dict.fromkeys(fields)
        for name, shape in shapes.items():
            if name not in self.shapes:
                raise ValueError(f"{names.__name__}: '{name}', allowed {', '.join(fields)}")
            self.shapes[name] = (shape,) if isinstance(shape, int) else shape
        for name, known in self.shapes.items():
            if known is None and hints[name] is not float:
                raise ValueError(f"{names.__name__}.{name}: no shape, allowed one for an array")
        self.slices: dict[str, slice] = {}
        start = 0
        for name, known in self.shapes.items():
            stop = start + math.prod(known or ())
            self.slices[name] = slice(start, stop)
            start = stop
        self.size = start

    def pack(self, **values: ArrayLike) -> Array:
        """Return a new array (size,) with the values by name.

        Raises:
            ValueError: a field is missing or unknown, or a value has not its shape.
        """
        if values.keys() != self.slices.keys():
            wrong = ", ".join(sorted(values.keys() ^ self.slices.keys()))
            raise ValueError(f"{self.names.__name__}: {wrong}, allowed {', '.join(self.slices)}")
        row = np.empty(self.size)
        for name, value in values.items():
            shape = self.shapes[name] or ()
            if np.shape(value) != shape:
                raise ValueError(f"{name}: shape {np.shape(value)}, allowed {shape}")
            row[self.slices[name]] = np.ravel(np.asarray(value, dtype=np.float64))
        return row

    def zeros(self, **values: ArrayLike) -> Array:
        """Return a new array (size,), zero but for the values by name."""
        rest = {name: np.zeros(self.shapes[name] or ()) for name in self.slices}
        return self.pack(**(rest | values))

    def unpack(self, row: Array) -> Names:
        """Return the fields of an array (size,), views where they are arrays."""
        values: list[Any] = []
        for name, shape in self.shapes.items():
            part = row[self.slices[name]]
            values.append(float(part.item()) if shape is None else part.reshape(shape))
        return self.names(*values)

    def reader(self) -> Callable[[Array], Names]:
        """Return `unpack` compiled, for kernels; it costs nothing beside what it reads."""
        parts = []
        for name, shape in self.shapes.items():
            where = self.slices[name]
            if shape is None:
                parts.append(f"row[{where.start}]")
            elif len(shape) == 1:
                parts.append(f"row[{where.start}:{where.stop}]")
            else:
                parts.append(f"row[{where.start}:{where.stop}].reshape({shape})")
        scope: dict[str, Any] = {"Names": self.names}
        exec(f"def read(row):\n    return Names({', '.join(parts)})", scope)
        read: Callable[[Array], Names] = njit(scope["read"])
        return read


class Rows(Generic[Names]):
    """Names for the rows of a table (rows, n), such as gains with a column a joint.

    The table has its rows one after the other, so it may also be an array (rows n,), as memory is.

    Args:
        names: the NamedTuple; a field is a row (n,).
        heights: of its fields that are tables themselves, (height, n).
    """

    def __init__(self, names: type[Names], **heights: int) -> None:
        self.names = names
        fields: tuple[str, ...] = names._fields  # type: ignore[attr-defined]  # a NamedTuple
        self.places: dict[str, int | slice] = {}
        start = 0
        for name in fields:
            stop = start + heights.get(name, 1)
            self.places[name] = slice(start, stop) if name in heights else start
            start = stop
        self.size = start

    def pack(self, **values: ArrayLike) -> Array:
        """Return a new table (rows, n) with the values by name, each a number or (n,).

        A field that is a table itself is (height, n), or (height, 1) for every column.

        Raises:
            ValueError: a field is missing or unknown, or a value has not its shape.
        """
        if values.keys() != self.places.keys():
            wrong = ", ".join(sorted(values.keys() ^ self.places.keys()))
            raise ValueError(f"{self.names.__name__}: {wrong}, allowed {', '.join(self.places)}")
        n = max(np.atleast_1d(value).shape[-1] for value in values.values())
        table = np.empty((self.size, n))
        for name, value in values.items():
            table[self.places[name]] = value
        return table

    def unpack(self, table: Array) -> Names:
        """Return the rows of a table, or of an array (rows n,), as views."""
        rows = table.reshape(self.size, -1)
        return self.names(*(rows[place] for place in self.places.values()))

    def reader(self) -> Callable[[Array], Names]:
        """Return `unpack` compiled, for kernels; the table has to be in C order."""
        parts = [
            f"rows[{place.start}:{place.stop}]" if isinstance(place, slice) else f"rows[{place}]"
            for place in self.places.values()
        ]
        scope: dict[str, Any] = {"Names": self.names}
        lines = f"    rows = table.reshape({self.size}, table.size // {self.size})\n"
        exec(f"def read(table):\n{lines}    return Names({', '.join(parts)})", scope)
        read: Callable[[Array], Names] = njit(scope["read"])
        return read
