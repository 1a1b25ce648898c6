"""What happens at t = 0 before the first tick: each block begins with what the others have."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from scara_drake.common.block import ENABLED, TIME, arguments_of
from scara_drake.engine.build import first_value
from scara_drake.engine.graph import STATE, Buffer, Graph, Node

Array = NDArray[np.float64]


class Start:
    """Begins the blocks of a graph.

    Args:
        graph: of a Diagram.
        buffers: with their first values; written.
    """

    def __init__(self, graph: Graph, buffers: dict[str, Any]) -> None:
        self._nodes, self._buffers = graph.nodes, buffers

    def run(self) -> None:
        """Begin all blocks."""
        begun = [node for node in self._nodes.values() if node.declaration.initialize]
        changed: dict[str, Any] = {}
        for node in begun:
            kernel = self._kernel(node)
            memory = {
                name: np.array(self._value(node.memory(name)))
                for name in arguments_of(kernel)
                if name in node.declaration.memory
            }
            kernel(*(self._argument(node, name, memory) for name in arguments_of(kernel)))
            changed |= {str(node.memory(name)): value for name, value in memory.items()}
        for name, value in changed.items():
            if name in self._buffers:
                self._buffers[name][:] = value

    def _kernel(self, node: Node) -> Any:
        is_ = node.declaration
        enable, rest = node.reads.get(is_.enable), is_.rest_initialize or is_.rest
        if rest is None or enable is None or self._value(enable)[0] >= ENABLED:
            return is_.initialize
        return rest

    def _argument(self, node: Node, name: str, memory: dict[str, Array]) -> Any:
        if name in memory:
            return memory[name]
        if name == TIME:
            return 0.0
        if name in node.declaration.inputs and node.reads[name] is not None:
            return self._value(cast(Buffer, node.reads[name]))
        return first_value(node.declaration, name)

    def _value(self, buffer: Buffer) -> Array:
        """Return what stands in a buffer at t = 0."""
        if buffer == STATE:
            return self._buffers[str(buffer)]
        node = self._nodes[buffer.node]
        if buffer.name in node.declaration.memory:
            known = self._buffers.get(str(buffer))
            return first_value(node.declaration, buffer.name) if known is None else known
        value: Array = np.zeros(node.declaration.outputs[buffer.name].size)
        kernel = node.declaration.outputs[buffer.name].kernel
        memory = {buffer.name: value} | {
            name: self._value(node.memory(name))
            for name in arguments_of(kernel)
            if name in node.declaration.memory
        }
        kernel(*(self._argument(node, name, memory) for name in arguments_of(kernel)))
        return value
