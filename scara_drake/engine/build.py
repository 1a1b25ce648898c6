"""A Diagram made into one compiled function, kept on disk from process to process.

The function calls the kernels of the blocks by their addresses. So a kernel is compiled once, for
Drake, the engine and all Diagrams together, and what is compiled anew for a Diagram is short.
"""

from __future__ import annotations

import hashlib
import inspect
import threading
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numba
import numpy as np
from numba import float64, int64, njit, typeof, types
from numpy.typing import NDArray

from scara_drake.common.block import ENABLED, Declaration
from scara_drake.common.files import write_whole
from scara_drake.common.finite import all_finite
from scara_drake.engine.graph import Graph
from scara_drake.engine.source import source_of
from scara_drake.engine.store import VIEWS, Store, is_stored
from scara_drake.engine.writer import FIXED, STORE_TICKS, Source

Array = NDArray[np.float64]


@njit(cache=True)
def put(vector: Array, records: Array, row: int, start: int) -> int:
    """Write a vector into a row, from `start`; return where the next one goes."""
    for i in range(vector.size):
        records[row, start + i] = vector[i]
    return start + vector.size


@njit(cache=True)
def put_all(vector: Array, copy: Array) -> None:
    """Write a vector over another."""
    for i in range(vector.size):
        copy[i] = vector[i]


# What the text calls beside the kernels: short, so it becomes part of it.
SHORT: dict[str, Any] = {"all_finite": all_finite, "put": put, "put_all": put_all}
SCOPE: dict[str, Any] = {
    "ENABLED": ENABLED,
    **VIEWS,
    **SHORT,
}
# What this process has compiled or loaded, by its mark.
_COMPILED: dict[str, Callable[..., int]] = {}
_COMPILING = threading.Lock()


@dataclass(frozen=True)
class Program:
    """A Diagram, ready to be advanced.

    Attributes:
        graph: what it was made of.
        source: its text, and what that needs.
        advance: the compiled function.
        store: its arrays, with their first values.
        others: its other arguments, in order: numbers, then kernels.
    """

    graph: Graph
    source: Source
    advance: Callable[..., int]
    store: Store
    others: list[Any]


def first_value(declaration: Declaration, name: str) -> Any:
    """Return what an argument of the function is at the start, as an array of its own.

    Args:
        declaration: of its block.
        name: of the memory, the archive, the output, the parameter, or the input that is not
            connected; or `STORE_TICKS`.
    """
    is_ = declaration
    if name == STORE_TICKS:
        return is_.store_ticks
    memory = {**is_.memory, **is_.archive}
    if name in memory:
        initial = memory[name].initial
        return np.zeros(initial) if isinstance(initial, int) else _array(initial)
    if name in is_.outputs:
        return np.zeros(is_.outputs[name].size)
    if name in is_.inputs:
        return _array(is_.inputs[name].default)
    value = is_.parameters[name]
    return _array(value) if isinstance(value, np.ndarray) else value


def _array(value: Any) -> Array:
    return np.array(value, dtype=np.float64, order="C")


def program_of(graph: Graph, period: float, own: dict[str, Array], folder: Path) -> Program:
    """Return a graph as a compiled function, from the folder's cache where it was made before.

    Args:
        graph: of a Diagram.
        period: of its ticks [s].
        own: the arrays that are not of a block, by their names in the text: arm, work, segments,
            surfaces, no_force and state.
        folder: of the cache.

    Raises:
        NotCompilableError: a part of it can only run in Drake; names it.
    """
    source = source_of(graph, period)
    slow = [graph.nodes[name].declaration for name in source.slow]
    values = own | {"slow": np.array([[is_.offset, is_.period] for is_ in slow]).reshape(-1, 2)}
    for name, (node, of) in source.arguments.items():
        values[name] = first_value(graph.nodes[node].declaration, of)
    stored = {name: value for name, value in values.items() if is_stored(value)}
    numbers = [value for name, value in values.items() if name not in stored]
    kernels = [kernel for kernel, _ in source.kernels.values()]
    with _COMPILING:  # threads that build the same function wait for the first
        advance = _compiled(source, values, stored, folder)
    return Program(graph, source, advance, Store(stored), [*numbers, *kernels])


def _compiled(
    source: Source, values: dict[str, Any], stored: dict[str, Array], folder: Path
) -> Callable[..., int]:
    """Compile a source; numba's cache is beside the file that it is written to.

    The file's name is made of all that its machine code depends on: its text, the types of what it
    is passed, and the compiler. The kernels are no part of it, and have caches of their own.
    """
    known = {name: typeof(value) for name, value in values.items()}
    kernels = [
        types.FunctionType(_compile_kernel(kernel, [known.get(n, float64) for n in passed]))
        for kernel, passed in source.kernels.values()
    ]
    numbers = [known[name] for name in source.arguments if name not in stored]
    signature = int64(*FIXED.values(), *numbers, *kernels)
    text = source.text({name: value.ndim for name, value in stored.items()})
    marked = hashlib.sha256(f"{_surroundings()} {signature} {text}".encode())
    mark = marked.hexdigest()[:16]
    if mark in _COMPILED:
        return _COMPILED[mark]
    path = folder / f"advance_{mark}.kernel"
    if not path.exists():
        folder.mkdir(parents=True, exist_ok=True)
        write_whole(path, text.replace("def advance(", f"def advance_{mark}(", 1))
    scope = {**SCOPE, "__name__": __name__}
    exec(compile(path.read_bytes(), path, "exec"), scope)
    compiled = njit(signature, cache=True, nogil=True, error_model="numpy")
    _COMPILED[mark] = compiled(scope[f"advance_{mark}"])
    return _COMPILED[mark]


@cache
def _surroundings() -> str:
    """Return what machine code depends on beside a text: the compiler, and what is part of it."""
    short = " ".join(inspect.getsource(function.py_func) for function in SHORT.values())
    return f"{numba.__version__} {np.__version__} {short}"


def _compile_kernel(kernel: Any, passed: list[types.Type]) -> Any:
    """Compile a kernel, or load it from its cache; return its signature."""
    kernel.compile(tuple(passed))
    return kernel.overloads[tuple(passed)].signature
