"""Parts of a scenario made from the data of a YAML file: checked by their types, then built."""

from __future__ import annotations

import dataclasses
import types
import typing
from typing import Any, TypeVar

from scara_drake.common import checks

Part = TypeVar("Part")
TAG = "_tag"  # under which pydrake's reader leaves the tag of a part with several kinds


def build(schema: type[Part], data: dict[str, Any], path: str = "") -> Part:
    """Return a dataclass with the fields of `data`, and its defaults for the others.

    A number or a word where a list of known length is expected is spread over the list, and a text
    such as 1e-3 where a number is expected is that number. A field of several kinds of parts takes
    the one that its tag names, the first without a tag.

    Args:
        schema: a dataclass whose fields all have defaults.
        data: of a YAML map; it is not changed.
        path: of the part in the file, ending in "."; for the messages.

    Raises:
        ValueError: names the first field that the schema does not allow.
    """
    hints = typing.get_type_hints(schema)
    defaults = schema()
    values = {}
    for key, value in data.items():
        if key == TAG:
            continue
        where = f"{path}{key}"
        if key not in hints:
            raise ValueError(f"{where}: unknown field, allowed {', '.join(hints)}")
        default = getattr(defaults, key)
        if isinstance(default, list) and default and not isinstance(value, list | dict | None):
            value = [value] * len(default)
        values[key] = _value(hints[key], value, where)
    return schema(**values)


def _value(hint: Any, value: Any, where: str) -> Any:
    """Return a value as its type wants it, see `build`."""
    kinds = [kind for kind in alternatives(hint) if kind is not type(None)]
    if value is None:
        if type(None) not in alternatives(hint):
            raise ValueError(f"{where}: empty, allowed {_describe(kinds)}")
        return None
    if any(dataclasses.is_dataclass(kind) for kind in kinds):
        return _part(kinds, value, where)
    (kind,) = kinds
    if typing.get_origin(kind) is list:
        if not isinstance(value, list):
            raise ValueError(f"{where}: {value}, allowed a list")
        (item,) = typing.get_args(kind)
        return [_value(item, entry, f"{where}[{index}]") for index, entry in enumerate(value)]
    return _scalar(kind, value, where)


def _part(kinds: list[Any], value: Any, where: str) -> Any:
    if not isinstance(value, dict):
        raise ValueError(f"{where}: {value}, allowed the fields of {_describe(kinds)}")
    by_name = {kind.__name__: kind for kind in kinds}
    tag = str(value.get(TAG, "!" + kinds[0].__name__)).removeprefix("!")
    checks.choice(where, tag, by_name)
    return build(by_name[tag], value, f"{where}.")


def _scalar(kind: Any, value: Any, where: str) -> Any:
    if kind is float and isinstance(value, str):
        try:
            return float(value)  # YAML 1.1 takes 1e-3 for a text
        except ValueError:
            pass
    if kind in (int, float) and not _is_number(value):
        raise ValueError(f"{where}: {value}, allowed a number")
    if kind is int and not isinstance(value, int):
        raise ValueError(f"{where}: {value}, allowed a whole number")
    if kind is bool and not isinstance(value, bool):
        raise ValueError(f"{where}: {value}, allowed true or false")
    if kind is str and not isinstance(value, str):
        raise ValueError(f"{where}: {value}, allowed a text")
    return float(value) if kind is float else value


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def alternatives(hint: Any) -> tuple[Any, ...]:
    """Return the types of a union, or the one type."""
    if typing.get_origin(hint) in (typing.Union, types.UnionType):
        return typing.get_args(hint)
    return (hint,)


def _describe(kinds: list[Any]) -> str:
    return " or ".join(getattr(kind, "__name__", str(kind)) for kind in kinds)
