"""From joystick axes to the commanded pose of the tool and the height of the mast."""

import math
from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydrake.math import RotationMatrix
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from scara_drake import joints
from scara_drake.common import checks
from scara_drake.common.state import declare_state
from scara_drake.kinematics import REACH, rotation_from_intrinsic_xyz

Array = NDArray[np.float64]

MAST_LOW, MAST_HIGH = float(joints.LOWER[0]), float(joints.UPPER[0])  # [m]


@dataclass
class JoystickMapping:
    """How the stick drives the tool: its axes x, y, z are a position, the mast's a speed.

    The position is relative to the arm's base, frame 1, which rides on the mast: moving the mast
    carries the tool along. The stick's directions are the world's, so forward (SDL's -y) moves the
    tool towards -y, where the wall stands. The orientation is held (section VII of the paper).
    """

    centre: list[float] = field(default_factory=lambda: [0.80, -0.76, 0.0])
    """Tool point at the centred stick, relative to the arm's base, in W's axes [m]."""
    rpy: list[float] = field(default_factory=lambda: [math.pi / 2, 0.0, 0.0])
    """Held orientation of the tool, Rx(roll) Ry(pitch) Rz(yaw) [rad]; the default points to -y."""
    scale: float = 0.5  # [m] of tool travel at full stick, the paper's 500 mm
    dead_zone: float = 0.05  # of the stick's travel
    mast_height: float = 3.0  # [m], at the start
    mast_rate: float = 0.2  # [m/s] at full stick or hat
    max_speed: float = 0.5  # [m/s] of the commanded tool point relative to the arm's base
    smoothing: float = 0.05  # [s], time constant: takes off the steps of a stick with few bits

    def validate(self, name: str) -> None:
        """Check the fields.

        Raises:
            ValueError: one line that names the field, its value and what is allowed.
        """
        checks.vector(f"{name}.centre", self.centre, 3, -REACH, REACH)
        checks.vector(f"{name}.rpy", self.rpy, 3, -2 * math.pi, 2 * math.pi)
        checks.number(f"{name}.scale", self.scale, 0.0, REACH)
        checks.number(f"{name}.dead_zone", self.dead_zone, 0.0, 0.9)
        checks.number(f"{name}.mast_height", self.mast_height, MAST_LOW, MAST_HIGH)
        checks.number(f"{name}.mast_rate", self.mast_rate, 0.0, float(joints.MAX_SPEED[0]))
        checks.number(f"{name}.max_speed", self.max_speed, 1e-3, 5.0)
        checks.number(f"{name}.smoothing", self.smoothing, 0.0, 2.0)


def initial_command(mapping: JoystickMapping) -> Array:
    """Tool command (8,) of the centred stick: p_WE [m], quaternion w, x, y, z, mast height [m]."""
    rotation = RotationMatrix(rotation_from_intrinsic_xyz(mapping.rpy))
    x, y, z = mapping.centre
    height = mapping.mast_height
    return np.array([x, y, z + height, *rotation.ToQuaternion().wxyz(), height])


@njit(cache=True)
def remove_dead_zone(axis: float, zone: float) -> float:
    """Zero within ±zone, and from there a straight line that reaches ±1 at ±1."""
    excess = abs(axis) - zone
    if excess <= 0.0:
        return 0.0
    return math.copysign(min(excess / (1.0 - zone), 1.0), axis)


@njit(cache=True)
def move_command(
    axes: Array,
    centre: Array,
    scale: float,
    dead_zone: float,
    share: float,
    max_step: float,
    mast_step: float,
    command: Array,
) -> None:
    """Move a tool command (8,) by one tick, in place; axes (5,) that are not finite move nothing.

    Args:
        axes: x, y, z, mast_axis, mast_hat in [-1, 1].
        centre: (3,) [m], relative to the arm's base.
        scale: [m] at full stick.
        dead_zone: of the stick's travel.
        share: of the way to the target that is gone in this tick, 0 to 1.
        max_step: [m] that the point relative to the arm's base may move in this tick.
        mast_step: [m] that the mast moves in this tick at full stick.
        command: p_WE, quaternion, mast height.
    """
    if not np.isfinite(axes).all():
        return
    height = command[7]
    dx = centre[0] + scale * remove_dead_zone(axes[0], dead_zone) - command[0]
    dy = centre[1] + scale * remove_dead_zone(axes[1], dead_zone) - command[1]
    dz = centre[2] + scale * remove_dead_zone(axes[2], dead_zone) - (command[2] - height)
    distance = math.sqrt(dx * dx + dy * dy + dz * dz)
    if share * distance > max_step:
        share = max_step / distance
    mast = remove_dead_zone(axes[3], dead_zone) + axes[4]
    new_height = height + mast_step * min(max(mast, -1.0), 1.0)
    new_height = min(max(new_height, MAST_LOW), MAST_HIGH)
    command[0] += share * dx
    command[1] += share * dy
    command[2] += share * dz + (new_height - height)
    command[7] = new_height


class JoystickToPose(LeafSystem):
    """Turns joystick axes into the commanded pose of the tool (section VII of the paper).

    Ports:
        input joystick_axes (5): x, y, z, mast_axis, mast_hat, each in [-1, 1].
        output tool_command (8): p_WE [m], quaternion of R_WE w, x, y, z, mast height d1 [m].

    Update, at t = k period, with a the axes, d(.) the dead zone, and p = p_WE - [0, 0, d1] the tool
    point relative to the arm's base::

        p  <- p + e min(1 - exp(-period / smoothing), max_speed period / |e|)
              with e = centre + scale d(a_xyz) - p
        d1 <- clip(d1 + mast_rate period clip(d(a_mast) + a_hat, -1, 1), 2.5 m, 10 m)

    The quaternion is constant. Initial: `initial_command`, the centred stick.

    Args:
        mapping: how the stick drives the tool.
        period: [s].

    Raises:
        ValueError: a field of the mapping, or the period, is out of its bounds.
    """

    def __init__(self, mapping: JoystickMapping, period: float = 1e-3) -> None:
        super().__init__()
        mapping.validate("mapping")
        checks.number("period", period, 1e-4, 0.1)
        self._arguments = (
            np.array(mapping.centre, dtype=np.float64),
            float(mapping.scale),
            float(mapping.dead_zone),
            -math.expm1(-period / mapping.smoothing) if mapping.smoothing > 0.0 else 1.0,
            mapping.max_speed * period,
            mapping.mast_rate * period,
        )
        self._axes = self.DeclareVectorInputPort("joystick_axes", 5)
        self._command = declare_state(self, initial_command(mapping), "tool_command")
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._move)

    def _move(self, context: Context, discrete: DiscreteValues) -> None:
        move_command(
            self._axes.Eval(context), *self._arguments, discrete.get_mutable_value(self._command)
        )
