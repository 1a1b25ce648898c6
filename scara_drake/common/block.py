"""Blocks: LeafSystems that are declared once, as data.

A block says its inputs, its memory, its parameters, its period and its kernels. A kernel is a plain
function on arrays, compiled or not, whose arguments are named: after an input, a memory, a
parameter, or ``t`` for the time. So the declaration is all that anybody needs to run a block: from
it `Block` makes the ports, the events and the first values of a LeafSystem, and other executions
can be made of the same.
"""

from __future__ import annotations

import inspect
import weakref
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import (
    BasicVector,
    DependencyTicket,
    DiscreteStateIndex,
    InputPort,
    LeafSystem,
)

from scara_drake.common.collectable import Collectable
from scara_drake.common.finite import all_finite, check_finite

Array = NDArray[np.float64]
Kernel = Callable[..., None]

TIME = "t"
ENABLED = 0.5  # an enable input from here on lets the block run
# How the code that calls a kernel takes a group of the memory: to write it, or to read it.
WRITTEN = "discrete.get_mutable_value({})"
READ = "context.get_discrete_state({}).value()"
STORED = "state.get_mutable_discrete_state({}).get_mutable_value()"
ARCHIVED = "state.get_mutable_abstract_state({}).get_mutable_value().get_mutable_value()"


@dataclass(frozen=True)
class Input:
    """An input port.

    Attributes:
        size: of its vector.
        finite: NaN or infinity on it stops the run.
        default: what the kernels read where the port is not connected; None: it must be.
        value: model of what comes in, a Drake `Value`, where that is no vector; no compiled kernel
            can read it.
    """

    size: int = 0
    finite: bool = False
    default: tuple[float, ...] | None = None
    value: AbstractValue | None = None


@dataclass(frozen=True)
class Memory:
    """A group of discrete state.

    Attributes:
        initial: first values (n,), or n for zeros.
        port: an output port of the same name shows it.
    """

    initial: ArrayLike | int
    port: bool = False


@dataclass(frozen=True)
class Output:
    """An output port that is worked out when it is asked for.

    Attributes:
        size: of its vector.
        kernel: writes the argument of the port's name from what the others name; memory is only
            read.
    """

    size: int
    kernel: Kernel


@dataclass(frozen=True)
class Declaration:
    """What a block is.

    Attributes:
        inputs: by name, in the order of the ports.
        memory: by name, in the order of the state, and of the ports that show it.
        outputs: by name; their ports come after those of the memory.
        parameters: by name: arrays and numbers that never change.
        period: [s], of the updates; 0 for none.
        offset: [s], of the first update.
        update: kernel of an update, writes memory in place.
        initialize: kernel of the start, if the first values depend on the inputs. A Simulator on a
            Context that is past t = 0, such as a clone, leaves it out and goes on.
        enable: name of an input; while it is below one half, `rest` stands in for `update` and for
            `initialize`.
        rest: kernel of an update that is not enabled.
        rest_initialize: kernel of a start that is not enabled, if `rest` does not do for it.
        with_plant: it is updated together with the step of a sampled plant, before the others, and
            reads what the plant showed before that step.
        sample: kernel that runs so before every `update`.
        archive: long memory by name, which `store` alone reads and writes; no port shows it. All
            other memory of a block is copied by Drake at each of its updates.
        store: kernel that moves between memory and archive; it reads no input. It runs with the
            first update and then with every `store_ticks`-th, just before it or just after it. It
            has to do for both, as the times of two periods may differ by a rounding.
        store_ticks: updates from store to store.
    """

    inputs: Mapping[str, Input] = field(default_factory=dict)
    memory: Mapping[str, Memory] = field(default_factory=dict)
    outputs: Mapping[str, Output] = field(default_factory=dict)
    parameters: Mapping[str, Any] = field(default_factory=dict)
    period: float = 0.0
    offset: float = 0.0
    update: Kernel | None = None
    initialize: Kernel | None = None
    enable: str = ""
    rest: Kernel | None = None
    rest_initialize: Kernel | None = None
    with_plant: bool = False
    sample: Kernel | None = None
    archive: Mapping[str, Memory] = field(default_factory=dict)
    store: Kernel | None = None
    store_ticks: int = 0


def arguments_of(kernel: Kernel) -> list[str]:
    """Return the names of a kernel's arguments, compiled or not."""
    return list(inspect.signature(getattr(kernel, "py_func", kernel)).parameters)


def _first_values(initial: ArrayLike | int) -> Array:
    return np.zeros(initial) if isinstance(initial, int) else np.array(initial, dtype=np.float64)


class Block(LeafSystem, metaclass=Collectable):
    """A LeafSystem made of its declaration; see the subclass for its ports.

    Args:
        declaration: kept as `declaration`.

    Raises:
        ValueError: a kernel has an argument that the declaration does not name.
    """

    def __init__(self, declaration: Declaration) -> None:
        super().__init__()
        self.declaration = declaration
        self._inputs = {
            name: self.DeclareVectorInputPort(name, port.size)
            if port.value is None
            else self.DeclareAbstractInputPort(name, port.value)
            for name, port in declaration.inputs.items()
        }
        # Plain ints: Drake takes them faster than its own index type, twenty times a tick.
        self._groups = {
            name: int(self.DeclareDiscreteState(_first_values(memory.initial)))
            for name, memory in declaration.memory.items()
        }
        self._archives = {
            name: int(self.DeclareAbstractState(Value(BasicVector(_first_values(memory.initial)))))
            for name, memory in declaration.archive.items()
        }
        for name, memory in declaration.memory.items():
            if memory.port:
                self.DeclareStateOutputPort(name, DiscreteStateIndex(self._groups[name]))
        self._calculations = {
            name: self._caller(output.kernel, READ, name)
            for name, output in declaration.outputs.items()
        }
        for name, output in declaration.outputs.items():
            # Drake would hold it, it holds the ports and they the system: none could be freed.
            calculation = weakref.proxy(self._calculations[name])
            self.DeclareVectorOutputPort(
                name, output.size, calculation, self._prerequisites(output)
            )
        self._declare_events()

    def _declare_events(self) -> None:
        is_ = self.declaration
        if is_.initialize is not None:
            self._declare_start(self._event(is_.initialize, is_.rest_initialize or is_.rest))
        if is_.sample is not None:
            self._declare_with_plant(self._caller(is_.sample, WRITTEN))
        if is_.store is not None:
            store = self._caller(is_.store, STORED)
            between = is_.store_ticks * is_.period
            self.DeclarePeriodicUnrestrictedUpdateEvent(between, is_.offset, store)
        if is_.update is None:
            return
        event = self._event(is_.update, is_.rest)
        if is_.with_plant:
            self._declare_with_plant(event)
        else:
            self.DeclarePeriodicDiscreteUpdateEvent(is_.period, is_.offset, event)

    def _declare_start(self, event: Callable[[Any, Any], None]) -> None:
        def start(context: Any, discrete: Any) -> None:
            if context.get_time() <= 0.0:
                event(context, discrete)

        self.DeclareInitializationDiscreteUpdateEvent(start)

    def _declare_with_plant(self, event: Callable[[Any, Any], None]) -> None:
        def unrestricted(context: Any, state: Any) -> None:
            event(context, state.get_mutable_discrete_state())

        is_ = self.declaration
        self.DeclarePeriodicUnrestrictedUpdateEvent(is_.period, is_.offset, unrestricted)

    def _event(self, kernel: Kernel, rest: Kernel | None) -> Callable[[Any, Any], None]:
        """Return the handler of a discrete update by a kernel, or by `rest` while not enabled."""
        run = self._caller(kernel, WRITTEN)
        if rest is None:
            return run
        stop, port = self._caller(rest, WRITTEN), self._inputs[self.declaration.enable]

        def event(context: Any, discrete: Any) -> None:
            enabled = not port.HasValue(context) or port.Eval(context)[0] >= ENABLED
            (run if enabled else stop)(context, discrete)

        return event

    def _prerequisites(self, output: Output) -> set[DependencyTicket]:
        tickets = set()
        for name in arguments_of(output.kernel):
            if name == TIME:
                tickets.add(self.time_ticket())
            elif name in self._inputs:
                tickets.add(self._inputs[name].ticket())
            elif name in self._groups:
                tickets.add(self.discrete_state_ticket(DiscreteStateIndex(self._groups[name])))
        return tickets or {self.nothing_ticket()}

    def _caller(self, kernel: Kernel, memory: str, output: str = "") -> Callable[[Any, Any], None]:
        """Return ``call(context, discrete)``, which calls a kernel with its arguments by name.

        It is written out for each kernel, as dataclasses write their methods: a loop over the
        arguments costs as much as a small kernel, a thousand times per simulated second.
        """
        is_ = self.declaration
        scope: dict[str, Any] = {"kernel": kernel, "all_finite": all_finite}
        lines, passed = [], []
        for name in arguments_of(kernel):
            if name == output:
                passed.append("discrete.get_mutable_value()")
            elif name == TIME:
                passed.append("context.get_time()")
            elif name in is_.inputs:
                scope[f"eval_{name}"] = self._inputs[name].Eval
                value = f"eval_{name}(context)"
                if is_.inputs[name].default is not None:
                    scope[f"has_{name}"] = self._inputs[name].HasValue
                    scope[f"default_{name}"] = np.array(is_.inputs[name].default)
                    value = f"{value} if has_{name}(context) else default_{name}"
                lines.append(f"{name} = {value}")
                passed.append(name)
            elif name in is_.memory:
                passed.append(memory.format(self._groups[name]))
            elif name in is_.archive and memory == STORED:
                passed.append(ARCHIVED.format(self._archives[name]))
            elif name in is_.parameters:
                scope[name] = is_.parameters[name]
                passed.append(name)
            else:
                long = is_.archive if memory == STORED else {}
                known = [TIME, *is_.inputs, *is_.memory, *long, *is_.parameters]
                raise ValueError(
                    f"{type(self).__name__}: argument '{name}' of {kernel.__name__}, "
                    f"allowed {', '.join(known)}"
                )
        lines += self._guard(arguments_of(kernel), scope)
        body = "\n    ".join([*lines, f"kernel({', '.join(passed)})"])
        state = "state" if memory == STORED else "discrete"
        exec(f"def call(context, {state}):\n    {body}", scope)
        call: Callable[[Any, Any], None] = scope["call"]
        return call

    def _guard(self, names: list[str], scope: dict[str, Any]) -> list[str]:
        """Return the lines that stop the run where an input has to be finite and is not."""
        watched = [name for name in names if name in self._inputs and self._watches(name)]
        if not watched:
            return []
        ports: tuple[InputPort, ...] = tuple(self._inputs[name] for name in watched)
        scope["refuse"] = lambda context: check_finite(self, context, ports)
        pairs = zip(watched[::2], [*watched[1::2], watched[-1]], strict=False)
        tests = " and ".join(f"all_finite({first}, {second})" for first, second in pairs)
        return [f"if not ({tests}):", "    refuse(context)"]

    def _watches(self, name: str) -> bool:
        return self.declaration.inputs[name].finite
