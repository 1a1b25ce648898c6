"""One dotted key set in the data of a YAML file."""

from __future__ import annotations

import copy
from typing import Any

from scara_drake.common.checks import shown
from scara_drake.common.yaml_text import read_yaml


def override(data: dict[str, Any], dotted: str, value: Any) -> None:
    """Set one dotted key in the data of a YAML file, in place."""
    if isinstance(value, str):
        value = read_yaml(value, shown(dotted, quotes=False))
    *parents, last = dotted.split(".")
    place: Any = data
    for parent in parents:
        if isinstance(place, dict):
            place = place.setdefault(parent, {})
        else:
            place = place[_entry_of(place, parent, dotted)]
        if not isinstance(place, dict | list):
            raise ValueError(
                f"{shown(dotted, quotes=False)}: {shown(parent)} has no fields, allowed the path "
                "of a field"
            )
    entry = last if isinstance(place, dict) else _entry_of(place, last, dotted)
    place[entry] = copy.deepcopy(value)


def _entry_of(place: list[Any], key: str, dotted: str) -> int:
    """Return the index that a word of a dotted key means in a list.

    Raises:
        ValueError: it is none.
    """
    if not key.isdecimal() or len(key) > 6 or int(key) >= len(place):
        allowed = f"0 to {len(place) - 1}" if place else "none: the list is empty"
        raise ValueError(f"{shown(dotted, quotes=False)}: no entry {shown(key)}, allowed {allowed}")
    return int(key)
