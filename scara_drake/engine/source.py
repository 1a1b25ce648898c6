"""The source of one function that advances a whole Diagram tick by tick.

It does at each tick what Drake's Simulator does: the samples are taken, the plant steps together
with the blocks that belong to it, and then all other blocks are updated with what the others had
before. A block with a period of its own is updated where its own time says so; that differs from
the time of a tick in the last bits sometimes, and comes before it or after it then.
"""

from __future__ import annotations

from typing import Any

from scara_drake.engine.dynamics import plant_step, set_efforts
from scara_drake.engine.graph import STATE, Buffer, Graph, Node, needed_inputs
from scara_drake.engine.order import memory_reads, update_order
from scara_drake.engine.watch import ticks_clear
from scara_drake.engine.writer import AT_LIMIT, NEAR, Source, Writer


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
    w.line("look = first")
    with w.block("for k in range(first, first + count):"):
        w.line("t = k * period if k < last else duration")
        _late_updates(w)
        _samples(w)
        with w.block("if k == last:"):
            w.line("break")
        _plant(w)
        _updates(w)
        with w.block("if k >= look:"):
            looked_at = ["segments", "surfaces", "arm", "work"]
            w.line(f"clear = {w.run('ticks_clear', ticks_clear, looked_at)}")
            w.line("look = k + clear")
            with w.block("if clear < 1:"):
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
    w.line(w.run("set_efforts", set_efforts, [actuation, force, "arm", "work"]))
    reads = {node.name: memory_reads(node, graph.nodes, node.reads) for node in together}
    order, copies = update_order([node.name for node in together], reads)
    _copy(w, copies)
    for name in order:
        node = graph.nodes[name]
        if node.declaration.sample is not None:
            w.call(node, node.declaration.sample, {})
        else:
            w.update(node, copies)
    with w.block(f"if not {w.run('plant_step', plant_step, ['arm', 'work', 'state'])}:"):
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
