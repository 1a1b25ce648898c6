"""The scene of a recording in meshcat-python, looking like the live one."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from typing import Any

import meshcat
import meshcat.geometry as shapes
import numpy as np
import xarray as xr
from meshcat.transformations import translation_matrix
from numpy.typing import NDArray

from scara_drake.common.resources import resource
from scara_drake.common.urdf import link_poses
from scara_drake.display import look
from scara_drake.display.solids import add_part, add_robot, add_surfaces, corners_of, hex_of
from scara_drake.joints import JOINT_NAMES
from scara_drake.recordings.surfaces import Block, facing

Array = NDArray[np.float64]
Poses = dict[str, Array]  # by scene path, (n, 4, 4): one of each frame

TRAIL_PIECES = 200
HIDDEN = 1e-6  # scale of what is not to be seen; a scale of zero would lose the rotation


def draw(viewer: meshcat.Visualizer, data: xr.Dataset, blocks: list[Block], step: float) -> Poses:
    """Draw the start of a recording; return the poses of what moves, every `step` [s] of it.

    A pose holds a scale, which also hides what is not to be seen.
    """
    times = data.time.values
    moments = np.append(np.arange(times[0], times[-1] - 1e-9, step), times[-1])
    data = data.isel(time=np.searchsorted(times, moments + 1e-9, side="right") - 1)
    urdf = ET.parse(resource("models", "scara6.urdf")).getroot()
    links = _link_poses(urdf, data.q_measured.values)
    tool = links["tool"][:, :3, 3]
    poses = {f"robot/{link}": X_WL for link, X_WL in links.items()}
    add_robot(viewer, urdf, "robot")
    poses |= _add_ghost(viewer, urdf, data)
    poses |= _add_force(viewer, tool, np.nan_to_num(data.f_env_on_tool_W.values))
    poses |= _add_held(viewer, data)
    poses |= _add_trail(viewer, tool)
    add_surfaces(viewer, blocks)
    for path, X in poses.items():
        viewer[path].set_transform(X[0])
    _set_camera(viewer, blocks)
    return poses


def _link_poses(urdf: ET.Element, q: Array) -> Poses:
    return link_poses(urdf, dict(zip(JOINT_NAMES, q.T, strict=True)))


def _add_ghost(viewer: meshcat.Visualizer, urdf: ET.Element, data: xr.Dataset) -> Poses:
    """The desired tool, turned as the desired joints turn it."""
    for part in look.GHOST:
        add_part(viewer[f"desired/{part.name}"], part)
    q, position = data.q_desired.values, data.p_WE_desired.values
    known = np.isfinite(position).all(axis=1) & np.isfinite(q).all(axis=1)
    rotation = _link_poses(urdf, np.nan_to_num(q))["tool"][:, :3, :3]
    return {"desired": _poses(np.nan_to_num(position), known, rotation)}


def _add_force(viewer: meshcat.Visualizer, tool: Array, force: Array) -> Poses:
    """The force (n, 3) [N] on the tool, an arrow that ends at it."""
    for part in (look.SHAFT, look.TIP):
        add_part(viewer[f"force/{part.name}/solid"], part, on_top=True)
    newtons = np.linalg.norm(force, axis=1)
    R_WF = np.array([facing(f) if f.any() else np.eye(3) for f in force])
    length = look.shaft_length(newtons)
    shaft = np.tile(np.eye(4), (newtons.size, 1, 1))
    shaft[:, 2, 2] = np.maximum(length, HIDDEN)
    shaft[:, 2, 3] = look.shaft_middle(length)
    return {
        "force": _poses(tool, newtons >= look.SMALLEST_FORCE, R_WF),
        "force/shaft": shaft,
    }


def _add_held(viewer: meshcat.Visualizer, data: xr.Dataset) -> Poses:
    """The operator's device and where his hand wants it, if there is one that pushes."""
    signals = {"motion_master": "x_master", "hand_target": "hand_target"}
    if not all(name in data and np.isfinite(data[name]).all() for name in signals.values()):
        return {}
    X_WB, poses = look.at(*look.BOARD_PLACE), {}
    add_part(viewer["board/board"], look.BOARD._replace(X=X_WB @ look.BOARD.X))
    for signal, name in signals.items():
        part, places = look.HELD[signal], look.BOARD_PLACE + look.on_board(data[name].values)
        add_part(viewer[f"board/{part.name}/solid"], part)
        poses[f"board/{part.name}"] = _poses(places, np.ones(len(places)))
    return poses


def _add_trail(viewer: meshcat.Visualizer, tool: Array) -> Poses:
    """The way of the tool (n, 3) [m], in pieces that are there once it has gone them."""
    poses: Poses = {}
    last = len(tool) - 1
    stride = math.ceil(len(tool) / TRAIL_PIECES)
    for start in range(0, last, stride):
        end = min(start + stride, last)
        points = shapes.PointsGeometry((tool[start : end + 1] - tool[start]).T)
        line = shapes.Line(points, shapes.LineBasicMaterial(color=hex_of(look.MEASURED)))
        viewer[f"trail/{start}/line"].set_object(line)
        poses[f"trail/{start}"] = _poses(tool[start], np.arange(len(tool)) >= end)
    return poses


def _poses(position: Array, scale: NDArray[Any], rotation: Array | None = None) -> Array:
    X = np.tile(np.eye(4), (scale.size, 1, 1))
    X[:, :3, :3] = np.eye(3) if rotation is None else rotation
    X[:, :3, :3] *= np.maximum(scale, HIDDEN)[:, None, None]
    X[:, :3, 3] = position
    return X


def _set_camera(viewer: meshcat.Visualizer, blocks: list[Block]) -> None:
    """Put the target of the camera where it looks, the origin, and the camera before it."""
    eye, target = look.camera(np.vstack([np.empty((0, 3)), *map(corners_of, blocks)]))
    x, y, z = eye - target
    viewer.set_transform(translation_matrix(-target))
    viewer["/Grid"].set_transform(translation_matrix(-target))
    lens = viewer["/Cameras/default/rotated/<object>"]
    lens.set_property("position", [x, z, -y])  # y is up here
    lens.set_property("zoom", look.ZOOM)
    for name, color in look.SKY.items():
        viewer["/Background"].set_property(name, color)
    viewer["/Axes"].set_property("visible", False)
