"""Data of a YAML file against the dataclasses that they are read into."""

from __future__ import annotations

import dataclasses
import types
import typing
from typing import Any

from scara_drake.common import checks


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def check_schema(schema: Any, data: Any, path: str) -> None:
    """Raise a ValueError that names the first field of `data` that `schema` does not allow.

    `yaml_load_typed` refuses the same data, without saying where in the file. In place: a number
    or a word where a list of known length is expected is spread over the list, a text such as 1e-3
    where a number is expected becomes one, and the tag of a part that has one kind only is dropped.
    """
    hints = typing.get_type_hints(schema)
    defaults = schema()
    for key, value in data.items():
        if key == "_tag":
            continue
        where = f"{path}{key}"
        if key not in hints:
            raise ValueError(f"{where}: unknown field, allowed {', '.join(hints)}")
        default = getattr(defaults, key)
        if isinstance(default, list) and default and not isinstance(value, list | dict | None):
            value = [value] * len(default)
        data[key] = _checked(hints[key], value, where)


def _checked(hint: Any, value: Any, where: str) -> Any:
    """Return a value as its type wants it, which `check_schema` documents."""
    kinds = [kind for kind in alternatives(hint) if kind is not type(None)]
    records: list[Any] = [kind for kind in kinds if dataclasses.is_dataclass(kind)]
    if value is None:
        if type(None) not in alternatives(hint):
            raise ValueError(f"{where}: empty, allowed {_describe(kinds)}")
    elif records:
        if not isinstance(value, dict):
            raise ValueError(f"{where}: {value}, allowed the fields of {_describe(records)}")
        tag = str(value.get("_tag", "!" + records[0].__name__)).removeprefix("!")
        by_name = {kind.__name__: kind for kind in records}
        checks.choice(where, tag, by_name)
        if len(records) == 1:
            value.pop("_tag", None)  # pydrake takes tags for unions only
        check_schema(by_name[tag], value, f"{where}.")
    elif typing.get_origin(kinds[0]) is list:
        if not isinstance(value, list):
            raise ValueError(f"{where}: {value}, allowed a list")
        (item,) = typing.get_args(kinds[0])
        return [_checked(item, entry, f"{where}[{index}]") for index, entry in enumerate(value)]
    elif kinds[0] is float:
        return _number(value, where)
    elif kinds[0] is int and not _is_number(value):
        raise ValueError(f"{where}: {value}, allowed a number")
    elif kinds[0] is int and not isinstance(value, int):
        raise ValueError(f"{where}: {value}, allowed a whole number")
    elif kinds[0] is bool and not isinstance(value, bool):
        raise ValueError(f"{where}: {value}, allowed true or false")
    elif kinds[0] is str and not isinstance(value, str):
        raise ValueError(f"{where}: {value}, allowed a text")
    return value


def _number(value: Any, where: str) -> float:
    if isinstance(value, str):
        # YAML 1.1 takes 1e-3 for a text.
        try:
            return float(value)
        except ValueError:
            pass
    if not _is_number(value):
        raise ValueError(f"{where}: {value}, allowed a number")
    return float(value)


def alternatives(hint: Any) -> tuple[Any, ...]:
    """Return the types of a union, or the one type."""
    if typing.get_origin(hint) in (typing.Union, types.UnionType):
        return typing.get_args(hint)
    return (hint,)


def _describe(kinds: list[Any]) -> str:
    return " or ".join(getattr(kind, "__name__", str(kind)) for kind in kinds)
