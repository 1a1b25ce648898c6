"""The source of one function that advances a whole Diagram tick by tick.

It does at each tick what Drake's Simulator does: the samples are taken, the plant steps together
with the blocks that belong to it, and then all other blocks are updated with what the others had
before. A block with a period of its own is updated where its own time says so; that differs from
the time of a tick in the last bits sometimes, and comes before it or after it then.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from scara_drake.common.block import TIME, arguments_of
from scara_drake.engine.errors import NotCompilableError
from scara_drake.engine.graph import STATE, Buffer, Graph, Node, needed_inputs
from scara_drake.engine.order import memory_reads, update_order

# Why the function came back before its last tick.
DONE, NOT_FINITE, AT_LIMIT, NEAR = 0, 1, 2, 3
FIXED = (
    "first, count, last, duration, period, log_period, watch, "
    "cursor, times, records, stop, arm, work, segments, surfaces, state"
)


@dataclass
class Source:
    """The text, and what it needs.

    Attributes:
        lines: of the function.
        kernels: that it calls, by their names in it.
        arguments: buffers and parameters behind `FIXED`, by name, in order: the node, and the name
            of the memory, the output, the input or the parameter.
        guards: what each guard against NaN looks at: the node and its inputs.
        slow: nodes with a period of their own, in the order of `cursor`.
    """

    lines: list[str] = field(default_factory=list)
    kernels: dict[str, Any] = field(default_factory=dict)
    arguments: dict[str, tuple[str, str]] = field(default_factory=dict)
    guards: list[tuple[str, list[str]]] = field(default_factory=list)
    slow: list[str] = field(default_factory=list)

    @property
    def text(self) -> str:
        """The function, as it is compiled."""
        head = f"def advance({FIXED}, {', '.join(self.arguments)}):"
        return "\n".join([head, *self.lines, ""])


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
        if any(_is_slow(node, period) for node in self.with_plant):
            raise NotCompilableError("a block that steps with the plant has another period")
        self.made.slow = [node.name for node in self.slow]

    def line(self, text: str) -> None:
        """Write a line."""
        self.made.lines.append("    " * self._depth + text)

    @contextmanager
    def block(self, head: str) -> Iterator[None]:
        """Write the lines within under a head such as ``if ...:``."""
        self.line(head)
        self._depth += 1
        yield
        self._depth -= 1

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
            return "state"
        return self.argument(str(buffer), buffer.node, buffer.name)

    def kernel(self, node: Node, kernel: Any) -> str:
        """Return the name of a kernel in the text."""
        name = f"{node.name}__{kernel.__name__}"
        self.made.kernels[name] = kernel
        return name

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
            elif name in is_.memory:
                passed.append(self.buffer(node.memory(name)))
            else:
                passed.append(self.argument(f"{node.name}__{name}", node.name, name))
            if name in is_.inputs and is_.inputs[name].finite:
                watched.append((name, passed[-1]))
        if watched:
            self._guard(node, watched)
        self.line(f"{self.kernel(node, kernel)}({', '.join(passed)})")

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
            self.line("return k")
        self.made.guards.append((node.name, [name for name, _ in watched]))

    def update(self, node: Node, copies: set[tuple[str, Buffer]]) -> None:
        """Write an update, or the rest where it is not enabled."""
        is_ = node.declaration
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


def source_of(graph: Graph, period: float) -> Source:
    """Return the source that advances a graph with ticks of a period [s].

    Raises:
        NotCompilableError: an input is not connected, or a period does not go with the plant's.
    """
    w = Writer(graph, period)
    w.line("row, logged = cursor[0], cursor[1]")
    w.line("log_due = logged * log_period")
    for index, node in enumerate(w.slow, start=2):
        w.line(f"{node.name}__count = cursor[{index}]")
        w.line(f"{node.name}__due = {_due(node)}")
    with w.block("for k in range(first, first + count):"):
        w.line("t = k * period if k < last else duration")
        _late_updates(w)
        _samples(w)
        with w.block("if k == last:"):
            w.line("break")
        _plant(w)
        _updates(w)
        with w.block("if k % watch == 0 and any_link_near(segments, surfaces, arm, work, watch):"):
            w.line(f"stop[0] = {NEAR}")
            w.line("break")
    w.line("cursor[0], cursor[1] = row, logged")
    for index, node in enumerate(w.slow, start=2):
        w.line(f"cursor[{index}] = {node.name}__count")
    w.line("return k + 1")
    return w.made


def _due(node: Node) -> str:
    return f"{node.declaration.offset!r} + {node.name}__count * {node.declaration.period!r}"


def _advance(w: Writer, node: Node) -> None:
    w.line(f"{node.name}__count += 1")
    w.line(f"{node.name}__due = {_due(node)}")


def _late_updates(w: Writer) -> None:
    """Write the updates whose time lies a rounding before the tick's."""
    for node in w.slow:
        due = f"{node.name}__due"
        with w.maybe(f"{due} < t", due):
            for buffer in node.reads.values():
                w.need(buffer)
            w.update(node, set())
            _advance(w, node)


def _samples(w: Writer) -> None:
    """Write how a sample is recorded."""
    with w.maybe("log_due <= t", "log_due"):
        w.line("times[row] = log_due")
        start = 0
        for buffer in w.graph.recorded:
            w.need(buffer)
            w.line(f"put({w.buffer(buffer)}, records, row, {start})")
            start += buffer_size(w.graph, buffer)
        w.line("row += 1")
        w.line("logged += 1")
        w.line("log_due = logged * log_period")


def _plant(w: Writer) -> None:
    """Write the step of the plant, and of the blocks that are updated together with it."""
    graph = w.graph
    w.need(graph.actuation)
    w.need(graph.force)
    together = [*w.sampled, *w.with_plant]
    for node in together:
        kernel = node.declaration.sample or node.declaration.update
        for name in needed_inputs(node, kernel):
            w.need(node.reads[name])
    force = "no_force" if graph.force is None else w.buffer(graph.force)
    actuation = w.buffer(graph.actuation)
    # Into arrays of the step's own: the blocks that step with the plant may write over them.
    w.line(f"set_efforts({actuation}, {force}, arm, work)")
    reads = {node.name: memory_reads(node, graph.nodes, node.reads) for node in together}
    order, copies = update_order([node.name for node in together], reads)
    _copy(w, copies)
    for name in order:
        node = graph.nodes[name]
        if node.declaration.sample is not None:
            w.call(node, node.declaration.sample, {})
        else:
            w.update(node, copies)
    with w.block("if not plant_step(arm, work, state):"):
        w.line(f"stop[0] = {AT_LIMIT}")
        w.line("return k")
    w.changed(STATE.node, *order)


def _updates(w: Writer) -> None:
    """Write the updates of all other blocks, from the sink to the source."""
    graph = w.graph
    for node in w.others:
        for kernel in (node.declaration.update, node.declaration.rest):
            if kernel is not None and node not in w.slow:
                for name in needed_inputs(node, kernel):
                    w.need(node.reads[name])
    for node in w.slow:
        if any(buffer and w.is_output(buffer) for buffer in node.reads.values()):
            with w.maybe(f"{node.name}__due == t"):
                for buffer in node.reads.values():
                    w.need(buffer)
    reads = {node.name: memory_reads(node, graph.nodes, node.reads) for node in w.others}
    order, copies = update_order([node.name for node in w.others], reads)
    _copy(w, copies)
    for name in order:
        node = graph.nodes[name]
        if node in w.slow:
            with w.maybe(f"{name}__due == t"):
                w.update(node, copies)
                _advance(w, node)
        else:
            w.update(node, copies)
    w.changed(*order, *graph.nodes)


def _copy(w: Writer, copies: set[tuple[str, Buffer]]) -> None:
    for buffer in sorted({buffer for _, buffer in copies}, key=str):
        before = w.argument(f"{buffer}__before", buffer.node, buffer.name)
        w.line(f"put_all({w.buffer(buffer)}, {before})")


def buffer_size(graph: Graph, buffer: Buffer) -> int:
    """Return how many entries a buffer has."""
    if buffer == STATE:
        return 12
    is_ = graph.nodes[buffer.node].declaration
    if buffer.name in is_.outputs:
        return is_.outputs[buffer.name].size
    initial: Any = is_.memory[buffer.name].initial
    return initial if isinstance(initial, int) else len(initial)
