"""A Diagram made into one compiled function, kept on disk from process to process."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numba
import numpy as np
from numba import njit
from numpy.typing import NDArray

import scara_drake
from scara_drake.common.block import ENABLED, Declaration
from scara_drake.common.files import write_whole
from scara_drake.common.finite import all_finite
from scara_drake.engine.dynamics import plant_step, set_efforts
from scara_drake.engine.graph import Graph
from scara_drake.engine.source import Source, source_of
from scara_drake.engine.watch import any_link_near

Array = NDArray[np.float64]


@njit(cache=True)
def put(vector: Array, records: Array, row: int, start: int) -> None:
    """Write a vector into a row, from `start`."""
    for i in range(vector.size):
        records[row, start + i] = vector[i]


@njit(cache=True)
def put_all(vector: Array, copy: Array) -> None:
    """Write a vector over another."""
    for i in range(vector.size):
        copy[i] = vector[i]


# What this process has compiled or loaded, by its mark.
_COMPILED: dict[str, Callable[..., int]] = {}
NO_FORCE = np.zeros(6)
SCOPE: dict[str, Any] = {
    "ENABLED": ENABLED,
    "all_finite": all_finite,
    "any_link_near": any_link_near,
    "no_force": NO_FORCE,
    "plant_step": plant_step,
    "put": put,
    "put_all": put_all,
    "set_efforts": set_efforts,
}


@dataclass(frozen=True)
class Program:
    """A Diagram, ready to be advanced.

    Attributes:
        graph: what it was made of.
        source: its text, and what that needs.
        advance: the compiled function.
    """

    graph: Graph
    source: Source
    advance: Callable[..., int]

    def buffers(self) -> dict[str, Any]:
        """Return new buffers with their first values, and the parameters, by their names."""
        return {
            name: first_value(self.graph.nodes[node].declaration, of)
            for name, (node, of) in self.source.arguments.items()
        }


def first_value(declaration: Declaration, name: str) -> Any:
    """Return what an argument of the function is at the start, as an array of its own.

    Args:
        declaration: of its block.
        name: of the memory, the output, the parameter, or the input that is not connected.
    """
    is_ = declaration
    if name in is_.memory:
        initial = is_.memory[name].initial
        return np.zeros(initial) if isinstance(initial, int) else _array(initial)
    if name in is_.outputs:
        return np.zeros(is_.outputs[name].size)
    if name in is_.inputs:
        return _array(is_.inputs[name].default)
    value = is_.parameters[name]
    return _array(value) if isinstance(value, np.ndarray) else value


def _array(value: Any) -> Array:
    return np.array(value, dtype=np.float64, order="C")


def program_of(graph: Graph, period: float, folder: Path) -> Program:
    """Return a graph as a compiled function, from the folder's cache where it was made before.

    Args:
        graph: of a Diagram.
        period: of its ticks [s].
        folder: of the cache.

    Raises:
        NotCompilableError: a part of it can only run in Drake; names it.
    """
    source = source_of(graph, period)
    return Program(graph, source, _compiled(source, folder))


def _compiled(source: Source, folder: Path) -> Callable[..., int]:
    """Compile a source; numba's cache is beside the file that it is written to.

    The file's name is made of all that the machine code depends on, so that no other code is taken
    for it. Functions of one name are linked to each other's code, so it is the function's too.
    """
    names = " ".join(
        f"{name}={kernel.py_func.__module__}.{kernel.py_func.__qualname__}"
        for name, kernel in source.kernels.items()
    )
    mark = hashlib.sha256(f"{code_digest()} {names} {source.text}".encode()).hexdigest()[:16]
    text = source.text.replace("def advance(", f"def advance_{mark}(", 1)
    if mark in _COMPILED:
        return _COMPILED[mark]
    path = folder / f"advance_{mark}.py"
    if not path.exists():
        folder.mkdir(parents=True, exist_ok=True)
        write_whole(path, text)
    scope = {**SCOPE, **source.kernels, "__name__": __name__}
    exec(compile(text, path, "exec"), scope)
    advance: Callable[..., int] = njit(cache=True, nogil=True, error_model="numpy")(
        scope[f"advance_{mark}"]
    )
    _COMPILED[mark] = advance
    return advance


@cache
def code_digest() -> str:
    """Return a digest of the package's source and of the compiler."""
    digest = hashlib.sha256(f"{numba.__version__} {np.__version__}".encode())
    package = Path(scara_drake.__file__).parent
    for path in sorted(package.rglob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()
