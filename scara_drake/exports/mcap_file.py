"""Recordings as MCAP, in JSON: for Foxglove, PlotJuggler and whatever else reads it.

| topic | schema | content |
|---|---|---|
| ``/q_measured`` and so on | ``scara_drake.q_measured`` | each sample of a variable by its labels |
| ``/joint_states`` | ``foxglove.JointStates`` | positions, rates, efforts, every picture |
| ``/tf`` | ``foxglove.FrameTransforms`` | links, desired tool, device in the world, every picture |
| ``/scene`` | ``foxglove.SceneUpdate`` | robot and surfaces, once; the arrow of the force |

The URDF and the scenario are attachments, the attributes of the recording are metadata. A message's
time is that since the start of the run, counted from 1970.
"""

from __future__ import annotations

import json
import math
from collections import defaultdict
from pathlib import Path
from typing import Any, Final

import numpy as np
import xarray as xr
from mcap.writer import Writer
from numpy.typing import NDArray

from scara_drake.common.files import whole_file
from scara_drake.display import look
from scara_drake.exports import scene
from scara_drake.exports.foxglove_schemas import SCHEMAS, label_of, variable_schema
from scara_drake.joints import JOINT_NAMES
from scara_drake.recordings.surfaces import facing
from scara_drake.recordings.table import Column, columns, pieces

Array = NDArray[np.float64]

NANOSECONDS: Final = 1e9
CHUNK: Final = 1 << 20  # [B], compressed as one
_SCENE_NEEDS: Final = ("q_measured", "q_desired", "p_WE_desired", "p_WE_measured")
_LISTS: Final = {"box": "cubes", "cylinder": "cylinders", "sphere": "spheres"}
_EMPTY: Final = ("arrows", "cubes", "spheres", "cylinders", "lines", "triangles", "texts", "models")


def write(recording: xr.Dataset, path: Path) -> None:
    """Write a recording as MCAP.

    Raises:
        ValueError: the recording has no scenario.
        OSError: the file cannot be written.
    """
    with whole_file(path) as partial, open(partial, "wb") as stream:
        file = _File(stream, recording)
        for piece in pieces(recording):
            file.add(piece)
        file.finish()


class _File:
    """An MCAP file that is being written; a topic is there once it has something to say."""

    def __init__(self, stream: Any, recording: xr.Dataset):
        self._writer = Writer(stream, chunk_size=CHUNK)
        self._writer.start(profile="", library="scara_drake")
        self._channels: dict[str, int] = {}
        self._sequence: dict[str, int] = defaultdict(int)
        self._variables: dict[str, list[Column]] = defaultdict(list)
        for column in columns(recording)[1:]:
            self._variables[column.variable].append(column)
        self._picture = -1.0
        self._has_scene = all(name in recording for name in _SCENE_NEEDS)
        texts = {str(name): str(value) for name, value in recording.attrs.items()}
        self._writer.add_metadata("scara_drake", texts)
        for name, kind, text in (
            ("scara6.urdf", "application/xml", scene.urdf_text()),
            ("scenario.yaml", "application/yaml", texts.get("scenario", "")),
        ):
            self._writer.add_attachment(0, 0, name, kind, text.encode())
        if self._has_scene:
            self._add_solids(recording)

    def add(self, piece: xr.Dataset) -> None:
        """Write the samples of a piece, each topic in the order of time."""
        stamps = np.round(piece.time.values * NANOSECONDS).astype(np.int64).tolist()
        for name, head in self._variables.items():
            values = _rows(piece, name, head)
            if np.isfinite(values).any():
                labels = [label_of(column) for column in head]
                for stamp, row in zip(stamps, values.tolist(), strict=True):
                    self._say(f"/{name}", stamp, dict(zip(labels, row, strict=True)))
        if self._has_scene:
            rows, self._picture = scene.pictured(piece.time.values, self._picture)
            self._add_pictures(piece.isel(time=rows), [stamps[row] for row in rows])

    def finish(self) -> None:
        """Write the index."""
        self._writer.finish()

    def _say(self, topic: str, stamp: int, message: dict[str, Any]) -> None:
        if topic not in self._channels:
            self._channels[topic] = self._register(topic)
        self._sequence[topic] += 1
        try:
            data = json.dumps(message, allow_nan=False)
        except ValueError:  # JSON has no NaN
            data = json.dumps(_finite(message))
        self._writer.add_message(
            self._channels[topic], stamp, data.encode(), stamp, self._sequence[topic]
        )

    def _register(self, topic: str) -> int:
        known = {
            "/joint_states": "foxglove.JointStates",
            "/tf": "foxglove.FrameTransforms",
            "/scene": "foxglove.SceneUpdate",
        }
        name = known.get(topic, f"scara_drake.{topic[1:]}")
        schema = SCHEMAS.get(name) or variable_schema(self._variables[topic[1:]])
        number = self._writer.register_schema(name, "jsonschema", json.dumps(schema).encode())
        return self._writer.register_channel(topic, "json", number)

    def _add_solids(self, recording: xr.Dataset) -> None:
        by_frame: dict[str, list[scene.Solid]] = defaultdict(list)
        for solid in scene.solids(recording):
            by_frame[solid.frame].append(solid)
        entities = []
        for frame, carried in by_frame.items():
            entity = _entity(frame, frame, 0)
            for solid in carried:
                entity[_LISTS[solid.shape]].append(_primitive(solid))
            entities.append(entity)
        self._say("/scene", 0, {"deletions": [], "entities": entities})

    def _add_pictures(self, piece: xr.Dataset, stamps: list[int]) -> None:
        if not stamps:
            return
        known = {
            frame: (X[:, :3, 3].tolist(), scene.quaternions(X[:, :3, :3]).tolist())
            for frame, X in scene.frames(piece).items()
        }
        names = ["q_measured", "v_measured", "tau_applied"]
        states = {
            key: piece[name].sel(joint=list(JOINT_NAMES)).values.tolist()
            for key, name in zip(("position", "velocity", "effort"), names, strict=True)
            if name in piece
        }
        starts, ways = scene.arrows(piece) if "f_env_on_tool_W" in piece else (None, None)
        for row, stamp in enumerate(stamps):
            time = _seconds(stamp)
            transforms = [
                {
                    "timestamp": time,
                    "parent_frame_id": scene.WORLD,
                    "child_frame_id": frame,
                    "translation": _vector(places[row]),
                    "rotation": dict(zip("xyzw", turns[row], strict=True)),
                }
                for frame, (places, turns) in known.items()
                if np.isfinite(places[row]).all() and np.isfinite(turns[row]).all()
            ]
            self._say("/tf", stamp, {"transforms": transforms})
            joints = [
                {"name": name, **{key: rows[row][index] for key, rows in states.items()}}
                for index, name in enumerate(JOINT_NAMES)
            ]
            self._say("/joint_states", stamp, {"timestamp": time, "joints": joints})
            if starts is not None and ways is not None:
                entity = _entity("force", scene.WORLD, stamp)
                entity["arrows"] = _arrow(starts[row], ways[row])
                self._say("/scene", stamp, {"deletions": [], "entities": [entity]})


def _finite(message: Any) -> Any:
    """A message in which what is no number is null."""
    if isinstance(message, dict):
        return {key: _finite(value) for key, value in message.items()}
    if isinstance(message, list):
        return [_finite(value) for value in message]
    return None if isinstance(message, float) and not math.isfinite(message) else message


def _rows(piece: xr.Dataset, name: str, head: list[Column]) -> Array:
    """The numbers of a variable (n, columns)."""
    return np.stack([piece[name].sel(column.entry).values for column in head], axis=-1)


def _seconds(stamp: int) -> dict[str, int]:
    return {"sec": stamp // 10**9, "nsec": stamp % 10**9}


def _vector(values: Any) -> dict[str, float]:
    return dict(zip("xyz", map(float, values), strict=True))


def _pose(X: Array) -> dict[str, Any]:
    turn = scene.quaternions(X[:3, :3]).tolist()
    return {"position": _vector(X[:3, 3]), "orientation": dict(zip("xyzw", turn, strict=True))}


def _color(color: Any) -> dict[str, float]:
    return dict(zip("rgba", map(float, color), strict=True))


def _entity(name: str, frame: str, stamp: int) -> dict[str, Any]:
    return {
        "timestamp": _seconds(stamp),
        "frame_id": frame,
        "id": name,
        "lifetime": _seconds(0),
        "frame_locked": True,
        "metadata": [],
        **{key: [] for key in _EMPTY},
    }


def _primitive(solid: scene.Solid) -> dict[str, Any]:
    size = list(solid.size)
    if solid.shape == "cylinder":
        size = [2 * size[0], 2 * size[0], size[1]]
    elif solid.shape == "sphere":
        size = 3 * [2 * size[0]]
    scales = {"bottom_scale": 1.0, "top_scale": 1.0} if solid.shape == "cylinder" else {}
    return {
        "pose": _pose(solid.X),
        "size": _vector(size),
        "color": _color(solid.color),
        **scales,
    }


def _arrow(start: Array, way: Array) -> list[dict[str, Any]]:
    length = float(np.linalg.norm(way))
    if length == 0.0:
        return []
    X = np.eye(4)
    X[:3, :3] = np.roll(facing(way), 1, axis=1)  # x points along an arrow
    X[:3, 3] = start
    return [
        {
            "pose": _pose(X),
            "shaft_length": length - look.HEAD,
            "shaft_diameter": 2 * look.SHAFT.size[0],
            "head_length": look.HEAD,
            "head_diameter": 2 * look.TIP.size[0],
            "color": _color(look.FORCE),
        }
    ]
