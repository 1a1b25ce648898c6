"""What the engine says of NaN and infinity: what `common.finite` says of them in Drake."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from scara_drake.engine.graph import Graph, Node

Array = NDArray[np.float64]


def first_not_finite(graph: Graph, buffers: Mapping[str, Array], time: float) -> str:
    """Tell of the output with NaN or infinity whose block has none at its inputs; "" for none.

    Args:
        graph: of the Diagram.
        buffers: what is in them, by name.
        time: [s].
    """
    for node in graph.nodes.values():
        if input_not_finite(node, node.reads, buffers, time):
            continue
        shown = [name for name, memory in node.declaration.memory.items() if memory.port]
        for name in (*shown, *node.declaration.outputs):
            told = _tell(node, name, buffers.get(str(node.memory(name))), time)
            if told:
                return told
    return ""


def input_not_finite(
    node: Node, inputs: Iterable[str], buffers: Mapping[str, Array], time: float
) -> str:
    """Tell of the first of some inputs of a block with NaN or infinity; "" for none."""
    told = (_tell(node, name, buffers.get(str(node.reads[name])), time) for name in inputs)
    return next(filter(None, told), "")


def _tell(node: Node, port: str, values: Array | None, time: float) -> str:
    if values is None or np.isfinite(values).all():
        return ""
    wrong = np.flatnonzero(~np.isfinite(values))
    return (
        f"{node.name}: port '{port}' at t = {time:.6g} s: {port}[{wrong[0]}] is {values[wrong[0]]}"
    )
