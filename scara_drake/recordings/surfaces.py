"""The scenario of a recording, and its surfaces, read without Drake."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np
import yaml
from numpy.typing import ArrayLike, NDArray

from scara_drake.common.urdf import rotation_from_rpy

Array = NDArray[np.float64]
KIND: Final = "_kind"
_KINDS: Final = ("Wall", "Box", "Cylinder")
_SIZES: Final = ("size", "thickness", "radius", "length")
_NUMBERS: Final = {"point", "normal", "direction", "centre", "rpy", *_SIZES}


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


class Block(NamedTuple):
    """The solid of a surface.

    Attributes:
        size: x, y, z of a box, radius and length of a cylinder along z [m].
        X_WB: pose (4, 4).
        framed: whether it is a wall, whose edges are drawn.
    """

    size: list[float]
    X_WB: Array
    framed: bool = False


def read_blocks(scenario: str) -> list[Block]:
    """Read the walls, boxes and cylinders of a scenario's YAML text, where they are at rest.

    Of other kinds, such as a surface of the user's own, the text does not say the shape.
    """
    blocks = []
    for data in surfaces_of(scenario):
        if data[KIND] not in _KINDS:
            continue
        # YAML takes 1e-05 for a text; numpy takes it for the number it is.
        read = {key: np.array(data[key], dtype=np.float64) for key in _NUMBERS & data.keys()}
        X_WB = np.eye(4)
        if "rpy" in read:
            X_WB[:3, :3] = rotation_from_rpy(read["rpy"])
        else:
            X_WB[:3, :3] = facing(read["normal" if "normal" in read else "direction"])
        X_WB[:3, 3] = read.get("centre", read.get("point"))
        sizes = [read[key] for key in _SIZES if key in read]
        if "normal" in read:  # a block behind the plane
            X_WB[:3, 3] -= read["thickness"] / 2 * X_WB[:3, 2]
        blocks.append(Block(np.hstack(sizes).tolist(), X_WB, "normal" in read))
    return blocks
