"""Parts of a scenario made from the data of a YAML file: checked by their types, then built."""

from __future__ import annotations

import dataclasses
import types
import typing
from typing import Any, TypeVar

import numpy as np
import yaml

from scara_drake.common.checks import nearest, shown
from scara_drake.common.yaml_text import TAG

Part = TypeVar("Part")


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
            raise ValueError(
                f"{shown(where, quotes=False)}: unknown field, allowed {', '.join(hints)}"
                f"{nearest(key, hints)}"
            )
        default = getattr(defaults, key)
        if isinstance(default, list) and isinstance(value, dict) and value:
            value = _with_entries(default, value, where)
        if isinstance(default, list) and default and not isinstance(value, list | dict | None):
            value = [value] * len(default)
        values[key] = _value(hints[key], value, where)
    return schema(**values)


def data_of(part: Any) -> dict[str, Any]:
    """Return the data of a dataclass, from which `build` makes an equal one.

    A part that could be of several kinds has its tag, and so has one of a kind that its field does
    not name, such as a controller of the user's own: the data say what it is, but do not build.
    """
    hints = typing.get_type_hints(type(part))
    return {
        entry.name: _data(hints[entry.name], getattr(part, entry.name))
        for entry in dataclasses.fields(part)
    }


class _Dumper(yaml.SafeDumper):
    """Writes maps in their own order, a tag where one is due, and a list of numbers in a line."""


def _represent(dumper: _Dumper, data: dict[str, Any]) -> yaml.Node:
    entries = {key: value for key, value in data.items() if key != TAG}
    return dumper.represent_mapping(data.get(TAG, "tag:yaml.org,2002:map"), entries.items())


def _represent_list(dumper: _Dumper, data: list[Any]) -> yaml.Node:
    plain = not any(isinstance(entry, dict | list) for entry in data)
    return dumper.represent_sequence("tag:yaml.org,2002:seq", data, flow_style=plain)


_Dumper.add_representer(dict, _represent)
_Dumper.add_representer(list, _represent_list)


def yaml_of(part: Any) -> str:
    """Return the YAML text of a dataclass, see `data_of`."""
    return yaml.dump(data_of(part), Dumper=_Dumper, sort_keys=False, width=100)


def changed_yaml(part: Any) -> str:
    """Return the YAML text of those fields of a dataclass that differ from its defaults."""
    default = data_of(type(part)())
    changed = {key: value for key, value in data_of(part).items() if value != default[key]}
    return yaml.dump(changed, Dumper=_Dumper, sort_keys=False, width=100) if changed else ""


def _data(hint: Any, value: Any) -> Any:
    kinds = [kind for kind in alternatives(hint) if kind is not type(None)]
    if isinstance(value, list):
        items = [typing.get_args(kind)[0] for kind in kinds if typing.get_origin(kind) is list]
        return [_data(items[0] if items else type(entry), entry) for entry in value]
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()  # a number of Python's, or a list of them
    if not dataclasses.is_dataclass(value):
        return value
    tag = {} if kinds == [type(value)] else {TAG: f"!{type(value).__name__}"}
    return tag | data_of(value)


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
            raise ValueError(f"{where}: {shown(value, quotes=False)}, allowed a list")
        (item,) = typing.get_args(kind)
        return [_value(item, entry, f"{where}[{index}]") for index, entry in enumerate(value)]
    return _scalar(kind, value, where)


def _part(kinds: list[Any], value: Any, where: str) -> Any:
    if not isinstance(value, dict):
        names = [kind.__name__ for kind in kinds]
        raise ValueError(
            f"{where}: {shown(value, quotes=False)}, allowed the fields of {_describe(kinds)}"
            f"{nearest(str(value).removeprefix('!'), names, '!{} {{}}')}"
        )
    by_name = {kind.__name__: kind for kind in kinds}
    tag = str(value.get(TAG, "!" + kinds[0].__name__)).removeprefix("!")
    if tag not in by_name:
        raise ValueError(
            f"{where}: {shown(tag)}, allowed {', '.join(by_name)}"
            f"{nearest(tag, by_name, '!{} {{}}')}"
        )
    return build(by_name[tag], value, f"{where}.")


def _scalar(kind: Any, value: Any, where: str) -> Any:
    if kind is float and isinstance(value, str):
        try:
            return float(value)  # YAML 1.1 takes 1e-3 for a text
        except ValueError:
            pass
    said = f"{where}: {shown(value, quotes=False)}"
    if kind in (int, float) and not _is_number(value):
        raise ValueError(f"{said}, allowed a number")
    if kind is int and not isinstance(value, int):
        raise ValueError(f"{said}, allowed a whole number")
    if kind is bool and not isinstance(value, bool):
        raise ValueError(f"{said}, allowed true or false")
    if kind is str and not isinstance(value, str):
        raise ValueError(f"{said}, allowed a text")
    try:
        return float(value) if kind is float else value
    except OverflowError:
        raise ValueError(f"{said}, allowed a number that a float can hold") from None


def _with_entries(default: list[Any], entries: dict[Any, Any], where: str) -> list[Any]:
    """Return a list with some of its entries replaced: {"0": 5.0} is another first entry."""
    changed = list(default)
    for key, value in entries.items():
        if not str(key).isdecimal() or len(str(key)) > 6 or int(key) >= len(changed):
            allowed = f"0 to {len(changed) - 1}" if changed else "none: it is empty"
            raise ValueError(f"{where}: no entry {shown(str(key))}, allowed {allowed}")
        changed[int(key)] = value
    return changed


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def alternatives(hint: Any) -> tuple[Any, ...]:
    """Return the types of a union, or the one type."""
    if typing.get_origin(hint) in (typing.Union, types.UnionType):
        return typing.get_args(hint)
    return (hint,)


def _describe(kinds: list[Any]) -> str:
    return " or ".join(getattr(kind, "__name__", str(kind)) for kind in kinds)
