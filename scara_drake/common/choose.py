"""One compiled function out of a table, chosen by number inside a kernel."""

from __future__ import annotations

import inspect
import zlib
from collections.abc import Callable, Sequence
from typing import Any

from numba import njit

Function = Callable[..., Any]


def chooser(functions: Sequence[Function]) -> Function:
    """Return the compiled ``choose(number, ...)``, which calls that one of compiled functions.

    The functions take and return the same types. It is written out as branches: then all of them
    are compiled into the kernel that calls it, and that kernel can be kept in numba's cache.

    Args:
        functions: the table, one or more.
    """
    plain = [getattr(each, "py_func", each) for each in functions]
    arguments = ", ".join(inspect.signature(plain[0]).parameters)
    scope: dict[str, Any] = {f"f{k}": each for k, each in enumerate(functions)}
    scope["__name__"] = __name__
    last = len(functions) - 1
    lines = [f"    if number == {k}: return f{k}({arguments})" for k in range(last)]
    body = "\n".join([*lines, f"    return f{last}({arguments})"])
    # As with the readers of layouts: numba links cached kernels by the names of what they call.
    table = " ".join(f"{each.__module__}.{each.__qualname__}" for each in plain)
    name = f"choose_{zlib.crc32(table.encode()):08x}"
    exec(f"def {name}(number, {arguments}):\n{body}", scope)
    choose: Function = njit(scope[name])
    return choose
