"""What a recording holds that is shown: joints, desired tool, force, and the surfaces."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr
from meshcat.transformations import rotation_matrix
from numpy.typing import NDArray

from scara_drake.joints import JOINT_NAMES
from scara_drake.recordings.files import UNREADABLE, open_recording
from scara_drake.recordings.surfaces import KIND, facing, surfaces_of

Array = NDArray[np.float64]

_OF_A_MASTER = ("x_master", "hand_target")  # where there is one
_SIGNALS = ["q_measured", "q_desired", "p_WE_desired", "f_env_on_tool_W"]
YEAR = 3.2e7  # [s]: no run is longer, and none could be drawn
_KINDS = ("Wall", "Box", "Cylinder")
_SIZES = ("size", "thickness", "radius", "length")
_NUMBERS = {"point", "normal", "direction", "centre", "rpy", *_SIZES}


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


def read_surfaces(scenario: str) -> list[Block]:
    """Read the walls, boxes and cylinders of a scenario's YAML text, where they are at rest.

    Of other kinds, such as a surface of the user's own, the text does not say the shape.
    """
    blocks = []
    for data in surfaces_of(scenario):
        if data[KIND] not in _KINDS:
            continue
        # YAML takes 1e-05 for a text; numpy takes it for the number it is.
        read = {key: np.array(data[key], dtype=np.float64) for key in _NUMBERS & data.keys()}
        if "rpy" in read:
            turns = zip(read["rpy"][::-1], np.eye(3)[::-1], strict=True)
            X_WB = np.linalg.multi_dot([rotation_matrix(*turn) for turn in turns])
        else:
            X_WB = np.eye(4)
            X_WB[:3, :3] = facing(read["normal" if "normal" in read else "direction"])
        X_WB[:3, 3] = read.get("centre", read.get("point"))
        sizes = [read[key] for key in _SIZES if key in read]
        if "normal" in read:  # a block behind the plane
            X_WB[:3, 3] -= read["thickness"] / 2 * X_WB[:3, 2]
        blocks.append(Block(np.hstack(sizes).tolist(), X_WB, "normal" in read))
    return blocks


def load(path: str | Path) -> tuple[xr.Dataset, list[Block]]:
    """Read of a recording what is shown: joints, desired tool, force; and the surfaces.

    Raises:
        ValueError: no such file, not a recording, or one that is damaged.
    """
    refusal = ValueError(f"recording: '{path}', allowed NetCDF written by a run")
    with open_recording(path) as recording:
        try:
            names = [*_SIGNALS, *(name for name in _OF_A_MASTER if name in recording)]
            data = recording[names].sel(joint=list(JOINT_NAMES)).load()
            blocks = read_surfaces(data.attrs["scenario"])
        except UNREADABLE:
            raise refusal from None
    times = data.time.values
    if times.size == 0 or not np.isfinite(data.q_measured).all() or not _is_a_clock(times):
        raise refusal
    return data, blocks


def _is_a_clock(times: Array) -> bool:
    """Whether times rise, and are those of a run: not below 0, nor above a year."""
    return bool(times[0] >= 0.0 and times[-1] <= YEAR and (np.diff(times) > 0.0).all())
