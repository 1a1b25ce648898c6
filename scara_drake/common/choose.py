"""One compiled function out of a table, chosen by number inside a kernel."""

from __future__ import annotations

import inspect
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
    names = inspect.signature(getattr(functions[0], "py_func", functions[0])).parameters
    arguments = ", ".join(names)
    scope: dict[str, Any] = {f"f{index}": each for index, each in enumerate(functions)}
    last = len(functions) - 1
    lines = [f"    if number == {k}: return f{k}({arguments})" for k in range(last)]
    body = "\n".join([*lines, f"    return f{last}({arguments})"])
    exec(f"def choose(number, {arguments}):\n{body}", scope)
    choose: Function = njit(scope["choose"])
    return choose
