"""Recordings for rerun: the robot, the plots and the time slider together, laid out.

| entities | content |
|---|---|
| ``world/...`` | robot, surfaces, desired tool, arrow of the force, way of the tool |
| ``curves/...`` | errors, forces and delays, in the units of the plots |
| ``signals/q_measured/d1`` and so on | every variable, entry by entry, in SI units |
| ``scenario`` | the YAML text |
"""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path
from typing import Any, Final

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
import xarray as xr
from numpy.typing import NDArray

from scara_drake.common.files import whole_file
from scara_drake.display import look
from scara_drake.exports import scene
from scara_drake.metrics.curves import (
    AGES,
    CONTACT_FORCE,
    EFFORTS,
    FELT_FORCES,
    JOINT_ERRORS,
    SLIDING_VARIABLES,
    TOOL_ERROR,
    Curve,
)
from scara_drake.recordings.table import columns, pieces

Array = NDArray[np.float64]

TIMELINE: Final = "time"
_SCENE_NEEDS: Final = ("q_measured", "q_desired", "p_WE_desired", "p_WE_measured")
# Beside each other as the operator and as the researcher ask.
VIEWS: Final[dict[str, dict[str, tuple[Curve, ...]]]] = {
    "operator": {
        "force": (CONTACT_FORCE, *FELT_FORCES),
        "tool error": (TOOL_ERROR,),
        "age": AGES,
    },
    "controller": {
        "joint errors": JOINT_ERRORS,
        "sliding variable": SLIDING_VARIABLES,
        "effort": EFFORTS,
    },
}
_STICK: Final = "signals/joystick_axes"


def write(recording: xr.Dataset, path: Path) -> None:
    """Write a recording for rerun.

    Raises:
        ValueError: the recording has no scenario.
        OSError: the file cannot be written.
    """
    name = str(recording.attrs.get("scenario_name", path.stem))
    with whole_file(path) as partial:
        stream = rr.RecordingStream("scara_drake", recording_id=path.stem)
        try:
            stream.save(partial)
            _write(stream, recording, name)
            stream.flush()
        finally:
            stream.disconnect()


def _write(stream: rr.RecordingStream, recording: xr.Dataset, name: str) -> None:
    stream.send_recording_name(name)
    text = str(recording.attrs.get("scenario", ""))
    document = rr.TextDocument(f"```yaml\n{text}\n```", media_type="text/markdown")
    stream.log("scenario", document, static=True)
    has_scene = all(each in recording for each in _SCENE_NEEDS)
    if has_scene:
        _add_solids(stream, recording)
    drawn: set[str] = set()
    picture = -1.0
    for piece in pieces(recording):
        drawn |= _add_signals(stream, piece)
        drawn |= _add_curves(stream, piece)
        if has_scene:
            rows, picture = scene.pictured(piece.time.values, picture)
            _add_pictures(stream, piece.isel(time=rows))
    stream.send_blueprint(_blueprint(drawn))


def _signal(variable: str, entry: dict[str, str]) -> str:
    return "/".join(["signals", variable, *map(str, entry.values())])


def _add_signals(stream: rr.RecordingStream, piece: xr.Dataset) -> set[str]:
    """Write the variables that there are; return their entities."""
    found = set()
    times = [rr.TimeColumn(TIMELINE, duration=piece.time.values)]
    for column in columns(piece)[1:]:
        values = piece[column.variable].sel(column.entry).values
        if np.isfinite(values).any():
            where = _signal(column.variable, column.entry)
            said = f"{column.name} [{column.unit}]"
            stream.log(where, rr.SeriesLines(names=said), static=True)
            stream.send_columns(where, times, rr.Scalars.columns(scalars=values))
            found.add(where)
    return found


def _add_curves(stream: rr.RecordingStream, piece: xr.Dataset) -> set[str]:
    """Write the curves that there are; return their entities."""
    times = [rr.TimeColumn(TIMELINE, duration=piece.time.values)]
    found = set()
    for views in VIEWS.values():
        for view, curves in views.items():
            for curve in curves:
                shown = curve.shown(piece)
                if shown is not None:
                    where = f"curves/{view}/{curve.name}".replace(" ", "_")
                    said = f"{curve.name} [{curve.unit}]"
                    stream.log(where, rr.SeriesLines(names=said), static=True)
                    stream.send_columns(where, times, rr.Scalars.columns(scalars=shown.values))
                    found.add(where)
    return found


def _add_solids(stream: rr.RecordingStream, recording: xr.Dataset) -> None:
    stream.log(scene.WORLD, rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    groups: dict[tuple[str, str], list[scene.Solid]] = defaultdict(list)
    for solid in scene.solids(recording):
        groups[solid.frame, solid.shape].append(solid)
    for (frame, shape), group in groups.items():
        stream.log(f"{_frame(frame)}/{shape}", _drawn(shape, group), static=True)


def _drawn(shape: str, group: list[scene.Solid]) -> Any:
    """Solids of one shape as what rerun draws."""
    X, sizes = np.array([solid.X for solid in group]), np.array([solid.size for solid in group])
    placed: dict[str, Any] = {
        "centers": X[:, :3, 3],
        "quaternions": scene.quaternions(X[:, :3, :3]),
        "colors": np.array([solid.color for solid in group]),
        "fill_mode": rr.components.FillMode.Solid,
    }
    if shape == "box":
        return rr.Boxes3D(half_sizes=sizes / 2, **placed)
    if shape == "cylinder":
        return rr.Cylinders3D(radii=sizes[:, 0], lengths=sizes[:, 1], **placed)
    return rr.Ellipsoids3D(radii=sizes[:, 0], **placed)


def _frame(frame: str) -> str:
    return scene.WORLD if frame == scene.WORLD else f"{scene.WORLD}/{frame}"


def _add_pictures(stream: rr.RecordingStream, piece: xr.Dataset) -> None:
    if not piece.sizes["time"]:
        return
    for frame, X in scene.frames(piece).items():
        known = np.isfinite(X).all(axis=(1, 2))
        if known.any():
            stream.send_columns(
                _frame(frame),
                [rr.TimeColumn(TIMELINE, duration=piece.time.values[known])],
                rr.Transform3D.columns(
                    translation=X[known, :3, 3], quaternion=scene.quaternions(X[known, :3, :3])
                ),
            )
    if "f_env_on_tool_W" in piece:
        starts, ways = scene.arrows(piece)
        stream.log(
            f"{scene.WORLD}/force",
            rr.Arrows3D.from_fields(colors=_packed(look.FORCE), radii=look.SHAFT.size[0]),
            static=True,
        )
        stream.send_columns(
            f"{scene.WORLD}/force",
            [rr.TimeColumn(TIMELINE, duration=piece.time.values)],
            rr.Arrows3D.columns(origins=starts, vectors=ways),
        )
    stream.log(
        f"{scene.WORLD}/trail",
        rr.Points3D.from_fields(colors=_packed(look.MEASURED), radii=look.TRAIL_RADIUS),
        static=True,
    )
    stream.send_columns(
        f"{scene.WORLD}/trail",
        [rr.TimeColumn(TIMELINE, duration=piece.time.values)],
        rr.Points3D.columns(positions=piece.p_WE_measured.values),
    )


def _packed(color: look.Color) -> Array:
    """A colour as an array: rerun takes a tuple for bytes."""
    return np.array([color])


def _blueprint(drawn: set[str]) -> rrb.Blueprint:
    """Robot on the left, plots on the right, and the time slider below."""
    tabs = []
    for tab, views in VIEWS.items():
        origins = {view: f"curves/{view}".replace(" ", "_") for view in views}
        if tab == "operator":
            origins["stick"] = _STICK
        plots = [
            rrb.TimeSeriesView(name=view, origin=origin)
            for view, origin in origins.items()
            if any(each.startswith(f"{origin}/") for each in drawn)
        ]
        if plots:
            tabs.append(rrb.Vertical(*plots, name=tab))
    eye, target = look.camera(np.empty((0, 3)))
    from_the_start = rrb.VisibleTimeRange(
        TIMELINE,
        start=rrb.TimeRangeBoundary.infinite(),
        end=rrb.TimeRangeBoundary.cursor_relative(),
    )
    robot = rrb.Spatial3DView(
        name="robot",
        origin=scene.WORLD,
        background=[230, 238, 245],
        eye_controls=rrb.EyeControls3D(position=eye, look_target=target, eye_up=[0.0, 0.0, 1.0]),
        overrides={f"{scene.WORLD}/trail": [rrb.VisibleTimeRanges([from_the_start])]},
    )
    return rrb.Blueprint(
        rrb.Horizontal(
            robot,
            rrb.Tabs(*tabs, rrb.TextDocumentView(name="scenario", origin="scenario")),
            column_shares=[3, 2],
        ),
        rrb.TimePanel(timeline=TIMELINE, state="collapsed"),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
    )
