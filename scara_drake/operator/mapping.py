"""From joystick axes to the commanded pose of the tool and the height of the mast."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake import joints
from scara_drake.common import checks
from scara_drake.common.block import Block, Declaration, Input, Memory
from scara_drake.common.fields import ABOVE_ZERO, check, choice, number, vector
from scara_drake.common.layout import Layout
from scara_drake.kinematics import REACH
from scara_drake.vectors import held_command, tool_command_of

Array = NDArray[np.float64]

MODES = ("position", "rate")
MAST_LOW, MAST_HIGH = float(joints.LOWER[0]), float(joints.UPPER[0])  # [m]


@dataclass
class JoystickMapping:
    """How the stick drives the tool: its axes x, y, z are a position, the mast's a speed.

    The position is relative to the arm's base, frame 1, which rides on the mast: moving the mast
    carries the tool along. The stick's directions are the world's, so forward (SDL's -y) moves the
    tool towards -y, where the wall stands. The orientation is held (section VII of the paper).

    Attributes:
        centre: tool point at the centred stick, relative to the arm's base, in W's axes.
        rpy: held orientation of the tool, Rx(roll) Ry(pitch) Rz(yaw); the default points to -y.
        scale: tool travel at full stick; the paper's is 500 mm.
        dead_zone: of the stick's travel.
        mast_height: at the start.
        mast_rate: speed of the mast at full stick or hat.
        max_speed: of the commanded tool point relative to the arm's base.
        smoothing: time constant; takes off the steps of a stick with few bits.
        mode: "position", or "rate": the stick is a speed. It and what follows are for an operator
            with a supervisor, and what moves is then smooth.
        rate: of the tool at full stick in the mode "rate".
        turn_rate: of the tool at full turn.
        max_acceleration: of the commanded tool point relative to the arm's base.
        max_jerk: of it. Turns and mast build up their acceleration in the same time.
        turn_acceleration: of the tool's turn.
        mast_acceleration: of the mast.
    """

    centre: list[float] = vector([0.80, -0.76, 0.0], "m", -REACH, REACH)
    rpy: list[float] = vector([math.pi / 2, 0.0, 0.0], "rad", -2 * math.pi, 2 * math.pi)
    scale: float = number(0.5, "m", 0.0, REACH)
    dead_zone: float = number(0.05, "1", 0.0, 0.9)
    mast_height: float = number(3.0, "m", MAST_LOW, MAST_HIGH)
    mast_rate: float = number(0.2, "m/s", 0.0, float(joints.MAX_SPEED[0]))
    max_speed: float = number(0.5, "m/s", 1e-3, 5.0)
    smoothing: float = number(0.05, "s", 0.0, 2.0)
    mode: str = choice("position", MODES)
    rate: float = number(0.25, "m/s", 0.0, 5.0)
    turn_rate: float = number(0.5, "rad/s", 0.0, 10.0)
    max_acceleration: float = number(2.0, "m/s^2", ABOVE_ZERO, 100.0)
    max_jerk: float = number(40.0, "m/s^3", ABOVE_ZERO, 1e5)
    turn_acceleration: float = number(4.0, "rad/s^2", ABOVE_ZERO, 100.0)
    mast_acceleration: float = number(1.0, "m/s^2", ABOVE_ZERO, 100.0)

    def parameters(self, period: float) -> Array:
        """Return the mapping over a period [s] as `stick_motion_of` reads it."""
        share = -math.expm1(-period / self.smoothing) if self.smoothing > 0.0 else 1.0
        return STICK_MOTION.pack(
            centre=self.centre,
            scale=self.scale,
            dead_zone=self.dead_zone,
            share=share,
            max_step=self.max_speed * period,
            mast_step=self.mast_rate * period,
        )


class StickMotion(NamedTuple):
    """What a tick of the mapping does.

    Attributes:
        centre: (3,) [m], relative to the arm's base.
        scale: [m] at full stick.
        dead_zone: of the stick's travel.
        share: of the way to the target that is gone in a tick, 0 to 1.
        max_step: [m] that the point relative to the arm's base may move in a tick.
        mast_step: [m] that the mast moves in a tick at full stick.
    """

    centre: Array
    scale: float
    dead_zone: float
    share: float
    max_step: float
    mast_step: float


class Stick(NamedTuple):
    """The axes of a joystick, each in [-1, 1]; `position` is x, y, z."""

    position: Array
    mast_axis: float
    mast_hat: float


STICK_MOTION = Layout(StickMotion, centre=3)
STICK = Layout(Stick, position=3)
stick_motion_of = STICK_MOTION.reader()
stick_of = STICK.reader()


def initial_command(mapping: JoystickMapping) -> Array:
    """Tool command (8,) of the centred stick: p_WE [m], quaternion w, x, y, z, mast height [m]."""
    return held_command(mapping.centre, mapping.rpy, mapping.mast_height)


@njit(cache=True)
def remove_dead_zone(axis: float, zone: float) -> float:
    """Zero within ±zone, and from there a straight line that reaches ±1 at ±1."""
    excess = abs(axis) - zone
    if excess <= 0.0:
        return 0.0
    return math.copysign(min(excess / (1.0 - zone), 1.0), axis)


@njit(cache=True)
def move_command(joystick_axes: Array, mapping: Array, tool_command: Array) -> None:
    """Move a tool command (8,) by one tick, in place; axes that are not finite move nothing.

    Args:
        joystick_axes: (5,), see `Stick`.
        mapping: of `JoystickMapping.parameters`.
        tool_command: see `vectors.ToolCommand`.
    """
    if not np.isfinite(joystick_axes).all():
        return
    stick, g = stick_of(joystick_axes), stick_motion_of(mapping)
    command = tool_command_of(tool_command)
    x, y, z = stick.position
    p_WE, height = command.p, command.mast[()]
    dx = g.centre[0] + g.scale * remove_dead_zone(x, g.dead_zone) - p_WE[0]
    dy = g.centre[1] + g.scale * remove_dead_zone(y, g.dead_zone) - p_WE[1]
    dz = g.centre[2] + g.scale * remove_dead_zone(z, g.dead_zone) - (p_WE[2] - height)
    distance = math.sqrt(dx * dx + dy * dy + dz * dz)
    share = g.share
    if share * distance > g.max_step:
        share = g.max_step / distance
    mast = remove_dead_zone(stick.mast_axis, g.dead_zone) + stick.mast_hat
    new_height = height + g.mast_step * min(max(mast, -1.0), 1.0)
    new_height = min(max(new_height, MAST_LOW), MAST_HIGH)
    p_WE[0] += share * dx
    p_WE[1] += share * dy
    p_WE[2] += share * dz + (new_height - height)
    command.mast[()] = new_height


class JoystickToPose(Block):
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
        check(mapping, "mapping")
        checks.number("period", period, 1e-4, 0.1)
        super().__init__(
            Declaration(
                inputs={"joystick_axes": Input(5)},
                memory={"tool_command": Memory(initial_command(mapping), port=True)},
                parameters={"mapping": mapping.parameters(period)},
                period=period,
                update=move_command,
            )
        )
