"""Plots of recordings: each function draws one thing into the axes it is given, and no more.

`study_map` draws a study into a figure.

Colours are those of `display.look`, as in the scene: what is desired is magenta, what is measured
green, force red.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from numpy.typing import NDArray

from scara_drake import kinematics, metrics
from scara_drake.common import checks
from scara_drake.display import look
from scara_drake.joints import JOINT_NAMES, JOINT_UNITS
from scara_drake.recordings.surfaces import KIND, facing, surfaces_of
from scara_drake.studies.picture import study_map as study_map  # it is a plot like these

Array = NDArray[np.float64]

COMMANDED, LIMIT, LAW = look.COMMANDED, look.LIMIT, look.LAW
FIRST, SECOND = look.FIRST, look.SECOND
# On paper nothing is translucent.
DESIRED, MEASURED = look.DESIRED[:3], look.MEASURED[:3]
FORCE, WALL = look.FORCE[:3], look.SURFACE[:3]
REVOLUTE = JOINT_NAMES[1:]


def tracking(recording: xr.Dataset, ax: Axes, joints: Sequence[str] = REVOLUTE) -> None:
    """Draw the desired (dashed) and the measured positions of joints.

    Raises:
        ValueError: no such joint, or d1 [m] together with a revolute joint [rad].
    """
    unit = _unit(joints)
    for joint in joints:
        name = _symbol(joint)
        (line,) = ax.plot(recording.time, recording.q_measured.sel(joint=joint), label=name)
        ax.plot(
            recording.time,
            recording.q_desired.sel(joint=joint),
            color=line.get_color(),
            linestyle="--",
            label=f"{name} desired",
        )
    finish(ax, "time [s]", f"position [{unit}]")


def tracking_error(recording: xr.Dataset, ax: Axes, joints: Sequence[str] = REVOLUTE) -> None:
    """Draw the errors q_desired - q_measured of joints, in mm or mrad.

    Raises:
        ValueError: no such joint, or d1 [m] together with a revolute joint [rad].
    """
    unit = _unit(joints)
    error = metrics.tracking_error(recording)
    for joint in joints:
        ax.plot(recording.time, 1e3 * error.sel(joint=joint), label=_symbol(joint))
    finish(ax, "time [s]", f"error [m{unit}]")


def tool_path(recording: xr.Dataset, ax: Axes) -> None:
    """Draw the way of the tool seen from above, with the walls that stand upright."""
    for kind, color, style in (
        ("commanded", COMMANDED, ":"),
        ("desired", DESIRED, "--"),
        ("measured", MEASURED, "-"),
    ):
        path = recording[f"p_WE_{kind}"]
        if path.notnull().any():
            x, y = path.sel(axis="x"), path.sel(axis="y")
            ax.plot(x, y, color=color, linestyle=style, label=kind)
    upright_walls(recording, ax)
    ax.set_aspect("equal", adjustable="box")
    finish(ax, "x [m]", "y [m]")


def upright_walls(recording: xr.Dataset, ax: Axes) -> None:
    """Draw the walls that stand upright, seen from above, into axes with the way of a tool."""
    limits = ax.axis()
    for wall in walls(recording):
        if abs(wall.normal[2]) < 0.99:
            half = wall.size[0] / 2
            along = facing(wall.normal)[:, 0]
            ends = np.stack([wall.point - half * along, wall.point + half * along])
            ax.plot(ends[:, 0], ends[:, 1], color=WALL, linewidth=3, label=wall.name)
            limits = _around(limits, wall.point[:2].tolist())
    ax.axis(limits)


def contact_force(recording: xr.Dataset, ax: Axes, surface: str | None = None) -> None:
    """Draw the force on the tool along a wall's normal, and K d + B d' where it touches.

    The law (52) is drawn as the paper has it. The simulated force lets B grow over the first
    millimetre and never pulls, so the two part at touch and on a fast retreat.

    Args:
        recording: of a run with a wall.
        ax: where to draw.
        surface: name of the wall; the first one if None.

    Raises:
        ValueError: the recording has no such wall.
    """
    by_name = {wall.name: wall for wall in walls(recording)}
    name = next(iter(by_name), "") if surface is None else surface
    checks.choice("surface", name, by_name)
    wall = by_name[name]
    normal = wall.normal / np.linalg.norm(wall.normal)
    depth = recording.penetration.sel(surface=name).values
    rate = -_tool_velocity(recording) @ normal
    law = np.where(depth > 0.0, wall.stiffness * depth + wall.damping * rate, 0.0)
    ax.plot(recording.time, recording.f_env_on_tool_W.values @ normal, color=FORCE, label="force")
    ax.plot(recording.time, law, color=LAW, linestyle="--", label="K d + B d'")
    finish(ax, "time [s]", "force [N]")


def haptic(recording: xr.Dataset, ax: Axes) -> Axes:
    """Draw the force at the robot, the force after the channel, and the two rumble motors.

    Returns:
        The axes on the right, on which the rumble is.
    """
    at_robot = metrics.contact_force(recording)
    received = np.sqrt((recording.f_haptic**2).sum("axis", skipna=False))
    ax.plot(recording.time, at_robot, color=FORCE, label="at the robot")
    ax.plot(recording.time, received, color=LAW, linestyle="--", label="after the channel")
    right = ax.twinx()
    for motor, color in zip(recording.motor.values, (FIRST, SECOND), strict=True):
        level = recording.rumble.sel(motor=motor)
        right.plot(recording.time, level, color=color, linewidth=1, label=f"{motor} motor")
    right.set_ylim(0.0, 1.05)
    right.set_ylabel("rumble [1]")
    finish(ax, "time [s]", "force [N]")
    # One legend for both axes, in the middle of the hill that a press is.
    ax.legend(handles=[*ax.lines, *right.lines], loc="center", fontsize="small")
    return right


def coupled_motion(recording: xr.Dataset, ax: Axes, axis: str = "y") -> None:
    """Draw where the hand wants to be, the device, and the tool on its way from the start.

    Args:
        recording: of a bilateral run.
        ax: where to draw.
        axis: "x", "y" or "z".

    Raises:
        ValueError: the recording has no master, or there is no such axis.
    """
    along = _along(recording, axis)
    tool = along.p_WE_measured - along.p_WE_measured.isel(time=0)
    ax.plot(recording.time, 1e3 * along.hand_target, color=COMMANDED, linestyle=":", label="hand")
    ax.plot(recording.time, 1e3 * along.x_master, color=DESIRED, linestyle="--", label="device")
    ax.plot(recording.time, 1e3 * tool, color=MEASURED, label="tool")
    finish(ax, "time [s]", f"{axis} [mm]")


def coupling_energy(recording: xr.Dataset, ax: Axes, axis: str = "y", **line: Any) -> None:
    """Draw the energy that came in at both ports of a coupling less what went out.

    Below zero the coupling and the channel have given out more than they had taken.

    Args:
        recording: of a bilateral run.
        ax: where to draw.
        axis: "x", "y" or "z".
        **line: of `Axes.plot`, such as a label.

    Raises:
        ValueError: the recording has no master, or there is no such axis.
    """
    along = _along(recording, axis)
    came_in = along.energy_master_in + along.energy_slave_in
    went_out = along.energy_master_out + along.energy_slave_out
    ax.plot(recording.time, came_in - went_out, **{"label": "stored", **line})
    finish(ax, "time [s]", "energy [J]")


def finish(ax: Axes, x: str, y: str) -> None:
    """Name the axes, draw a light grid, and put a small legend where it covers least."""
    ax.set_xlabel(x)
    ax.set_ylabel(y)
    ax.grid(alpha=0.3)
    ax.legend(loc="best", fontsize="small")


class Wall(NamedTuple):
    """What a plot shows of a wall, as its scenario has it.

    Attributes:
        name: of the wall.
        point: on its surface (3,) [m].
        normal: out of it (3,).
        size: width and height [m].
        stiffness: K [N/m].
        damping: B [N s/m].
    """

    name: str
    point: Array
    normal: Array
    size: Array
    stiffness: float
    damping: float


def walls(recording: xr.Dataset) -> list[Wall]:
    """Return the walls of the scenario that a recording was made of, and no other surfaces."""
    return [
        Wall(
            name=str(wall["name"]),
            point=np.array(wall["point"], dtype=np.float64),
            normal=np.array(wall["normal"], dtype=np.float64),
            size=np.array(wall["size"], dtype=np.float64),
            stiffness=float(wall["stiffness"]),
            damping=float(wall["damping"]),
        )
        for wall in surfaces_of(recording.attrs["scenario"])
        if wall[KIND] == "Wall"
    ]


def _along(recording: xr.Dataset, axis: str) -> xr.Dataset:
    if "x_master" not in recording:
        raise ValueError("recording: no master, allowed one of a bilateral run")
    checks.choice("axis", axis, ("x", "y", "z"))
    return recording.sel(axis=axis)


def _tool_velocity(recording: xr.Dataset) -> np.ndarray:
    J_WE = kinematics.jacobian(recording.q_measured.values)
    return np.einsum("tij,tj->ti", J_WE[:, 3:], recording.v_measured.values)


def _unit(joints: Sequence[str]) -> str:
    for joint in joints:
        checks.choice("joints", joint, JOINT_NAMES)
    units = {JOINT_UNITS[JOINT_NAMES.index(joint)] for joint in joints}
    if len(units) != 1:
        raise ValueError(f"joints: {', '.join(joints)}, allowed d1 alone, or revolute joints")
    return units.pop()


def _symbol(joint: str) -> str:
    return joint.replace("theta", "θ")


def _around(
    limits: tuple[float, float, float, float], point: Sequence[float], margin: float = 0.05
) -> tuple[float, float, float, float]:
    left, right, bottom, top = limits
    x, y = point
    return (
        min(left, x - margin),
        max(right, x + margin),
        min(bottom, y - margin),
        max(top, y + margin),
    )
