"""NaN and infinity at the input ports of a system: found fast, and told well."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydrake.systems.framework import Context, InputPort, LeafSystem

Array = NDArray[np.float64]


@njit(cache=True)
def all_finite(first: Array, second: Array) -> bool:
    """Whether no entry of two arrays is infinite or NaN."""
    total = 0.0
    for value in first:
        total += 0.0 * value
    for value in second:
        total += 0.0 * value
    return total == 0.0


def check_finite(system: LeafSystem, context: Context, ports: tuple[InputPort, ...]) -> None:
    """Stop a run in which NaN or infinity arrives on one of the input ports.

    Raises:
        RuntimeError: names the system, the port, the time and the entry.
    """
    for port in ports:
        values = port.Eval(context)
        for index in np.flatnonzero(~np.isfinite(values)):
            raise RuntimeError(
                f"{system.get_name()}: port '{port.get_name()}' at t = {context.get_time():.6g} s: "
                f"{port.get_name()}[{index}] is {values[index]}"
            )
