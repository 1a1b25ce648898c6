"""The part of a URDF that a picture needs: primitive visuals, and where the links are. No Drake."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Color = tuple[float, ...]  # red, green, blue, opacity

# The attributes that give the size of each shape.
SIZES = {"box": ("size",), "cylinder": ("radius", "length"), "sphere": ("radius",)}


class Visual(NamedTuple):
    """A shape on a link: box (x, y, z), cylinder (radius, length; along z) or sphere (radius)."""

    link: str
    name: str
    shape: str
    size: list[float]  # [m]
    X_LV: Array  # (4, 4), in the link's frame
    color: Color


def read_visuals(urdf: ET.Element) -> list[Visual]:
    """Read the visuals of all links.

    Raises:
        ValueError: a shape other than those of SIZES, or a visual without a colour.
    """
    colors = {m.get("name"): m.find("color") for m in urdf.findall("material")}
    visuals = []
    for link in urdf.findall("link"):
        for index, visual in enumerate(link.findall("visual")):
            path = link.get("name", ""), visual.get("name", f"visual_{index}")
            geometry = next(iter(visual.findall("geometry/*")), ET.Element("nothing"))
            shape = geometry.tag.rpartition("}")[2]  # without its XML namespace
            if shape not in SIZES:
                raise ValueError(f"{'/'.join(path)}: '{shape}', allowed {', '.join(SIZES)}")
            size = [number for key in SIZES[shape] for number in _numbers(geometry, key)]
            material, color = visual.find("material"), visual.find("material/color")
            if color is None and material is not None:
                color = colors.get(material.get("name"))
            if color is None:
                raise ValueError(f"{'/'.join(path)}: no colour, allowed a material that has one")
            rgba = tuple(_numbers(color, "rgba"))
            visuals.append(Visual(*path, shape, size, _origin(visual), rgba))
    return visuals


def _numbers(element: ET.Element | None, key: str, default: str = "") -> list[float]:
    text = default if element is None else element.get(key, default)
    return [float(word) for word in text.split()]


def _origin(element: ET.Element) -> Array:
    origin = element.find("origin")
    X = np.eye(4)
    X[:3, 3] = _numbers(origin, "xyz", "0 0 0")
    X[:3, :3] = rotation_from_rpy(_numbers(origin, "rpy", "0 0 0"))
    return X


def rotation_from_rpy(rpy: ArrayLike) -> Array:
    """Rotation (3, 3) = Rz(yaw) Ry(pitch) Rx(roll) of angles (3,) [rad], as a URDF has them."""
    (roll, pitch, yaw), (x, y, z) = np.asarray(rpy, dtype=np.float64), np.eye(3)
    return _rotation(z, yaw) @ _rotation(y, pitch) @ _rotation(x, roll)


def _rotation(axis: Array, angle: Array) -> Array:
    """Rotations (..., 3, 3) about a unit axis (3,) by angles (...) [rad], Rodrigues' formula."""
    x, y, z = axis
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    s, c = np.sin(angle)[..., None, None], np.cos(angle)[..., None, None]
    return np.eye(3) + s * K + (1.0 - c) * (K @ K)


class _Joint(NamedTuple):
    """What places a link: its parent, the joint's frame there, and how the joint moves."""

    parent: str
    X_PJ: Array  # (4, 4)
    name: str
    kind: str
    axis: Array  # (3,)


class LinkTree:
    """Where the links of a URDF are; read once, for many postures.

    Raises:
        ValueError: a joint that is not fixed, prismatic, revolute or continuous.
    """

    def __init__(self, urdf: ET.Element) -> None:
        joints = urdf.findall("joint")
        self._joints = {next(j.iter("child")).attrib["link"]: _joint(j) for j in joints}
        self._links = [link.attrib["name"] for link in urdf.findall("link")]

    def poses(self, q: Mapping[str, Array]) -> dict[str, Array]:
        """Pose X_WL (..., 4, 4) of every link, from the positions (...) [m, rad] of each joint."""
        known: dict[str, Array] = {}
        root = np.broadcast_to(np.eye(4), (*np.broadcast(*q.values()).shape, 4, 4))

        def pose(link: str) -> Array:
            if link not in known:
                joint = self._joints.get(link)
                known[link] = root
                if joint is not None:
                    known[link] = pose(joint.parent) @ joint.X_PJ @ _motion(joint, root, q)
            return known[link]

        return {link: pose(link) for link in self._links}


def _joint(element: ET.Element) -> _Joint:
    name, kind = element.attrib["name"], element.get("type", "")
    if kind not in ("prismatic", "revolute", "continuous", "fixed"):
        raise ValueError(f"{name}: '{kind}', allowed fixed, prismatic, revolute, continuous")
    axis = np.array(_numbers(element.find("axis"), "xyz", "1 0 0"))
    parent = next(element.iter("parent")).attrib["link"]
    return _Joint(parent, _origin(element), name, kind, axis)


def _motion(joint: _Joint, root: Array, q: Mapping[str, Array]) -> Array:
    """X_JL (..., 4, 4) of the link that a joint moves."""
    X = root.copy()
    if joint.kind == "prismatic":
        X[..., :3, 3] = joint.axis * q[joint.name][..., None]
    elif joint.kind != "fixed":
        X[..., :3, :3] = _rotation(joint.axis, q[joint.name])
    return X


def link_poses(urdf: ET.Element, q: Mapping[str, Array]) -> dict[str, Array]:
    """Pose X_WL (..., 4, 4) of every link, see `LinkTree`."""
    return LinkTree(urdf).poses(q)
