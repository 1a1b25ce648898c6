"""Fields of a scenario's parts: default, unit, symbol, bounds and equation, written once.

A part is a dataclass whose fields are declared with `number`, `vector`, `rows`, `choice` and
`words`; `check` reads the bounds from them, tuning its ranges, and the reference of all fields its
rows.
What a field means stands in the ``Attributes`` of its class. A rule between fields is a method
``check_together(name)`` of the part, one about the time step ``check_sampling(name, period)``.
"""

from __future__ import annotations

import dataclasses
import inspect
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from scara_drake.common import checks
from scara_drake.common.checks import ABOVE_ZERO

KEY = "scara_drake"  # of the metadata of a field


@dataclass(frozen=True)
class Spec:
    """What a field is, beside its name and default.

    Attributes:
        unit: of SI, empty for words; of a list "m | rad" tells that of d1 and of the others.
        low: smallest value allowed.
        high: largest value allowed.
        size: entries of a list; None is any number of them, 0 is no list.
        width: entries of each row of a list of rows; 0 is no list of rows.
        choices: words allowed; empty for a number.
        symbol: in the paper.
        equation: of the paper in which it stands.
    """

    unit: str = ""
    low: float = -math.inf
    high: float = math.inf
    size: int | None = 0
    choices: tuple[str, ...] = ()
    symbol: str = ""
    equation: str = ""
    width: int = 0


def number(
    default: float,
    unit: str,
    low: float = -math.inf,
    high: float = math.inf,
    *,
    symbol: str = "",
    equation: str = "",
) -> Any:
    """Declare a finite number within [low, high]; `ABOVE_ZERO` as `low` leaves zero out."""
    spec = Spec(unit, low, high, symbol=symbol, equation=equation)
    return field(default=default, metadata={KEY: spec})


def vector(
    default: Sequence[float],
    unit: str,
    low: float = -math.inf,
    high: float = math.inf,
    *,
    size: int | None = -1,
    symbol: str = "",
    equation: str = "",
) -> Any:
    """Declare a list of finite numbers, as many as the default has unless `size` says otherwise."""
    values = list(default)
    spec = Spec(unit, low, high, len(values) if size == -1 else size, (), symbol, equation)
    return field(default_factory=lambda: list(values), metadata={KEY: spec})


def rows(
    default: Sequence[Sequence[float]], unit: str, low: float = -math.inf, high: float = math.inf
) -> Any:
    """Declare a list of any number of rows of finite numbers, each as long as those given."""
    values = [list(row) for row in default]
    spec = Spec(unit, low, high, None, width=len(values[0]))
    return field(default_factory=lambda: [list(row) for row in values], metadata={KEY: spec})


def choice(default: str, choices: Sequence[str]) -> Any:
    """Declare one of some words."""
    return field(default=default, metadata={KEY: Spec(choices=tuple(choices))})


def words(default: Sequence[str], choices: Sequence[str]) -> Any:
    """Declare a list of as many words as the default has, each one of `choices`."""
    values = list(default)
    spec = Spec(size=len(values), choices=tuple(choices))
    return field(default_factory=lambda: list(values), metadata={KEY: spec})


def spec_of(part: Any, name: str) -> Spec:
    """Return what a field of a part, or of its class, was declared to be.

    Raises:
        ValueError: the part has no such field, or it was declared without a spec.
    """
    for entry in dataclasses.fields(part):
        if entry.name == name and KEY in entry.metadata:
            spec: Spec = entry.metadata[KEY]
            return spec
    raise ValueError(f"{name}: not a field with bounds")


def check(part: Any, path: str) -> None:
    """Check all fields of a part and of the parts in it, then the rules between them.

    Args:
        part: a dataclass.
        path: its name in the scenario, such as "channel.up"; empty for the scenario itself.

    Raises:
        ValueError: one line that names the field, its value and what is allowed.
    """
    _check_names(part, path)
    for name, spec, value in _fields(part):
        where = f"{path}.{name}" if path else name
        if spec is not None:
            _check_value(where, value, spec)
        elif dataclasses.is_dataclass(value):
            check(value, where)
        elif isinstance(value, list):
            for index, entry in enumerate(value):
                if dataclasses.is_dataclass(entry):
                    check(entry, f"{where}[{index}]")
    together = getattr(part, "check_together", None)
    if together is not None:
        together(path)


def _check_names(part: Any, path: str) -> None:
    """Refuse an attribute that is no field: a slip of the pen that would do nothing.

    Parts of the user's own may have what they like.
    """
    if type(part).__module__.partition(".")[0] != __name__.partition(".")[0]:
        return
    names = [entry.name for entry in dataclasses.fields(part)]
    for name in vars(part):
        if name not in names and not name.startswith("_"):
            where = f"{path}.{name}" if path else name
            raise ValueError(
                f"{where}: unknown field, allowed {', '.join(names)}{checks.nearest(name, names)}"
            )


def check_sampling(part: Any, path: str, period: float, **known: Any) -> None:
    """Ask a part, and the parts in it, whether they suit a time step [s].

    Args:
        part: a dataclass.
        path: its name in the scenario.
        period: the time step [s].
        **known: what else a rule may ask for, by the names of its arguments: `model`, the robot.

    Raises:
        ValueError: one does not.
    """
    for name, spec, value in _fields(part):
        if spec is None and dataclasses.is_dataclass(value):
            check_sampling(value, f"{path}.{name}" if path else name, period, **known)
    rule = getattr(part, "check_sampling", None)
    if rule is not None:
        asked = inspect.signature(rule).parameters if known else {}
        rule(path, period, **{name: value for name, value in known.items() if name in asked})


def resolve_files(part: Any, folder: Path) -> None:
    """Let a part, and the parts in it, look for the files they name in the folder of a scenario."""
    for _, spec, value in _fields(part):
        if spec is None and dataclasses.is_dataclass(value):
            resolve_files(value, folder)
    resolve = getattr(part, "resolve_files", None)
    if resolve is not None:
        resolve(folder)


def _fields(part: Any) -> Iterator[tuple[str, Spec | None, Any]]:
    for entry in dataclasses.fields(part):
        metadata: Mapping[str, Any] = entry.metadata
        yield entry.name, metadata.get(KEY), getattr(part, entry.name)


def _check_value(where: str, value: Any, spec: Spec) -> None:
    if spec.size == 0:
        _check_entry(where, value, spec)
        return
    if spec.size is not None and len(value) != spec.size:
        raise ValueError(f"{where}: {len(value)} entries, allowed {spec.size}")
    for index, entry in enumerate(value):
        if spec.width:
            checks.vector(f"{where}[{index}]", entry, spec.width, spec.low, spec.high)
        else:
            _check_entry(f"{where}[{index}]", entry, spec)


def _check_entry(where: str, value: Any, spec: Spec) -> None:
    if spec.choices:
        checks.choice(where, value, spec.choices)
    else:
        checks.number(where, value, spec.low, spec.high)


__all__ = [
    "ABOVE_ZERO",
    "Spec",
    "check",
    "check_sampling",
    "choice",
    "number",
    "resolve_files",
    "rows",
    "spec_of",
    "vector",
    "words",
]
