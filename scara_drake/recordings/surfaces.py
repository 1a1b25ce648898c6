"""The scenario of a recording, and its surfaces, read without Drake."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import yaml
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
KIND: Final = "_kind"


class _Untagged(yaml.SafeLoader):
    """Reads a mapping with a tag, such as ``!Joystick``, as one with the tag as an entry."""


_Untagged.add_multi_constructor(
    "!", lambda loader, tag, node: {KIND: tag} | loader.construct_mapping(node, True)
)


def read_scenario(scenario: str) -> dict[str, Any]:
    """Read a scenario's YAML text as plain data; the kind of a part is under `KIND`.

    Raises:
        ValueError: the text is not that of a scenario.
    """
    try:
        data = yaml.load(scenario, _Untagged)
    except (yaml.YAMLError, LookupError, TypeError, RecursionError):
        data = None
    if not isinstance(data, dict):
        raise ValueError("scenario: not that of a recording, allowed YAML with surfaces")
    return data


def surfaces_of(scenario: str) -> list[dict[str, Any]]:
    """Read the surfaces of a scenario's YAML text: their fields, and their kind under `KIND`.

    Raises:
        ValueError: the text is not that of a scenario.
    """
    try:
        surfaces = read_scenario(scenario)["environment"]["surfaces"]
    except (LookupError, TypeError):
        raise ValueError("scenario: not that of a recording, allowed YAML with surfaces") from None
    if not isinstance(surfaces, list) or not all(isinstance(one, dict) for one in surfaces):
        raise ValueError("environment.surfaces: allowed a list of mappings")
    return [{KIND: "Wall"} | surface for surface in surfaces]


def facing(direction: ArrayLike) -> Array:
    """Rotation (3, 3) whose z is a direction (3,); y is up, or the world's y if z is upright."""
    z = np.asarray(direction, dtype=np.float64) / np.linalg.norm(direction)
    x = np.cross([0.0, 1.0, 0.0] if abs(z[2]) > 0.99 else [0.0, 0.0, 1.0], z)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])
