"""A built Diagram as data: its blocks, and which buffer each of their inputs reads.

Every vector that crosses a port has a buffer: a group of memory, a computed output, the state of
the plant, or a constant. What the Diagram connects is read from the Diagram itself.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numba.core.dispatcher import Dispatcher
from numpy.typing import NDArray
from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Diagram, InputPort, OutputPort, System
from pydrake.systems.primitives import ConstantVectorSource, Multiplexer, VectorLogSink

from scara_drake.common.block import (
    Block,
    Declaration,
    Memory,
    arguments_of,
)
from scara_drake.engine.errors import NotCompilableError

Array = NDArray[np.float64]

PLANT = "plant"
# What the engine does of a declaration.
HANDLED = frozenset(
    {
        *("inputs", "memory", "outputs", "parameters", "enable"),
        *("period", "offset", "with_plant", "store_ticks"),
        *("update", "rest", "initialize", "rest_initialize", "sample"),
        *("archive", "store"),
    }
)


@dataclass(frozen=True)
class Buffer:
    """Where a vector stands: the group of memory, or the output, of a node."""

    node: str
    name: str

    def __str__(self) -> str:
        return self.name if self.node == PLANT else f"{self.node}__{self.name}"


STATE = Buffer(PLANT, "state")


@dataclass(frozen=True)
class Node:
    """A block in a Diagram.

    Attributes:
        name: in the Diagram.
        declaration: of the block.
        reads: the buffer of each input; None where nothing is connected.
    """

    name: str
    declaration: Declaration
    reads: dict[str, Buffer | None]

    def memory(self, name: str) -> Buffer:
        """Return the buffer of a group of memory, or of an output."""
        return Buffer(self.name, name)


@dataclass
class Graph:
    """What the engine runs of a Diagram.

    Attributes:
        nodes: the blocks, by name.
        plant: the robot.
        actuation: what its drives are asked for.
        force: the other generalized forces on it; None for none.
        recorded: what a sample is made of, in order.
    """

    nodes: dict[str, Node]
    plant: MultibodyPlant
    actuation: Buffer
    force: Buffer | None
    recorded: list[Buffer] = field(default_factory=list)


def graph_of(diagram: Diagram) -> Graph:
    """Return a Diagram of `make_diagram` as the engine reads it.

    Raises:
        NotCompilableError: a part of it can only run in Drake; names it.
    """
    systems = {system.get_name(): system for system in diagram.GetSystems()}
    wires = _wires(diagram)
    nodes = {
        name: Node(name, declaration, _reads(system, wires))
        for name, system in systems.items()
        if (declaration := declaration_of(system)) is not None
    }
    for node in nodes.values():
        _check_kernels(node)
    plant = systems[PLANT]
    if not isinstance(plant, MultibodyPlant):
        raise NotCompilableError(f"{PLANT}: {type(plant).__name__}, allowed a MultibodyPlant")
    actuation = wires.get((PLANT, plant.get_actuation_input_port().get_name()))
    force = wires.get((PLANT, plant.get_applied_generalized_force_input_port().get_name()))
    if actuation is None:
        raise NotCompilableError("controller: its effort does not lead to the plant")
    graph = Graph(nodes, plant, actuation, force)
    for system in systems.values():
        if isinstance(system, Multiplexer):
            for name, buffer in _reads(system, wires).items():
                if buffer is None:
                    raise NotCompilableError(f"{system.get_name()}: {name} comes from Drake itself")
                graph.recorded.append(buffer)
    return graph


def kernels_of(declaration: Declaration) -> Iterator[Any]:
    """Yield the kernels of a declaration."""
    is_ = declaration
    yield from (is_.update, is_.rest, is_.sample, is_.store)
    yield from (is_.initialize, is_.rest_initialize)
    yield from (output.kernel for output in is_.outputs.values())


def _check_kernels(node: Node) -> None:
    """Check that all that a block runs is compiled, on arrays.

    Raises:
        NotCompilableError: something is not.
    """
    for kernel in kernels_of(node.declaration):
        if kernel is not None and not isinstance(kernel, Dispatcher):
            name = getattr(kernel, "__qualname__", type(kernel).__qualname__)
            raise NotCompilableError(f"{node.name}: {name} is plain Python")
    for name, port in node.declaration.inputs.items():
        if port.value is not None:
            raise NotCompilableError(f"{node.name}: its input '{name}' is no vector")


def declaration_of(system: System) -> Declaration | None:
    """Return what a system is as a block; None for what the engine does in its own way.

    Raises:
        NotCompilableError: it is of a kind that only Drake can run.
    """
    if isinstance(system, Block):
        _check_declared(system)
        return system.declaration
    if isinstance(system, ConstantVectorSource):
        context = system.CreateDefaultContext()
        value = system.get_source_value(context).value().copy()  # what it shows is the context's
        return Declaration(memory={"value": Memory(value, port=True)})
    if isinstance(system, MultibodyPlant | SceneGraph | Multiplexer | VectorLogSink):
        return None
    raise NotCompilableError(f"{system.get_name()}: {type(system).__name__} runs in Drake only")


def _check_declared(block: Block) -> None:
    """Check that a block has nothing beside its declaration, and that all of that is known here.

    Raises:
        NotCompilableError: it has.
    """
    is_, name = block.declaration, block.get_name()
    state = (block.num_discrete_state_groups(), block.num_abstract_states())
    ports = (block.num_input_ports(), block.num_output_ports())
    shown = sum(memory.port for memory in is_.memory.values()) + len(is_.outputs)
    declared = ((len(is_.memory), len(is_.archive)), (len(is_.inputs), shown))
    if (state, ports) != declared or block.num_continuous_states():
        raise NotCompilableError(f"{name}: it has ports or state beside its declaration")
    for known in fields(is_):
        if known.name not in HANDLED:
            raise NotCompilableError(f"{name}: its '{known.name}' runs in Drake only")


def _wires(diagram: Diagram) -> dict[tuple[str, str], Buffer]:
    """Return the buffer that each connected vector input reads, by system and port."""
    found = {}
    for (reader, to), (writer, of) in diagram.connection_map().items():
        port = writer.get_output_port(of)
        name = _buffer_name(writer, port)
        if name is not None:
            found[reader.get_name(), _input_name(reader, reader.get_input_port(to))] = Buffer(
                writer.get_name(), name
            )
    return found


def _buffer_name(system: System, port: OutputPort) -> str | None:
    """Return the name of the buffer behind an output port; None where the engine has none."""
    if isinstance(system, Block):
        return port.get_name()
    if isinstance(system, ConstantVectorSource):
        return "value"
    if isinstance(system, MultibodyPlant):
        return "state" if port.get_index() == system.get_state_output_port().get_index() else None
    return None


def _input_name(system: System, port: InputPort) -> str:
    return port.get_name() if isinstance(system, Block | MultibodyPlant) else f"u{port.get_index()}"


def _reads(system: System, wires: dict[tuple[str, str], Buffer]) -> dict[str, Buffer | None]:
    ports = (system.get_input_port(index) for index in range(system.num_input_ports()))
    names = (_input_name(system, port) for port in ports)
    return {name: wires.get((system.get_name(), name)) for name in names}


def needed_inputs(node: Node, kernel: Any) -> Iterator[str]:
    """Yield the names of the inputs that a kernel reads."""
    yield from (name for name in arguments_of(kernel) if name in node.declaration.inputs)
