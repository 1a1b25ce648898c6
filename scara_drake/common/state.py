"""Discrete state of LeafSystems, declared in one line."""

from __future__ import annotations

from numpy.typing import ArrayLike
from pydrake.systems.framework import LeafSystem


def declare_state(system: LeafSystem, initial: ArrayLike | int, port: str = "") -> int:
    """Declare a group of discrete state; return its index.

    Args:
        system: of which it becomes a part.
        initial: its first value (n,), or n for zeros.
        port: name of an output port (n) that shows the group; none if empty.

    Returns:
        A plain int: `DiscreteValues.get_mutable_value` takes it faster than Drake's own index type,
        and a 1 kHz loop calls it twenty times a tick.
    """
    index = system.DeclareDiscreteState(initial)
    if port:
        system.DeclareStateOutputPort(port, index)
    return int(index)
