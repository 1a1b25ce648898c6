"""Play a recording where Drake has no wheel, as on Windows: meshcat-python draws, numpy moves.

    python -m scara_drake.replay runs/teleoperation.nc [--speed 2] [--html page.html]

Needs the extra ``replay``. The robot is that of models/scara6.urdf, the walls are those of the
scenario kept in the recording. The poses of all frames are worked out at once, then shown one after
the other or written into a page.
"""

from __future__ import annotations

import argparse
import io
import math
import sys
import time
import webbrowser
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, redirect_stdout
from pathlib import Path
from typing import Any

import meshcat
import meshcat.geometry as shapes
import numpy as np
import xarray as xr
import yaml
from meshcat.animation import Animation, AnimationClip, AnimationTrack
from meshcat.transformations import quaternion_from_matrix, rotation_matrix, translation_matrix
from numpy.typing import NDArray

from scara_drake.common.resources import resource
from scara_drake.replay.urdf import link_poses, read_visuals

Array = NDArray[np.float64]
Color = tuple[float, ...]  # red, green, blue, opacity
# Of each block the sizes x, y, z [m], of a cylinder the radius and the length; and X_WB (4, 4).
Walls = list[tuple[list[float], Array]]
Poses = dict[str, Array]  # by scene path, (n, 4, 4): one of each frame

WALL, DESIRED = (0.42, 0.58, 0.74, 0.30), (0.95, 0.05, 0.75, 1.0)
TRAIL, FORCE = (0.05, 0.62, 0.45, 1.0), (0.90, 0.04, 0.04, 1.0)
TRAIL_PIECES = 200
METRES_PER_NEWTON, LONGEST_ARROW, SMALLEST_FORCE = 1.0 / 250.0, 0.9, 1.0  # [m/N], [m], [N]
JOINTS = ["d1", "theta2", "theta3", "theta4", "theta5", "theta6"]
_SIZES = ("size", "thickness", "radius", "length")
_NUMBERS = {"point", "normal", "direction", "centre", "rpy", *_SIZES}
HIDDEN = 1e-6  # scale of what is not to be seen; a scale of zero would lose the rotation


class _Untagged(yaml.SafeLoader):
    """Reads a mapping with a tag, such as ``!Joystick``, as a plain one."""


_Untagged.add_multi_constructor("!", lambda loader, _, node: loader.construct_mapping(node, True))


def read_walls(scenario: str) -> Walls:
    """Read the walls, boxes and cylinders of a scenario's YAML text, where they are at rest."""
    walls = []
    for data in yaml.load(scenario, _Untagged)["environment"]["surfaces"]:
        # YAML takes 1e-05 for a text; numpy takes it for the number it is.
        read = {key: np.array(data[key], dtype=np.float64) for key in _NUMBERS & data.keys()}
        if "rpy" in read:
            turns = zip(read["rpy"][::-1], np.eye(3)[::-1], strict=True)
            X_WB = np.linalg.multi_dot([rotation_matrix(*turn) for turn in turns])
        else:
            X_WB = np.eye(4)
            X_WB[:3, :3] = _facing(read["normal" if "normal" in read else "direction"])
        X_WB[:3, 3] = read.get("centre", read.get("point"))
        sizes = [read[key] for key in _SIZES if key in read]
        if "normal" in read:  # a block behind the plane
            X_WB[:3, 3] -= read["thickness"] / 2 * X_WB[:3, 2]
        walls.append((np.hstack(sizes).tolist(), X_WB))
    return walls


def _facing(direction: Array) -> Array:
    """Rotation (3, 3) whose z is a direction (3,); y is up, or the world's y if z is upright."""
    z = direction / np.linalg.norm(direction)
    x = np.cross([0.0, 1.0, 0.0] if abs(z[2]) > 0.99 else [0.0, 0.0, 1.0], z)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def load(path: str | Path) -> tuple[xr.Dataset, Walls]:
    """Read of a recording what is shown: joint positions, desired tool, force; and the walls.

    Raises:
        ValueError: no such file, or not a recording.
    """
    if not Path(path).is_file():
        raise ValueError(f"recording: '{path}', allowed a file that exists")
    try:
        with xr.open_dataset(path, engine="h5netcdf") as file:
            data = file[["q_measured", "p_WE_desired", "f_env_on_tool_W"]].sel(joint=JOINTS).load()
        if data.time.size == 0 or not np.isfinite(data.q_measured).all():
            raise ValueError("no positions")
        return data, read_walls(data.attrs["scenario"])
    except (OSError, ValueError, LookupError, TypeError, yaml.YAMLError):
        raise ValueError(f"recording: '{path}', allowed NetCDF written by a run") from None


def draw(viewer: meshcat.Visualizer, data: xr.Dataset, walls: Walls, step: float) -> Poses:
    """Draw the start of a recording; return the poses of what moves, every `step` [s] of it.

    A pose holds a scale, which also hides what is not to be seen.
    """
    times = data.time.values
    moments = np.append(np.arange(times[0], times[-1] - 1e-9, step), times[-1])
    data = data.isel(time=np.searchsorted(times, moments + 1e-9, side="right") - 1)
    urdf = ET.parse(resource("models", "scara6.urdf")).getroot()
    links = link_poses(urdf, dict(zip(JOINTS, data.q_measured.values.T, strict=True)))
    poses = {f"robot/{link}": X_WL for link, X_WL in links.items()}
    for part in read_visuals(urdf):
        node = viewer[f"robot/{part.link}/{part.name}"]
        _add(node, part.shape, part.size, part.X_LV, part.color)
    for index, (size, X_WB) in enumerate(walls):
        shape = "box" if len(size) == 3 else "cylinder"
        _add(viewer[f"walls/{index}"], shape, size, X_WB, WALL)

    desired = data.p_WE_desired.values
    _add(viewer["desired/ball"], "sphere", [0.035], np.eye(4), DESIRED)
    poses["desired"] = _poses(np.nan_to_num(desired), np.isfinite(desired).all(axis=1))

    # An arrow of one metre that ends at the tool, scaled as a whole.
    _add(viewer["force/shaft"], "cylinder", [0.04, 0.75], translation_matrix([0, 0, -0.6]), FORCE)
    _add(viewer["force/head"], "cone", [0.1, 0.25], translation_matrix([0, 0, -0.125]), FORCE)
    tool, force = links["tool"][:, :3, 3], np.nan_to_num(data.f_env_on_tool_W.values)
    newtons = np.linalg.norm(force, axis=1)
    length = np.minimum(newtons * METRES_PER_NEWTON, LONGEST_ARROW) * (newtons >= SMALLEST_FORCE)
    R_WF = np.array([_facing(f) if f.any() else np.eye(3) for f in force])
    poses["force"] = _poses(tool, length, R_WF)

    stride = math.ceil(moments.size / TRAIL_PIECES)
    for start in range(0, moments.size - 1, stride):
        end = min(start + stride, moments.size - 1)
        points = shapes.PointsGeometry((tool[start : end + 1] - tool[start]).T)
        line = shapes.Line(points, shapes.LineBasicMaterial(color=_hex(TRAIL)))
        viewer[f"trail/{start}/line"].set_object(line)
        poses[f"trail/{start}"] = _poses(tool[start], np.arange(moments.size) >= end)

    for path, X in poses.items():
        viewer[path].set_transform(X[0])
    _look(viewer, np.vstack([tool, links["link_2"][:, :3, 3], *(X[None, :3, 3] for _, X in walls)]))
    return poses


def _poses(position: Array, scale: NDArray[Any], rotation: Array | None = None) -> Array:
    X = np.tile(np.eye(4), (scale.size, 1, 1))
    X[:, :3, :3] = np.eye(3) if rotation is None else rotation
    X[:, :3, :3] *= np.maximum(scale, HIDDEN)[:, None, None]
    X[:, :3, 3] = position
    return X


def _add(node: meshcat.Visualizer, shape: str, size: list[float], X: Array, color: Color) -> None:
    if shape == "box":
        solid = shapes.Box(size)
    elif shape == "sphere":
        solid = shapes.Sphere(*size)
    else:
        radius, length = size
        top = 0.0 if shape == "cone" else radius
        solid = shapes.Cylinder(length, radiusTop=top, radiusBottom=radius)
        X = X @ rotation_matrix(np.pi / 2, [1, 0, 0])  # meshcat's cylinders lie along y
    node.set_object(solid, shapes.MeshPhongMaterial(color=_hex(color), opacity=color[3]))
    node.set_transform(X)


def _hex(color: Color) -> int:
    return int.from_bytes(bytes(round(255 * part) for part in color[:3]))


def _look(viewer: meshcat.Visualizer, points: Array) -> None:
    """Put the middle of some points where the camera looks, the origin, and the camera near it."""
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    radius = np.linalg.norm(points - middle, axis=1).max()
    x, y, z = np.array([0.79, 0.47, 0.40]) * min(2.0 + 2.5 * radius, 5.0)  # before the gantry
    viewer.set_transform(translation_matrix(-middle))
    viewer["/Grid"].set_transform(translation_matrix(-middle))
    viewer["/Cameras/default/rotated/<object>"].set_property("position", [x, z, -y])  # y is up here
    viewer["/Cameras/default/rotated/<object>"].set_property("zoom", 2.2)
    viewer["/Background"].set_property("top_color", [0.78, 0.86, 0.94])
    viewer["/Background"].set_property("bottom_color", [0.99, 0.99, 0.99])
    viewer["/Axes"].set_property("visible", False)


def _animation(viewer: meshcat.Visualizer, poses: Poses, fps: float) -> Animation:
    """Tracks of position, rotation and scale, with keys only where something changes."""
    animation = Animation()
    for path, X in poses.items():
        clip, scale = AnimationClip(fps=fps), np.linalg.norm(X[:, :3, :3], axis=1)
        rotation = (X[:, :3, :3] / scale[:, None]).reshape(-1, 9)
        for name, values in (("position", X[:, :3, 3]), ("scale", scale), ("quaternion", rotation)):
            changes = (values[1:] != values[:-1]).any(axis=1)
            keys = np.flatnonzero(np.append(changes, False) | np.insert(changes, 0, False))
            kind, values = "vector3", values[keys]
            if name == "quaternion":  # x, y, z, w
                kind, matrices = name, values.reshape(-1, 3, 3)
                values = np.array([np.roll(quaternion_from_matrix(R), -1) for R in matrices])
            if keys.size:
                clip.tracks[name] = AnimationTrack(name, kind, keys.tolist(), values.tolist())
        if clip.tracks:
            animation.clips[viewer[path].path] = clip
    return animation


@contextmanager
def _scene(path: str | Path, speed: float, fps: float) -> Iterator[tuple[Any, Poses]]:
    """Draw a recording in a Meshcat whose server process ends with the context."""
    for name, value in (("speed", speed), ("fps", fps)):
        if not 0.0 < value < math.inf:
            raise ValueError(f"{name}: {value}, allowed more than 0")
    data, walls = load(path)
    # In a thread that is waited for: an interrupt cannot lose the process while it starts.
    with ThreadPoolExecutor(1) as pool, redirect_stdout(io.StringIO()):
        viewer = pool.submit(meshcat.Visualizer).result()
    try:
        yield viewer, draw(viewer, data, walls, speed / fps)
    finally:
        viewer.window.zmq_socket.close(linger=0)
        viewer.window.server_proc.kill()
        viewer.window.server_proc.communicate()


def replay(
    path: str | Path, speed: float = 1.0, fps: float = 30, open_browser: bool = False
) -> None:
    """Play a recording once, `speed` times as fast as it was; print the address of the scene.

    At most `fps` pictures each second. With `open_browser` it starts when the browser is there.

    Raises:
        ValueError: no such recording, or a number that is not above 0.
    """
    with _scene(path, speed, fps) as (viewer, poses):
        sys.stdout.write(f"Scene: {viewer.url()}\n")
        sys.stdout.flush()
        if open_browser and webbrowser.open(viewer.url()):
            viewer.wait()
        shown, last, start = 0, len(poses["force"]) - 1, time.monotonic()
        while shown < last:
            time.sleep(max(0.0, start + (shown + 1) / fps - time.monotonic()))
            frame = min(max(shown + 1, int((time.monotonic() - start) * fps)), last)
            for name, X in poses.items():
                if not np.array_equal(X[frame], X[shown]):
                    viewer[name].set_transform(X[frame])
            shown = frame


def animation_page(path: str | Path, html: str | Path, speed: float = 1.0, fps: float = 30) -> None:
    """Write a page that plays a recording in any browser, without network and without Python.

    Raises:
        ValueError: as `replay`, or `html` does not end in .html.
        OSError: the page cannot be written.
    """
    if Path(html).suffix != ".html":
        raise ValueError(f"html: '{html}', allowed a file that ends in .html")
    with _scene(path, speed, fps) as (viewer, poses):
        viewer.set_animation(_animation(viewer, poses, fps))
        Path(html).write_text(viewer.static_html(), encoding="utf-8")


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return the exit status: 0, or 2 for bad input."""
    parser = argparse.ArgumentParser(
        prog="python -m scara_drake.replay", description=(__doc__ or "").partition("\n")[0]
    )
    parser.add_argument("recording", type=Path, metavar="FILE.nc")
    parser.add_argument("--speed", type=float, default=1.0, help="2 plays twice as fast")
    parser.add_argument("--html", type=Path, metavar="FILE.html", help="write a page instead")
    parser.add_argument("--open", action="store_true", help="open a browser and wait for it")
    options = parser.parse_args(arguments)
    try:
        if options.html:
            animation_page(options.recording, options.html, options.speed)
        else:
            replay(options.recording, options.speed, open_browser=options.open)
    except (ValueError, OSError) as error:
        sys.stderr.write(f"replay: {error}\n")
        return 2
    except KeyboardInterrupt:
        return 130
    return 0
