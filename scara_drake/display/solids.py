"""Solids in meshcat-python: what a replay and the station draw where Drake is not there."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Sequence
from itertools import product
from typing import Any

import meshcat
import meshcat.geometry as shapes
import numpy as np
from meshcat.transformations import rotation_matrix
from numpy.typing import NDArray

from scara_drake.common.urdf import read_visuals
from scara_drake.display import look
from scara_drake.recordings.surfaces import Block

Array = NDArray[np.float64]


def add_robot(
    viewer: meshcat.Visualizer, urdf: ET.Element, path: str, color: look.Color | None = None
) -> None:
    """Draw the links of a URDF, each at `PATH/LINK`, in their colours or in one for all."""
    for visual in read_visuals(urdf):
        node = viewer[f"{path}/{visual.link}/{visual.name}"]
        add_solid(node, visual.shape, visual.size, visual.X_LV, color or visual.color)


def add_surfaces(viewer: meshcat.Visualizer, blocks: list[Block]) -> None:
    """Draw surfaces, of which those at rest need no more: each at `surfaces/INDEX`."""
    for index, (size, X_WB, framed) in enumerate(blocks):
        shape = "box" if len(size) == 3 else "cylinder"
        add_solid(viewer[f"surfaces/{index}/solid"], shape, size, X_WB, look.SURFACE)
        for bar in look.edge_frame(size[:2], size[2]) if framed else ():
            add_part(viewer[f"surfaces/{index}/{bar.name}"], bar._replace(X=X_WB @ bar.X))


class OnTop(shapes.Mesh):
    """Drawn after all else: a surface before it, though translucent, would wash it out."""

    def lower(self) -> dict[str, Any]:
        """Return what meshcat sends."""
        data: dict[str, Any] = super().lower()
        data["object"]["renderOrder"] = 1.0
        return data


def add_part(node: meshcat.Visualizer, part: look.Part, on_top: bool = False) -> None:
    """Draw a part of `look` at a node."""
    add_solid(node, part.shape, part.size, part.X, part.color, on_top)


def add_solid(
    node: meshcat.Visualizer,
    shape: str,
    size: Sequence[float],
    X: Array,
    color: Sequence[float],
    on_top: bool = False,
) -> None:
    """Draw a shape at a node: its size as in `look.Part`, where its middle is, and its colour."""
    if shape == "box":
        solid = shapes.Box(list(size))
    elif shape == "sphere":
        solid = shapes.Sphere(*size)
    else:
        radius, length = size
        top = 0.0 if shape == "cone" else radius
        solid = shapes.Cylinder(length, radiusTop=top, radiusBottom=radius)
        X = X @ rotation_matrix(np.pi / 2, [1, 0, 0])  # meshcat's cylinders lie along y
    phong = {"color": hex_of(color), "opacity": color[3]}
    if on_top:
        node.set_object(OnTop(solid, shapes.MeshPhongMaterial(**phong, depthTest=False)))
    else:
        node.set_object(solid, shapes.MeshPhongMaterial(**phong))
    node.set_transform(X)


def hex_of(color: Sequence[float]) -> int:
    """Return a colour as a number, red first."""
    return int.from_bytes(bytes(round(255 * part) for part in color[:3]))


def corners_of(block: Block) -> Array:
    """Corners (n, 3) [m] of the box around a block, of a wall those of its surface."""
    size = np.array(block.size)
    if size.size == 2:
        radius, length = block.size
        size = np.array([2 * radius, 2 * radius, length])
    ends = (-0.5, 0.5)
    signs = np.array([*product(ends, ends, ends[1:] if block.framed else ends)])
    return (signs * size) @ block.X_WB[:3, :3].T + block.X_WB[:3, 3]
