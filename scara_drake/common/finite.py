"""NaN and infinity at the input ports of a system: found fast, and told well."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydrake.systems.framework import (
    Context,
    Diagram,
    InputPort,
    LeafSystem,
    OutputPort,
    PortDataType,
    System,
)

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
        if not np.isfinite(values).all():
            raise RuntimeError(_tell(system, port, context, values))


@contextmanager
def naming_nan(diagram: Diagram, context: Context) -> Iterator[None]:
    """Let an error of Drake about a NaN name the system that made it.

    Args:
        diagram: that is simulated.
        context: its root context.

    Raises:
        RuntimeError: the error itself, or with the system, its output port, time and entry.
    """
    try:
        yield
    except RuntimeError as error:
        told = first_not_finite(diagram, context) if "NaN" in str(error) else ""
        if not told:
            raise
        raise RuntimeError(told) from error


def first_not_finite(diagram: Diagram, context: Context) -> str:
    """Tell of the output with NaN or infinity whose system has none at its inputs; "" for none."""
    for system in diagram.GetSystems():
        own = system.GetMyContextFromRoot(context)
        inputs = [system.get_input_port(i) for i in range(system.num_input_ports())]
        if any(not np.isfinite(_values(port, own)).all() for port in inputs if port.HasValue(own)):
            continue
        for index in range(system.num_output_ports()):
            port = system.get_output_port(index)
            values = _values(port, own)
            if not np.isfinite(values).all():
                return _tell(system, port, own, values)
    return ""


def _values(port: InputPort | OutputPort, context: Context) -> Array:
    if port.get_data_type() != PortDataType.kVectorValued:
        return np.zeros(0)
    values: Array = port.Eval(context)
    return values


def _tell(system: System, port: InputPort | OutputPort, context: Context, values: Array) -> str:
    name, index = port.get_name(), np.flatnonzero(~np.isfinite(values))[0]
    return (
        f"{system.get_name()}: port '{name}' at t = {context.get_time():.6g} s: "
        f"{name}[{index}] is {values[index]}"
    )
