"""JSON Schemas of the messages that Foxglove knows by name, and of one variable's numbers.

Source: docs.foxglove.dev, "Message schemas".
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

from scara_drake.recordings.table import Column

NUMBER: Final = {"type": "number"}
TEXT: Final = {"type": "string"}


def _object(title: str = "", **properties: Any) -> dict[str, Any]:
    named = {"title": title} if title else {}
    return {**named, "type": "object", "properties": properties}


def _list(items: dict[str, Any]) -> dict[str, Any]:
    return {"type": "array", "items": items}


_SECONDS: Final = _object(sec={"type": "integer"}, nsec={"type": "integer"})
_VECTOR: Final = _object(x=NUMBER, y=NUMBER, z=NUMBER)
_QUATERNION: Final = _object(x=NUMBER, y=NUMBER, z=NUMBER, w=NUMBER)
_COLOR: Final = _object(r=NUMBER, g=NUMBER, b=NUMBER, a=NUMBER)
_POSE: Final = _object(position=_VECTOR, orientation=_QUATERNION)
_SOLID: Final = _object(pose=_POSE, size=_VECTOR, color=_COLOR)
_ARROW: Final = _object(
    pose=_POSE,
    shaft_length=NUMBER,
    shaft_diameter=NUMBER,
    head_length=NUMBER,
    head_diameter=NUMBER,
    color=_COLOR,
)
_CYLINDER: Final = _object(
    pose=_POSE, size=_VECTOR, bottom_scale=NUMBER, top_scale=NUMBER, color=_COLOR
)
_TRANSFORM: Final = _object(
    timestamp=_SECONDS,
    parent_frame_id=TEXT,
    child_frame_id=TEXT,
    translation=_VECTOR,
    rotation=_QUATERNION,
)
_JOINT: Final = _object(name=TEXT, position=NUMBER, velocity=NUMBER, effort=NUMBER)
_ENTITY: Final = _object(
    timestamp=_SECONDS,
    frame_id=TEXT,
    id=TEXT,
    lifetime=_SECONDS,
    frame_locked={"type": "boolean"},
    metadata=_list(_object(key=TEXT, value=TEXT)),
    arrows=_list(_ARROW),
    cubes=_list(_SOLID),
    spheres=_list(_SOLID),
    cylinders=_list(_CYLINDER),
    lines=_list(_object()),
    triangles=_list(_object()),
    texts=_list(_object()),
    models=_list(_object()),
)
_DELETION: Final = _object(timestamp=_SECONDS, type={"type": "integer"}, id=TEXT)

SCHEMAS: Final = {
    "foxglove.JointStates": _object(
        "foxglove.JointStates", timestamp=_SECONDS, joints=_list(_JOINT)
    ),
    "foxglove.FrameTransforms": _object("foxglove.FrameTransforms", transforms=_list(_TRANSFORM)),
    "foxglove.SceneUpdate": _object(
        "foxglove.SceneUpdate", deletions=_list(_DELETION), entities=_list(_ENTITY)
    ),
}


def variable_schema(columns: Sequence[Column]) -> dict[str, Any]:
    """Return the schema of a variable's numbers by their labels; units are in descriptions."""
    return _object(
        f"scara_drake.{columns[0].variable}",
        **{
            label_of(column): {
                "type": ["number", "null"],
                "description": f"{column.long_name} [{column.unit}]",
            }
            for column in columns
        },
    )


def label_of(column: Column) -> str:
    """Return the name of a number in its message: its label, or "value" where it is alone."""
    return "_".join(map(str, column.entry.values())) or "value"
