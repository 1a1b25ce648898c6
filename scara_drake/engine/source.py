"""The source of one function that advances a whole Diagram tick by tick.

It does at each tick what Drake's Simulator does: the samples are taken, the plant steps together
with the blocks that belong to it, and then all other blocks are updated with what the others had
before. A block with a period of its own is updated where its own time says so; that differs from
the time of a tick in the last bits sometimes, and comes before it or after it then.
"""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from typing import Any

from scara_drake.common.block import TIME
from scara_drake.dynamics.equations import plant_step, set_efforts
from scara_drake.engine.graph import STATE, Buffer, Graph, Node, needed_inputs
from scara_drake.engine.order import memory_reads, update_order
from scara_drake.engine.watch import is_fast, ticks_clear
from scara_drake.engine.writer import AT_LIMIT, NEAR, Source, Writer


def source_of(graph: Graph, period: float) -> Source:
    """Return the source that advances a graph with ticks of a period [s].

    Raises:
        NotCompilableError: an input is not connected, or a period does not go with the plant's.
    """
    w = Writer(graph, period)
    w.line("row, logged = cursor[0], cursor[1]")
    w.line("log_due = logged * log_period")
    for index, node in enumerate(w.slow):
        w.line(f"{node.name}__count = cursor[{2 + index}]")
        w.line(f"{node.name}__due = {_due(w, node)}")
    w.line("look = first")
    with w.block("for k in range(first, first + count):"):
        w.line("t = k * period if k < last else duration")
        _until_tick(w)
        with w.block("if k == last:"):
            w.line("break")
        _plant(w)
        _update(w, w.others, TIME)
        with w.block(f"if k >= look or {w.run('is_fast', is_fast, ['surfaces', 'state'])}:"):
            looked_at = ["segments", "surfaces", "arm", "work", "state"]
            w.line(f"clear = {w.run('ticks_clear', ticks_clear, looked_at)}")
            w.line("look = k + clear")
            with w.block("if clear < 1:"):
                w.line(f"stop[0] = {NEAR}")
                w.line("break")
    w.line("cursor[0], cursor[1] = row, logged")
    for index, node in enumerate(w.slow):
        w.line(f"cursor[{2 + index}] = {node.name}__count")
    w.line("return k + 1")
    return w.made


def _due(w: Writer, node: Node) -> str:
    """Return the text of when a slow block is updated next: offset + n period."""
    row = w.slow.index(node)
    return f"slow[{row}, 0] + {node.name}__count * slow[{row}, 1]"


def _advance(w: Writer, node: Node) -> None:
    w.line(f"{node.name}__count += 1")
    w.line(f"{node.name}__due = {_due(w, node)}")


def _until_tick(w: Writer) -> None:
    """Write the samples up to the tick's time and the updates before it, the earliest first."""
    with w.block("while True:"):
        dues = ", ".join(f"{node.name}__due" for node in w.slow)
        w.line(f"due = min(t, {dues})" if w.slow else "due = t")
        with w.maybe("log_due <= due", "log_due"):
            _sample(w)
            w.line("continue")
        with w.block("if not due < t:"):
            w.line("break")
        _update(w, w.slow, "due")


def _sample(w: Writer) -> None:
    """Write how a sample is recorded."""
    w.line("times[row] = log_due")
    # No numbers: numba would compile `put` anew for each of them.
    w.line("start = 0")
    for buffer in w.graph.recorded:
        w.need(buffer)
        w.line(f"start = put({w.buffer(buffer)}, records, row, start)")
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
        if node.declaration.sample is None:
            _need(w, node)
            continue
        for name in needed_inputs(node, node.declaration.sample):
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
        w.leave()
    w.changed(STATE.node, *order)


def _update(w: Writer, nodes: list[Node], time: str) -> None:
    """Write the updates of some blocks at a time, from the sink to the source.

    Of those with a period of their own, the ones that are due.
    """
    for node in nodes:
        with _if_due(w, node, time):
            _need(w, node)
    reads = {node.name: memory_reads(node, w.graph.nodes, node.reads) for node in nodes}
    order, copies = update_order([node.name for node in nodes], reads)
    _copy(w, copies)
    for name in order:
        node = w.graph.nodes[name]
        with _if_due(w, node, time):
            w.update(node, copies)
            if node in w.slow:
                _advance(w, node)


def _need(w: Writer, node: Node) -> None:
    """Write what computes the outputs that an update reads, or the rest in its place."""
    is_ = node.declaration
    for kernel in (is_.update, is_.rest):
        if kernel is not None:
            for name in needed_inputs(node, kernel):
                w.need(node.reads[name])
    if is_.rest is not None:
        w.need(node.reads.get(is_.enable))


def _if_due(w: Writer, node: Node, time: str) -> AbstractContextManager[None]:
    """Return the condition under which a block is updated at a time; none for one of each tick."""
    return w.maybe(f"{node.name}__due == {time}", time) if node in w.slow else nullcontext()


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
