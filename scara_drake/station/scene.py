"""What the page's viewer shows: Meshcat's commands for the scene, and for one picture of it."""

from __future__ import annotations

import struct
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Sequence
from typing import Any, Final

import meshcat
import numpy as np
import umsgpack
from meshcat.commands import SetObject, SetProperty, SetTransform
from meshcat.path import Path as ScenePath
from numpy.typing import NDArray

from scara_drake.common.resources import resource
from scara_drake.common.urdf import LinkTree
from scara_drake.display import look
from scara_drake.display.solids import (
    add_part,
    add_robot,
    add_surfaces,
    corners_of,
)
from scara_drake.joints import JOINT_NAMES
from scara_drake.recordings.surfaces import Block, facing
from scara_drake.station.protocol import CameraView
from scara_drake.station.records import MAX_SURFACES
from scara_drake.vectors import POSE, STATE, pose_matrix

Array = NDArray[np.float64]

ROBOT, UNDELAYED, DESIRED, FORCE = "robot", "undelayed", "desired", "force"
GHOST: Final[look.Color] = (*look.HAND[:3], 0.25)  # of the robot as it is now, in a delayed view
TOOL_CAMERA: Final[CameraView] = {
    "name": "tool",
    "eye": [-0.45, 0.0, -0.75],
    "target": [0.0, 0.0, 0.1],
    "up": [-1.0, 0.0, 0.0],
    "zoom": 1.0,
    "frame": f"/meshcat/{ROBOT}/tool",
}


class _Keeper:
    """Stands for the window of a `meshcat.Visualizer`: what it sends is kept."""

    def __init__(self) -> None:
        self.commands: list[bytes] = []

    def send(self, command: SetObject | SetProperty | SetTransform) -> None:
        self.commands.append(umsgpack.packb(command.lower()))


def _visualizer() -> tuple[meshcat.Visualizer, _Keeper]:
    keeper = _Keeper()
    return meshcat.Visualizer.view_into(keeper, ScenePath(("meshcat",))), keeper


class Scene:
    """The robot, the surfaces and what is shown beside them.

    Args:
        blocks: the surfaces that are drawn, in the order of `feed.StationFeed`.
        marks: what is drawn besides, in W.
    """

    def __init__(self, blocks: list[Block], marks: Sequence[look.Part] = ()) -> None:
        urdf = ET.parse(resource("models", "scara6.urdf")).getroot()
        self._links = LinkTree(urdf)
        self._moving = min(len(blocks), MAX_SURFACES)
        self._seen = [*map(corners_of, blocks), *(mark.X[None, :3, 3] for mark in marks)]
        viewer, keeper = _visualizer()
        add_robot(viewer, urdf, ROBOT)
        add_robot(viewer, urdf, UNDELAYED, GHOST)
        for part in look.GHOST:
            add_part(viewer[f"{DESIRED}/{part.name}"], part)
        for part in (look.SHAFT, look.TIP):
            add_part(viewer[f"{FORCE}/{part.name}/solid"], part, on_top=True)
        add_surfaces(viewer, blocks)
        for mark in marks:
            add_part(viewer[f"marks/{mark.name}"], mark)
        for name, color in look.SKY.items():
            viewer["/Background"].set_property(name, color)
        viewer["/Axes"].set_property("visible", False)
        viewer["/Grid"].set_property("visible", True)
        for hidden in (UNDELAYED, DESIRED, FORCE):  # until the first picture
            viewer[hidden].set_property("visible", False)
        self.commands = keeper.commands

    def picture(self, shown: Any, now: Any | None = None) -> list[bytes]:
        """Return the commands that put everything where it is in a frame.

        Args:
            shown: the frame of the solid robot.
            now: of its ghost, where `shown` is older; None for no ghost.
        """
        viewer, keeper = _visualizer()
        links = self._poses(shown)
        _place(viewer, ROBOT, links)
        viewer[UNDELAYED].set_property("visible", now is not None)
        if now is not None:
            _place(viewer, UNDELAYED, self._poses(now))
        desired = (now if now is not None else shown)["X_WE_desired"]
        known = bool(np.isfinite(desired[: POSE.size]).all())
        viewer[DESIRED].set_property("visible", known)
        if known:
            viewer[DESIRED].set_transform(pose_matrix(desired))
        _place_force(viewer, shown["f_env_on_tool_W"], links["tool"])
        for index in range(self._moving):
            if shown["surfaces"][index].any():
                viewer[f"surfaces/{index}"].set_transform(look.at(*shown["surfaces"][index]))
        return keeper.commands

    def _poses(self, frame: Any) -> dict[str, Array]:
        q = STATE.unpack(np.nan_to_num(frame["state"])).q
        return self._links.poses(dict(zip(JOINT_NAMES, q, strict=True)))

    def views(self) -> list[CameraView]:
        """Return the places for the camera: the operator's first."""
        eye, target = look.camera(np.vstack([np.empty((0, 3)), *self._seen]))
        distance = float(np.linalg.norm(eye - target))
        whole_eye, whole_target = look.camera(look.WHOLE)
        across = {"side": [0.0, -1.0, 0.05], "front": [1.0, 0.0, 0.05], "above": [0.01, 0.0, 1.0]}
        return [
            _view("operator", eye, target),
            *(
                _view(name, target + distance * np.array(direction), target)
                for name, direction in across.items()
            ),
            _view("whole", whole_eye, whole_target),
            TOOL_CAMERA,
        ]


def _place(viewer: meshcat.Visualizer, path: str, links: dict[str, Array]) -> None:
    for link, X_WL in links.items():
        viewer[f"{path}/{link}"].set_transform(X_WL)


def _place_force(viewer: meshcat.Visualizer, f_env_on_tool_W: Array, X_WE: Array) -> None:
    """The force (3,) [N] on the tool, an arrow that ends at it."""
    force = np.nan_to_num(f_env_on_tool_W)
    newtons = float(np.linalg.norm(force))
    seen = newtons >= look.SMALLEST_FORCE
    viewer[FORCE].set_property("visible", seen)
    if seen:
        X_WF = look.at(*X_WE[:3, 3])
        X_WF[:3, :3] = facing(force)
        viewer[FORCE].set_transform(X_WF)
        length = float(look.shaft_length(newtons))
        shaft = look.at(0.0, 0.0, float(look.shaft_middle(length)))
        shaft[2, 2] = length
        viewer[f"{FORCE}/shaft"].set_transform(shaft)


def _view(name: str, eye: Array, target: Array) -> CameraView:
    return {
        "name": name,
        "eye": eye.tolist(),
        "target": target.tolist(),
        "up": [0.0, 0.0, 1.0],
        "zoom": look.ZOOM,
        "frame": "",
    }


def pack(number: int, commands: Iterable[bytes]) -> bytes:
    """Return the message of one picture, see `protocol`."""
    parts = [struct.pack("<I", number)]
    for command in commands:
        parts += [struct.pack("<I", len(command)), command]
    return b"".join(parts)
