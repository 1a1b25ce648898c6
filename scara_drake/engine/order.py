"""In which order the blocks of a tick are updated, so that each reads what the others had before.

A block that reads the memory of another is updated before it: from the sink to the source, nothing
has to be kept twice. Where blocks read each other in a ring, one of the readings is of a copy.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from scara_drake.engine.graph import Buffer, Node


def update_order(
    readers: Iterable[str], reads: Mapping[str, set[Buffer]]
) -> tuple[list[str], set[tuple[str, Buffer]]]:
    """Return the order of some nodes, and which readings (node, buffer) have to be of a copy.

    Args:
        readers: names of the nodes that are updated at one instant.
        reads: the memory of other nodes that each reads.
    """
    waiting = list(readers)
    order: list[str] = []
    copies: set[tuple[str, Buffer]] = set()
    while waiting:
        free = next((name for name in waiting if not _still_read(name, waiting, reads)), None)
        if free is None:
            # A ring: the others read this one from a copy.
            free = min(waiting, key=lambda name: len(_still_read(name, waiting, reads)))
            copies |= _still_read(free, waiting, reads)
        order.append(free)
        waiting.remove(free)
    return order, copies


def _still_read(
    name: str, waiting: Iterable[str], reads: Mapping[str, set[Buffer]]
) -> set[tuple[str, Buffer]]:
    """Return what nodes that are still to be updated read of the memory of a node."""
    return {
        (other, buffer)
        for other in waiting
        if other != name
        for buffer in reads[other]
        if buffer.node == name
    }


def memory_reads(node: Node, nodes: Mapping[str, Node], inputs: Iterable[str]) -> set[Buffer]:
    """Return the memory of other nodes that some inputs of a node read directly."""
    buffers = (node.reads[name] for name in inputs)
    return {
        buffer
        for buffer in buffers
        if buffer is not None
        and buffer.node in nodes
        and buffer.name in nodes[buffer.node].declaration.memory
    }
