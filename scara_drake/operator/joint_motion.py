"""Joint references that need no operator: sines on any joint and a polynomial move."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake import joints
from scara_drake.common.block import Block, Declaration, Output
from scara_drake.common.fields import number, vector
from scara_drake.common.layout import Layout
from scara_drake.common.motion import minimum_jerk, minimum_jerk_rate
from scara_drake.kinematics import forward_kinematics
from scara_drake.vectors import pose_vector

Array = NDArray[np.float64]

ROUNDING = 1e-5  # [m], [rad]
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


def desired_pose(t: float, motion: Array, X_WE_desired: Array) -> None:
    """Write the tool pose (7,) of the reference at time t."""
    state = np.empty(12)
    joint_reference(t, motion, state)
    X_WE_desired[:] = pose_vector(state[:6])


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
        """Check that the whole motion stays within the joint ranges.

        Raises:
            ValueError: a joint would leave its range.
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
