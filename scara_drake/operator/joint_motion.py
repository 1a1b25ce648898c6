"""Joint references that need no operator: sines on any joint and a polynomial move."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake import joints, robot
from scara_drake.common.block import Block, Declaration, Output
from scara_drake.common.fields import number, vector
from scara_drake.common.layout import Layout
from scara_drake.common.motion import minimum_jerk, minimum_jerk_rate
from scara_drake.kinematics import (
    forward_kinematics,
    quaternion_from_rotation_kernel,
    tool_pose_kernel,
)
from scara_drake.vectors import pose_of

Array = NDArray[np.float64]

ROUNDING = 1e-5  # [m], [rad]; of speeds a share
# Of a minimum-jerk move, over displacement / duration and displacement / duration².
PEAK_SPEED, PEAK_ACCELERATION = 15.0 / 8.0, 10.0 / math.sqrt(3.0)
_UNITS = joints.JOINT_UNITS
PLACES = 200  # of the tool along a motion
_NONE = [0.0] * 6


class Motion(NamedTuple):
    """`JointMotion` in a kernel."""

    base: Array
    amplitude: Array
    frequency: Array
    displacement: Array
    start: float
    move_duration: float


MOTION = Layout(Motion, base=6, amplitude=6, frequency=6, displacement=6)
motion_of = MOTION.reader()


@njit(cache=True)
def joint_reference(t: float, motion: Array, state_desired: Array) -> None:
    """Write (q, v) (12,) at time t: base + sine + minimum-jerk displacement.

    The move starts and ends with zero velocity and acceleration.

    Args:
        t: [s].
        motion: of `JointMotion.parameters`.
        state_desired: written.
    """
    m = motion_of(motion)
    q, v = state_desired[:6], state_desired[6:]
    x = min(max((t - m.start) / m.move_duration, 0.0), 1.0)
    move = minimum_jerk(x)
    move_rate = minimum_jerk_rate(x) / m.move_duration
    for i in range(6):
        angle = m.frequency[i] * t
        q[i] = m.base[i] + m.amplitude[i] * np.sin(angle) + m.displacement[i] * move
        v[i] = m.amplitude[i] * m.frequency[i] * np.cos(angle) + m.displacement[i] * move_rate


@njit(cache=True)
def desired_pose(t: float, motion: Array, X_WE_desired: Array) -> None:
    """Write the tool pose (7,) of the reference at time t."""
    state, p, R = np.empty(12), np.empty(3), np.empty((3, 3))
    joint_reference(t, motion, state)
    tool_pose_kernel(state[:6], p, R)
    pose = pose_of(X_WE_desired)
    pose.p[:] = p
    quaternion_from_rotation_kernel(R, pose.quaternion)


@dataclass
class JointMotion:
    """A motion of the joints around a base posture: a sine on each, and a minimum-jerk move.

    Attributes:
        base: posture without the sines, before the move.
        amplitude: of the sines.
        frequency: of the sines.
        displacement: by the move.
        start: of the move.
        move_duration: of the move.
    """

    base: list[float] = vector(joints.HOME.tolist(), "m | rad", size=None)
    amplitude: list[float] = vector(_NONE, "m | rad")
    frequency: list[float] = vector(_NONE, "rad/s")
    displacement: list[float] = vector(_NONE, "m | rad")
    start: float = number(1.0, "s", 0.0)
    move_duration: float = number(4.0, "s", 1e-3)

    def check_together(self, name: str) -> None:
        """Check that the whole motion stays within the joint ranges and what the drives can follow.

        Raises:
            ValueError: a joint would leave its range, pass its speed, or accelerate more than its
                drive can the nominal inertia; names the field and the largest that is allowed.
        """
        base = joints.check_configuration(f"{name}.base", self.base)
        sweep = np.abs(self.amplitude)
        moves = np.array([[0.0] * 6, self.displacement])
        for sign, extreme in ((-1.0, moves.min(axis=0)), (1.0, moves.max(axis=0))):
            q = base + extreme + sign * sweep
            # The paper's 0.7854 is pi/4 rounded up: a sweep may pass its limit by the rounding.
            inside = np.clip(q, joints.LOWER, joints.UPPER)
            q = np.where(np.abs(q - inside) < ROUNDING, inside, q)
            joints.check_configuration(f"{name} at its extreme", q)
        self._check_sines(name)
        self._check_move(name)

    def _check_sines(self, name: str) -> None:
        for i, frequency in enumerate(self.frequency):
            size = abs(self.amplitude[i])
            if size * max(1.0, abs(frequency)) ** 2 < ROUNDING:
                continue
            speed, acceleration = joints.MAX_SPEED[i], robot.drive_accelerations()[i]
            largest = min(speed / size, math.sqrt(acceleration / size))
            if abs(frequency) > largest * (1.0 + ROUNDING):
                raise ValueError(
                    f"{name}.frequency[{i}]: {frequency:g} rad/s, allowed up to {largest:.4g} with "
                    f"an amplitude of {size:g}: {joints.JOINT_NAMES[i]} moves at up to "
                    f"{speed:g} {_UNITS[i]}/s and {acceleration:.3g} {_UNITS[i]}/s²"
                )

    def _check_move(self, name: str) -> None:
        size, rate = np.abs(self.amplitude), np.abs(self.frequency)
        spare = np.maximum(joints.MAX_SPEED - size * rate, 0.0)
        left = np.maximum(robot.drive_accelerations() - size * rate**2, 0.0)
        way = np.abs(self.displacement)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            needed = np.maximum(PEAK_SPEED * way / spare, np.sqrt(PEAK_ACCELERATION * way / left))
        needed = np.where(way > ROUNDING, needed, 0.0)
        i = int(np.argmax(needed))
        if self.move_duration < needed[i] * (1.0 - ROUNDING):
            raise ValueError(
                f"{name}.move_duration: {self.move_duration:g} s, allowed {needed[i]:.4g} s or "
                f"more with displacement[{i}] = {self.displacement[i]:g}: {joints.JOINT_NAMES[i]} "
                f"moves, its sine included, at up to {joints.MAX_SPEED[i]:g} {_UNITS[i]}/s"
            )

    def start_state(self) -> Array:
        """Return (q, v) (12,) at t = 0."""
        state = np.empty(12)
        joint_reference(0.0, self.parameters(), state)
        return state

    def places(self, duration: float) -> Array:
        """Return tool points (n, 3) [m] along the motion, for the camera."""
        state, motion = np.empty(12), self.parameters()
        postures = []
        for t in np.linspace(0.0, duration, PLACES):
            joint_reference(t, motion, state)
            postures.append(state[:6].copy())
        return forward_kinematics(np.array(postures))[:, :3, 3]

    def parameters(self) -> Array:
        """Return the fields as `motion_of` reads them."""
        return MOTION.pack(**vars(self))


class JointMotionSource(Block):
    """Plays a `JointMotion`.

    Ports, functions of time:
        output state_desired (12): q, v [m, rad, m/s, rad/s].
        output X_WE_desired (7): tool pose of that q: p_WE [m], quaternion w, x, y, z.

    No update, and no memory.

    Args:
        motion: checked.
    """

    def __init__(self, motion: JointMotion) -> None:
        super().__init__(
            Declaration(
                outputs={
                    "state_desired": Output(12, joint_reference),
                    "X_WE_desired": Output(7, desired_pose),
                },
                parameters={"motion": motion.parameters()},
            )
        )
