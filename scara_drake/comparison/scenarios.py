"""What differs between the scenarios of recordings, field by field."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, Final

import xarray as xr
import yaml

from scara_drake.recordings.surfaces import KIND, read_scenario

ABSENT: Final = "none"
# Of a recording's attributes, what says how it was made.
MADE_BY: Final = ("scenario_name", "seed", "engine", "versions", "device", "ended_by")


def scenario_differences(recordings: Sequence[xr.Dataset]) -> dict[str, list[str]]:
    """Return the fields, and other attributes, whose values are not the same in all recordings.

    Of a part that is not of one kind the kinds are told, and not the fields.

    Returns:
        The values, as texts, by the path of the field, such as ``controller.phi``.
    """
    told = [_fields(recording) for recording in recordings]
    names = dict.fromkeys(name for fields in told for name in fields)
    rows = {name: [fields.get(name, ABSENT) for fields in told] for name in names}
    differing = {name: values for name, values in rows.items() if len(set(values)) > 1}
    kinds = [f"{name}." for name, values in differing.items() if any(v[:1] == "!" for v in values)]
    return {name: values for name, values in differing.items() if not name.startswith(tuple(kinds))}


def _fields(recording: xr.Dataset) -> dict[str, str]:
    found = {name: str(recording.attrs[name]) for name in MADE_BY if name in recording.attrs}
    try:
        scenario = read_scenario(str(recording.attrs.get("scenario", "")))
    except ValueError:
        return found
    found.update(_flat("", scenario))
    return found


def _flat(path: str, value: Any) -> Iterator[tuple[str, str]]:
    """Paths and values of what is in a mapping, or in a list of mappings, at any depth.

    An empty list has none.
    """
    if isinstance(value, dict):
        for key, entry in value.items():
            if key == KIND:
                yield path, f"!{entry}"
            else:
                yield from _flat(f"{path}.{key}" if path else str(key), entry)
    elif isinstance(value, list) and all(isinstance(entry, dict) for entry in value):
        for index, entry in enumerate(value):
            yield from _flat(f"{path}.{index}", entry)
    else:
        text = yaml.safe_dump(value, default_flow_style=True, width=1_000)
        yield path, text.removesuffix("\n").removesuffix("\n...")
