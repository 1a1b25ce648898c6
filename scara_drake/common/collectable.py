"""LeafSystems that are freed when nobody holds them."""

from __future__ import annotations

from typing import Any

from pydrake.systems.framework import LeafSystem


class Collectable(type(LeafSystem)):  # type: ignore[misc] # has no name in pydrake
    """Makes LeafSystems that the garbage collector can free, and with them their Diagram.

    In Python 3.11 it visits the attributes of an instance twice, once for Drake's class and once
    for the subclass, and takes them for held from outside. A subclass with slots has none.
    """

    def __new__(cls, name: str, bases: tuple[type, ...], namespace: dict[str, Any]) -> Collectable:
        """Make a class with slots, none of its own unless it names some."""
        return super().__new__(cls, name, bases, {"__slots__": (), **namespace})
