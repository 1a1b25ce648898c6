"""What a recording shows in three dimensions: solids, and the frames that carry them."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator, Sequence
from typing import Final, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from scara_drake.common.resources import resource
from scara_drake.common.urdf import link_poses, read_visuals
from scara_drake.display import look
from scara_drake.joints import JOINT_NAMES
from scara_drake.recordings.surfaces import read_blocks

Array = NDArray[np.float64]

WORLD: Final = "world"
DESIRED: Final = "desired"  # frame of the tool as the references have it
PERIOD: Final = 0.02  # [s], from picture to picture
# Where the frames of what an operator's device does come from; see `look.HELD`.
_HELD: Final = {"motion_master": "x_master", "hand_target": "hand_target"}


class Solid(NamedTuple):
    """A solid in a frame.

    Attributes:
        frame: that carries it.
        name: of its own.
        shape: box, cylinder (along z) or sphere.
        size: x, y, z of a box; radius and length of a cylinder; radius of a sphere [m].
        X: pose (4, 4) in the frame.
        color: red, green, blue, opacity.
    """

    frame: str
    name: str
    shape: str
    size: Sequence[float]
    X: Array
    color: Sequence[float]


def urdf_text() -> str:
    """Return the URDF of the robot."""
    return resource("models", "scara6.urdf").read_text(encoding="utf-8")


def solids(recording: xr.Dataset) -> Iterator[Solid]:
    """Yield the robot, the desired tool, the surfaces, and the operator's device if there is one.

    Raises:
        ValueError: the recording has no scenario.
    """
    for visual in read_visuals(ET.fromstring(urdf_text())):
        yield Solid(*visual)
    for part in look.GHOST:
        yield _solid(DESIRED, part)
    for index, block in enumerate(read_blocks(str(recording.attrs.get("scenario", "")))):
        shape = "box" if len(block.size) == 3 else "cylinder"
        yield Solid(WORLD, f"surface_{index}", shape, block.size, block.X_WB, look.SURFACE)
        for bar in look.edge_frame(block.size[:2], block.size[2]) if block.framed else ():
            yield _solid(WORLD, bar._replace(name=f"{index}_{bar.name}", X=block.X_WB @ bar.X))
    if all(name in recording for name in _HELD.values()):
        board = look.BOARD._replace(X=look.at(*look.BOARD_PLACE) @ look.BOARD.X)
        yield _solid(WORLD, board)
        for signal in _HELD:
            yield _solid(look.HELD[signal].name, look.HELD[signal])


def frames(recording: xr.Dataset) -> dict[str, Array]:
    """Poses (n, 4, 4) in the world of the frames at each sample; NaN where one is not known."""
    urdf = ET.fromstring(urdf_text())

    def links(name: str) -> dict[str, Array]:
        q = recording[name].sel(joint=list(JOINT_NAMES)).values
        return link_poses(urdf, dict(zip(JOINT_NAMES, q.T, strict=True)))

    found = {name: X.copy() for name, X in links("q_measured").items() if name != WORLD}
    found[DESIRED] = links("q_desired")["tool"].copy()
    found[DESIRED][:, :3, 3] = recording.p_WE_desired.values
    if all(name in recording for name in _HELD.values()):
        for signal, name in _HELD.items():
            X = np.tile(np.eye(4), (recording.sizes["time"], 1, 1))
            X[:, :3, 3] = look.BOARD_PLACE + look.on_board(recording[name].values)
            found[look.HELD[signal].name] = X
    return found


def arrows(recording: xr.Dataset) -> tuple[Array, Array]:
    """Where the arrows of the force start (n, 3) [m], and the ways to their tips (n, 3) [m].

    They end at the tool, as the force pushes on it; without a force to be seen they have no length.
    """
    tool = recording.p_WE_measured.values
    force = np.nan_to_num(recording.f_env_on_tool_W.values)
    newtons = np.linalg.norm(force, axis=1)
    length = np.where(newtons < look.SMALLEST_FORCE, 0.0, look.shaft_length(newtons) + look.HEAD)
    way = force * (length / np.maximum(newtons, look.SMALLEST_FORCE))[:, None]
    return tool - way, way


def pictured(times: Array, before: float) -> tuple[NDArray[np.intp], float]:
    """Rows of the samples at which a picture is due, and the number of the last one.

    Args:
        times: [s].
        before: number of the last picture of the piece before.
    """
    numbers = np.floor((times + 1e-9) / PERIOD)
    rows = np.flatnonzero(np.diff(numbers, prepend=before) > 0.0)
    return rows, float(numbers[-1]) if numbers.size else before


def quaternions(R: Array) -> Array:
    """Unit quaternions x, y, z, w (..., 4) of rotations (..., 3, 3).

    Of the four forms the one that divides by the largest entry.
    """
    xx, yy, zz = R[..., 0, 0], R[..., 1, 1], R[..., 2, 2]
    x = [1.0 + xx - yy - zz, R[..., 1, 0] + R[..., 0, 1], R[..., 0, 2] + R[..., 2, 0]]
    y = [x[1], 1.0 - xx + yy - zz, R[..., 2, 1] + R[..., 1, 2]]
    z = [x[2], y[2], 1.0 - xx - yy + zz]
    w = [R[..., 2, 1] - R[..., 1, 2], R[..., 0, 2] - R[..., 2, 0], R[..., 1, 0] - R[..., 0, 1]]
    rows = [[*x, w[0]], [*y, w[1]], [*z, w[2]], [*w, 1.0 + xx + yy + zz]]
    forms = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)  # (..., 4, 4)
    largest = np.einsum("...ii->...i", forms).argmax(axis=-1)
    chosen = np.take_along_axis(forms, largest[..., None, None], axis=-2)[..., 0, :]
    return np.asarray(chosen / np.linalg.norm(chosen, axis=-1, keepdims=True))


def _solid(frame: str, part: look.Part) -> Solid:
    return Solid(frame, part.name, part.shape, part.size, part.X, part.color)
