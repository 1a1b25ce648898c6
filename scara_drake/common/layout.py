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

Numbers are copies. What a kernel writes has to be an array, be it a `Cell`, of shape (). The last
field may be `REST`: an array (n,) of whatever follows, as long as the array that is read.

`Rows` does the same for a table with a column a joint, for as many joints as it has columns.
"""

from __future__ import annotations

import math
import zlib
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
REST = -1  # shape of a last field that takes all entries that are left


class Layout(Generic[Names]):
    """Where each field of a NamedTuple stands in an array (size,).

    Args:
        names: the NamedTuple.
        shapes: of its fields that are arrays; every other field is a number.

    Attributes:
        size: of the array, without a `REST`.
        slices: of the array, by the name of the field.

    Raises:
        ValueError: a shape for a field that is not there, or none for one that is an array, or
            `REST` for a field that is not the last.
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
            if known == (REST,):
                if name != fields[-1]:
                    raise ValueError(f"{names.__name__}.{name}: REST, allowed for the last field")
                self.slices[name] = slice(start, None)
                break
            stop = start + math.prod(known or ())
            self.slices[name] = slice(start, stop)
            start = stop
        self.size = start

    def pack(self, **values: ArrayLike) -> Array:
        """Return a new array (size,) with the values by name; a `REST` makes it longer.

        A field that is not given has the default of the NamedTuple.

        Raises:
            ValueError: a field is missing or unknown, or a value has not its shape.
        """
        values = _defaults(self.names) | values
        if values.keys() != self.slices.keys():
            wrong = ", ".join(sorted(values.keys() ^ self.slices.keys()))
            raise ValueError(f"{self.names.__name__}: {wrong}, allowed {', '.join(self.slices)}")
        parts = []
        for name, shape in self.shapes.items():
            value = np.asarray(values[name], dtype=np.float64)
            wanted = (value.size,) if shape == (REST,) else shape or ()
            if value.shape != wanted:
                raise ValueError(f"{name}: shape {value.shape}, allowed {wanted}")
            parts.append(np.ravel(value))
        return np.concatenate(parts)

    def zeros(self, **values: ArrayLike) -> Array:
        """Return a new array (size,), zero but for the values by name; a `REST` has no length."""
        shapes = {name: self.shapes[name] or () for name in self.slices}
        rest = {name: np.zeros(0 if at == (REST,) else at) for name, at in shapes.items()}
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
            elif shape == (REST,):
                parts.append(f"row[{where.start}:]")
            elif len(shape) == 1:
                parts.append(f"row[{where.start}:{where.stop}]")
            else:
                parts.append(f"row[{where.start}:{where.stop}].reshape({shape})")
        return _compiled(self.names, f"return Names({', '.join(parts)})")


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

        A field that is a table itself is (height, n), or (height, 1) for every column. One that is
        not given has the default of the NamedTuple.

        Raises:
            ValueError: a field is missing or unknown, or a value has not its shape.
        """
        values = _defaults(self.names) | values
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
        rows = f"rows = row.reshape({self.size}, row.size // {self.size})"
        return _compiled(self.names, f"{rows}\n    return Names({', '.join(parts)})")


def _defaults(names: type[Any]) -> dict[str, ArrayLike]:
    return dict(names._field_defaults)


def _compiled(names: type[Names], body: str) -> Callable[[Array], Names]:
    """Return the compiled function of an array `row` with a body that makes `Names`.

    numba links cached kernels by the names of what they call, so each reader has its own, in every
    process the same: with one name for all, a kernel would read by another's layout.
    """
    mark = zlib.crc32(f"{names.__module__} {body}".encode())
    name = f"read_{names.__name__}_{mark:08x}"
    scope: dict[str, Any] = {"Names": names, "__name__": names.__module__}
    exec(f"def {name}(row):\n    {body}", scope)
    read: Callable[[Array], Names] = njit(scope[name])
    return read
