"""Small arrays on the stack of a kernel, for what it works out on its way.

`numpy.empty` in a kernel asks for memory and counts references to it, some 50 ns each time, as
much as a rotation costs. `scratch` costs nothing. It must not outlive the kernel that made it.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import lower_builtin, type_callable
from numba.np.arrayobj import make_array, populate_array
from numpy.typing import NDArray

Array = NDArray[np.float64]


def scratch(rows: int, columns: int = 0) -> Array:
    """Return an array (rows, columns), or (rows,), with anything in it.

    In a kernel the shape is written out as numbers, and the array is neither returned nor kept.
    """
    return np.empty((rows, columns) if columns else rows)


@type_callable(scratch)
def _type(context: Any) -> Any:
    def typer(rows: Any, columns: Any = None) -> Any:
        shape = (rows,) if columns is None else (rows, columns)
        if all(isinstance(length, types.IntegerLiteral) for length in shape):
            return types.Array(types.float64, len(shape), "C")
        return None

    return typer


@lower_builtin(scratch, types.IntegerLiteral)
@lower_builtin(scratch, types.IntegerLiteral, types.IntegerLiteral)
def _lower(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    lengths = [length.literal_value for length in signature.args if length is not None]
    word = context.get_value_type(types.intp)
    item = context.get_abi_sizeof(context.get_data_type(types.float64))
    room = cgutils.alloca_once(builder, ir.ArrayType(ir.DoubleType(), math.prod(lengths)))
    array = make_array(signature.return_type)(context, builder)
    strides = [item * math.prod(lengths[axis + 1 :]) for axis in range(len(lengths))]
    populate_array(
        array,
        data=builder.bitcast(room, array.data.type),
        shape=[ir.Constant(word, length) for length in lengths],
        strides=[ir.Constant(word, stride) for stride in strides],
        itemsize=ir.Constant(word, item),
        meminfo=None,
    )
    return array._getvalue()
