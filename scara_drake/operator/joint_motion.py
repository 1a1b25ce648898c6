"""Joint references that need no operator: sines on any joint and a polynomial move."""

from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from scara_drake import joints
from scara_drake.common import checks
from scara_drake.vectors import pose_vector

Array = NDArray[np.float64]

ROUNDING = 1e-5  # [m], [rad]


@njit(cache=True)
def joint_reference(
    t: float,
    base: Array,
    amplitude: Array,
    frequency: Array,
    displacement: Array,
    start: float,
    duration: float,
    state: Array,
) -> None:
    """Write (q, v) (12,) at time t: base + sine + minimum-jerk displacement.

    The move follows 10 x³ - 15 x⁴ + 6 x⁵ with x = (t - start) / duration in [0, 1]: it starts and
    ends with zero velocity and acceleration.
    """
    x = min(max((t - start) / duration, 0.0), 1.0)
    move = x * x * x * (10.0 + x * (6.0 * x - 15.0))
    move_rate = 30.0 * x * x * (1.0 - x) * (1.0 - x) / duration
    for i in range(6):
        angle = frequency[i] * t
        state[i] = base[i] + amplitude[i] * np.sin(angle) + displacement[i] * move
        state[6 + i] = amplitude[i] * frequency[i] * np.cos(angle) + displacement[i] * move_rate


@dataclass
class JointMotion:
    """A motion of the joints around a base posture, in [m] and [rad]."""

    base: list[float] = field(default_factory=lambda: joints.HOME.tolist())
    amplitude: list[float] = field(default_factory=lambda: [0.0] * 6)
    frequency: list[float] = field(default_factory=lambda: [0.0] * 6)  # [rad/s]
    displacement: list[float] = field(default_factory=lambda: [0.0] * 6)
    start: float = 1.0  # [s]
    move_duration: float = 4.0  # [s]

    def validate(self, name: str) -> None:
        """Check that the whole motion stays within the joint ranges.

        Raises:
            ValueError: an entry is not finite, or a joint would leave its range.
        """
        for vector in ("amplitude", "frequency", "displacement"):
            checks.vector(f"{name}.{vector}", getattr(self, vector), 6)
        checks.number(f"{name}.start", self.start, 0.0)
        checks.number(f"{name}.move_duration", self.move_duration, 1e-3)
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
        joint_reference(0.0, *self.parameters(), state)
        return state

    def parameters(self) -> tuple[Array, Array, Array, Array, float, float]:
        """Return the arguments of `joint_reference` between the time and the result."""
        arrays = (self.base, self.amplitude, self.frequency, self.displacement)
        base, amplitude, frequency, displacement = (np.array(a, dtype=np.float64) for a in arrays)
        return base, amplitude, frequency, displacement, self.start, self.move_duration


class JointMotionSource(LeafSystem):
    """Plays a `JointMotion`.

    Output ports, functions of time:
        state_desired (12): q, v [m, rad, m/s, rad/s]
        X_WE_desired (7): tool pose of that q: p_WE [m], quaternion w x y z
    """

    def __init__(self, motion: JointMotion):
        super().__init__()
        self._parameters = motion.parameters()
        self.DeclareVectorOutputPort(
            "state_desired", 12, self._state, prerequisites_of_calc={self.time_ticket()}
        )
        self.DeclareVectorOutputPort(
            "X_WE_desired", 7, self._pose, prerequisites_of_calc={self.time_ticket()}
        )

    def _pose(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(pose_vector(self.get_output_port(0).Eval(context)[:6]))

    def _state(self, context: Context, output: BasicVector) -> None:
        joint_reference(context.get_time(), *self._parameters, output.get_mutable_value())
