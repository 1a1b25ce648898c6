"""Writes the text of a function of kernels: calls, guards, and outputs where they are needed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from numba import float64, int64, types

from scara_drake.common.block import TIME, arguments_of
from scara_drake.engine.errors import NotCompilableError
from scara_drake.engine.graph import STATE, Buffer, Graph, Node, needed_inputs
from scara_drake.engine.store import reading

STORE_TICKS = "store_ticks"  # argument: of the declaration
# Why the function came back before its last tick.
DONE, NOT_FINITE, AT_LIMIT, NEAR = 0, 1, 2, 3
# The arguments before those of the blocks.
FIXED: dict[str, types.Type] = {
    **dict.fromkeys(("first", "count", "last"), int64),
    **dict.fromkeys(("duration", "period", "log_period"), float64),
    **dict.fromkeys(("cursor", "stop"), int64[::1]),
    "times": float64[::1],
    "records": float64[:, ::1],
    "address": int64,
    "places": int64[:, ::1],
}


@dataclass
class Source:
    """The text, and what it needs.

    Attributes:
        lines: of the function.
        kernels: that it calls, by their names in it, each with the names of what it is passed.
        arguments: buffers and parameters, by name, in order: the node, and the name of the memory,
            the output, the input or the parameter.
        guards: what each guard against NaN looks at: the node and its inputs.
        slow: nodes with a period of their own, in the order of `cursor`.
    """

    lines: list[str] = field(default_factory=list)
    kernels: dict[str, tuple[Any, list[str]]] = field(default_factory=dict)
    arguments: dict[str, tuple[str, str]] = field(default_factory=dict)
    guards: list[tuple[str, list[str]]] = field(default_factory=list)
    slow: list[str] = field(default_factory=list)

    def text(self, dimensions: Mapping[str, int]) -> str:
        """Return the function as it is compiled: fixed arguments, other numbers, kernels.

        Args:
            dimensions: of the arrays in the store, by name, in order.
        """
        numbers = [name for name in self.arguments if name not in dimensions]
        lines = [reading(name, row, n) for row, (name, n) in enumerate(dimensions.items())]
        head = f"def advance({', '.join([*FIXED, *numbers, *self.kernels])}):"
        return "\n".join([head, *(f"    {line}" for line in lines), *self.lines, ""])


class Writer:
    """Writes a `Source`; `source_of` is what to call.

    Args:
        graph: of the Diagram.
        period: of its ticks [s].
    """

    def __init__(self, graph: Graph, period: float) -> None:
        self.graph, self.made = graph, Source()
        self._depth, self._time = 1, TIME
        self._valid: set[Buffer] = set()
        updated = [node for node in graph.nodes.values() if node.declaration.update is not None]
        self.with_plant = [node for node in updated if node.declaration.with_plant]
        self.others = [node for node in updated if not node.declaration.with_plant]
        self.sampled = [node for node in graph.nodes.values() if node.declaration.sample]
        self.slow = [node for node in self.others if _is_slow(node, period)]
        for node in self.with_plant:
            if _is_slow(node, period):
                raise NotCompilableError(
                    f"{node.name}: a period of {node.declaration.period:g} s beside that of the "
                    f"plant, with which it steps, {period:g} s"
                )
        self.made.slow = [node.name for node in self.slow]

    def line(self, text: str) -> None:
        """Write a line."""
        self.made.lines.append("    " * self._depth + text)

    def leave(self) -> None:
        """Write how the function comes back before its time, with the samples that it has."""
        self.line("cursor[0], cursor[1] = row, logged")
        self.line("return k")

    @contextmanager
    def block(self, head: str) -> Iterator[None]:
        """Write the lines within, if there are any, under a head such as ``if ...:``."""
        self.line(head)
        before = len(self.made.lines)
        self._depth += 1
        yield
        self._depth -= 1
        if len(self.made.lines) == before:
            self.made.lines.pop()

    @contextmanager
    def maybe(self, condition: str, time: str = TIME) -> Iterator[None]:
        """Write what happens under a condition, at another time; what it computes is forgotten."""
        known, before = set(self._valid), self._time
        self._time = time
        if time != TIME:
            self._valid = set()
        with self.block(f"if {condition}:"):
            yield
        self._time = before
        self._valid = known & self._valid if time == TIME else known

    def argument(self, name: str, node: str, of: str) -> str:
        """Take an argument; return its name in the text."""
        self.made.arguments[name] = (node, of)
        return name

    def buffer(self, buffer: Buffer) -> str:
        """Return the name of a buffer in the text."""
        if buffer == STATE:
            return str(buffer)
        return self.argument(str(buffer), buffer.node, buffer.name)

    def run(self, name: str, kernel: Any, passed: list[str]) -> str:
        """Return the text of the call of a kernel, by its name in the text."""
        self.made.kernels[name] = (kernel, passed)
        return f"{name}({', '.join(passed)})"

    def need(self, buffer: Buffer | None) -> None:
        """Write what computes an output, unless it stands in its buffer already."""
        if buffer is None or buffer in self._valid or not self.is_output(buffer):
            return
        node = self.graph.nodes[buffer.node]
        output = node.declaration.outputs[buffer.name]
        for name in needed_inputs(node, output.kernel):
            self.need(node.reads[name])
        self.call(node, output.kernel, {buffer.name: self.buffer(buffer)})
        self._valid.add(buffer)

    def is_output(self, buffer: Buffer) -> bool:
        """Whether a buffer is computed when it is asked for."""
        return buffer != STATE and buffer.name in self.graph.nodes[buffer.node].declaration.outputs

    def changed(self, *written: str) -> None:
        """Forget the outputs that depend on nodes whose memory was written."""
        self._valid = {b for b in self._valid if not self._sources(b) & set(written)}

    def _sources(self, buffer: Buffer) -> set[str]:
        """Return the nodes on whose memory an output depends; the plant is one."""
        if not self.is_output(buffer):
            return {buffer.node}
        node = self.graph.nodes[buffer.node]
        names = arguments_of(node.declaration.outputs[buffer.name].kernel)
        found = {node.name} if set(names) & set(node.declaration.memory) else set()
        for name in names:
            read = node.reads.get(name)
            if read is not None:
                found |= self._sources(read)
        return found

    def call(self, node: Node, kernel: Any, instead: dict[str, str]) -> None:
        """Write the call of a kernel, guarded where its inputs have to be finite.

        Args:
            node: whose kernel it is.
            kernel: compiled.
            instead: names in the text, in place of those of some arguments.
        """
        is_ = node.declaration
        passed, watched = [], []
        for name in arguments_of(kernel):
            if name in instead:
                passed.append(instead[name])
            elif name == TIME:
                passed.append(self._time)
            elif name in is_.inputs:
                passed.append(self._input(node, name))
            elif name in is_.memory or name in is_.archive:
                passed.append(self.buffer(node.memory(name)))
            else:
                passed.append(self.argument(f"{node.name}__{name}", node.name, name))
            if name in is_.inputs and is_.inputs[name].finite:
                watched.append((name, passed[-1]))
        if watched:
            self._guard(node, watched)
        self.line(self.run(f"{node.name}__{kernel.__name__}", kernel, passed))

    def _input(self, node: Node, name: str) -> str:
        buffer = node.reads[name]
        if buffer is not None:
            return self.buffer(buffer)
        if node.declaration.inputs[name].default is None:
            raise NotCompilableError(f"{node.name}: its input '{name}' is not connected")
        return self.argument(f"{node.name}__{name}", node.name, name)

    def _guard(self, node: Node, watched: list[tuple[str, str]]) -> None:
        names = [name for _, name in watched]
        pairs = zip(names[::2], [*names[1::2], names[-1]], strict=False)
        tests = " and ".join(f"all_finite({a}, {b})" for a, b in pairs)
        with self.block(f"if not ({tests}):"):
            self.line(f"stop[0], stop[1] = {NOT_FINITE}, {len(self.made.guards)}")
            self.leave()
        self.made.guards.append((node.name, [name for name, _ in watched]))

    def update(self, node: Node, copies: set[tuple[str, Buffer]]) -> None:
        """Write an update, or the rest where it is not enabled, and the store before it."""
        is_ = node.declaration
        if is_.store is not None:
            count = f"{node.name}__count" if node in self.slow else "k"
            ticks = self.argument(f"{node.name}__{STORE_TICKS}", node.name, STORE_TICKS)
            with self.block(f"if {count} % {ticks} == 0:"):
                self.call(node, is_.store, {})
        instead = {
            name: f"{buffer}__before"
            for name, buffer in node.reads.items()
            if buffer is not None and (node.name, buffer) in copies
        }
        enable = node.reads.get(is_.enable) if is_.rest is not None else None
        if enable is None:
            self.call(node, is_.update, instead)
        else:
            gate = instead.get(is_.enable, self.buffer(enable))
            with self.block(f"if {gate}[0] >= ENABLED:"):
                self.call(node, is_.update, instead)
            with self.block("else:"):
                self.call(node, is_.rest, instead)


def _is_slow(node: Node, period: float) -> bool:
    return node.declaration.period != period or node.declaration.offset != 0.0
