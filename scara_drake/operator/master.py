"""A simulated kinesthetic master: a device that can be pushed, and the hand that holds it.

Each axis of the device is a mass with viscous friction; the hand is a spring and a damper towards
its target, a voluntary motion::

    m x'' + b x' = f_hand - f_device,   f_hand = K (x_t - x) + B (x_t' - x')

with f_device the commanded force within the limit of the actuators. A period is integrated exactly
for a force that is held and a target that moves at constant speed, so the device exchanges just
the energy f_device (x(t + T) - x(t)) with its port, and none appears by integration: stiff hands
need no smaller step, and a meter that sums this product is exact.
"""

import math
from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydrake.math import RotationMatrix
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from scara_drake.common import checks
from scara_drake.common.finite import all_finite, check_finite
from scara_drake.common.state import declare_state
from scara_drake.kinematics import REACH, rotation_from_intrinsic_xyz
from scara_drake.operator.mapping import MAST_HIGH, MAST_LOW

Array = NDArray[np.float64]


@dataclass
class Sweep:
    """A sine on one axis of the hand's target whose frequency rises exponentially.

    It fades in and out over a tenth of its duration. Equal frequencies make a plain sine.
    """

    axis: int = 1  # 0, 1, 2: x, y, z
    amplitude: float = 0.0  # [m]
    low: float = 0.1  # [Hz], at the start
    high: float = 10.0  # [Hz], at the end
    start: float = 0.0  # [s]
    duration: float = 30.0  # [s]

    def validate(self, name: str) -> None:
        """Check the fields.

        Raises:
            ValueError: one line that names the field, its value and what is allowed.
        """
        checks.choice(f"{name}.axis", str(self.axis), ("0", "1", "2"))
        checks.number(f"{name}.amplitude", self.amplitude, 0.0, 1.0)
        checks.number(f"{name}.low", self.low, 1e-3, 100.0)
        checks.number(f"{name}.high", self.high, self.low, 100.0)
        checks.number(f"{name}.start", self.start, 0.0)
        checks.number(f"{name}.duration", self.duration, 1e-2)


def _press() -> list[list[float]]:
    return [[0.0, 0.0, 0.0], [0.0, -0.04, 0.0], [0.0, -0.04, 0.0], [0.0, 0.0, 0.0]]


@dataclass
class Master:
    """An operator who moves a kinesthetic device.

    The hand's target starts at zero, the centre of the workspace, and goes from each of `targets`
    to the next with minimum jerk, at rest at its time; the last one is kept. The default presses
    3 cm into a wall that is 1 cm away along -y.

    Attributes:
        mass: of the device, each axis [kg].
        damping: of the device [N s/m].
        actuator_limit: largest force of the device, each axis [N].
        hand_stiffness: K of the hand [N/m].
        hand_damping: B of the hand [N s/m].
        times: of the targets, rising [s].
        targets: rows x, y, z of the hand's target in W's axes, from the centre [m].
        sweep: added to the target.
        centre: tool point at the device's centre, relative to the arm's base, in W's axes [m].
        rpy: held orientation of the tool, Rx(roll) Ry(pitch) Rz(yaw) [rad].
        mast_height: [m].
    """

    mass: float = 0.3  # [kg]
    damping: float = 2.0  # [N s/m]
    actuator_limit: float = 40.0  # [N]
    hand_stiffness: float = 150.0  # [N/m]
    hand_damping: float = 4.0  # [N s/m]
    times: list[float] = field(default_factory=lambda: [1.0, 2.0, 6.0, 7.0])  # [s]
    targets: list[list[float]] = field(default_factory=_press)  # [m]
    sweep: Sweep = field(default_factory=Sweep)
    centre: list[float] = field(default_factory=lambda: [0.80, -1.04, 0.0])  # [m]
    rpy: list[float] = field(default_factory=lambda: [math.pi / 2, 0.0, 0.0])  # [rad]
    mast_height: float = 3.0  # [m]

    def validate(self, name: str) -> None:
        """Check the fields.

        Raises:
            ValueError: one line that names the field, its value and what is allowed.
        """
        checks.number(f"{name}.mass", self.mass, 1e-2, 100.0)
        checks.number(f"{name}.damping", self.damping, 0.0, 1e3)
        checks.number(f"{name}.actuator_limit", self.actuator_limit, 0.0, 1e6)
        checks.number(f"{name}.hand_stiffness", self.hand_stiffness, 0.0, 1e4)
        checks.number(f"{name}.hand_damping", self.hand_damping, 0.0, 1e3)
        checks.vector(f"{name}.times", self.times, len(self.targets), 0.0)
        for index, (before, after) in enumerate(zip(self.times, self.times[1:], strict=False)):
            if after <= before:
                raise ValueError(f"{name}.times[{index + 1}]: {after}, allowed above {before:g}")
        for index, target in enumerate(self.targets):
            checks.vector(f"{name}.targets[{index}]", target, 3, -REACH, REACH)
        self.sweep.validate(f"{name}.sweep")
        checks.vector(f"{name}.centre", self.centre, 3, -REACH, REACH)
        checks.vector(f"{name}.rpy", self.rpy, 3, -2 * math.pi, 2 * math.pi)
        checks.number(f"{name}.mast_height", self.mast_height, MAST_LOW, MAST_HIGH)

    def first_command(self) -> Array:
        """Tool command (8,) at the centre: p_WE [m], quaternion w, x, y, z, mast height [m]."""
        rotation = RotationMatrix(rotation_from_intrinsic_xyz(self.rpy))
        x, y, z = self.centre
        height = self.mast_height
        return np.array([x, y, z + height, *rotation.ToQuaternion().wxyz(), height])

    def waypoints(self) -> Array:
        """Rows (n, 4): time [s], target [m]; the first is the rest at the centre before t = 0."""
        rows = [[-1.0, 0.0, 0.0, 0.0]]
        rows += [[t, *target] for t, target in zip(self.times, self.targets, strict=True)]
        return np.array(rows, dtype=np.float64)

    def sweep_parameters(self) -> Array:
        """The fields of the sweep in their order (6,), for `hand_target`."""
        s = self.sweep
        fields = [s.axis, s.amplitude, s.low, s.high, s.start, s.duration]
        return np.array(fields, dtype=np.float64)

    def transition(self, period: float) -> Array:
        """Return `Phi` (2, 4) of the device and the hand over one period, see `move_device`."""
        m, b = self.mass, self.damping + self.hand_damping
        rates = np.zeros((4, 4))
        rates[0, 1] = rates[2, 3] = 1.0
        rates[1] = [-self.hand_stiffness / m, -b / m, 1.0 / m, 0.0]
        return _exponential(rates * period)[:2]


def _exponential(matrix: Array) -> Array:
    """Matrix exponential by its series, scaled by 2¹⁰ and squared."""
    total = term = np.eye(len(matrix))
    small = matrix / 1024.0
    for order in range(1, 12):
        term = term @ small / order
        total = total + term
    for _ in range(10):
        total = total @ total
    return total


@njit(cache=True)
def hand_target(t: float, waypoints: Array, sweep: Array, target: Array) -> None:
    """Write where the hand wants to be (3,) [m] at time t [s].

    Args:
        t: [s].
        waypoints: rows (n, 4), see `Master.waypoints`.
        sweep: (6,), see `Master.sweep_parameters`.
        target: written.
    """
    rows = waypoints.shape[0]
    after = 0
    while after < rows and waypoints[after, 0] <= t:
        after += 1
    target[:] = waypoints[max(after - 1, 0), 1:]
    if 0 < after < rows:
        before = waypoints[after - 1, 0]
        start = max(before, 0.0)
        x = max(t - start, 0.0) / (waypoints[after, 0] - start)
        move = x * x * x * (10.0 + x * (6.0 * x - 15.0))
        for i in range(3):
            target[i] += move * (waypoints[after, 1 + i] - waypoints[after - 1, 1 + i])
    age, duration = t - sweep[4], sweep[5]
    if sweep[1] > 0.0 and 0.0 < age < duration:
        rate = math.log(sweep[3] / sweep[2]) / duration
        cycles = sweep[2] * (math.expm1(rate * age) / rate if rate > 0.0 else age)
        fade = min(10.0 * min(age, duration - age) / duration, 1.0)
        fade = fade * fade * (3.0 - 2.0 * fade)
        target[int(sweep[0])] += sweep[1] * fade * math.sin(2.0 * math.pi * cycles)


@njit(cache=True)
def move_device(
    transition: Array,
    hand: Array,
    limit: float,
    period: float,
    f_master: Array,
    target_next: Array,
    motion: Array,
    target: Array,
    f_hand: Array,
) -> None:
    """Move the device (6,) and its hand by one period, in place.

    Each axis is (x, v) <- Phi (x, v, c, r): c and r are the constant and the slope of the force
    that the hand's target and the actuator exert over the period.

    Args:
        transition: Phi (2, 4).
        hand: (2,), its stiffness [N/m] and damping [N s/m].
        limit: of the actuators [N].
        period: [s].
        f_master: commanded force on the hand's motion, positive resists positive motion (3,) [N].
        target_next: the hand's target at the end of the period (3,) [m].
        motion: x, v (6,).
        target: the hand's target at the start, moved to the end (3,) [m].
        f_hand: force of the hand at the end (3,) [N], written.
    """
    stiffness, damping = hand[0], hand[1]
    for i in range(3):
        speed = (target_next[i] - target[i]) / period
        force = min(max(f_master[i], -limit), limit)
        constant = stiffness * target[i] + damping * speed - force
        slope = stiffness * speed
        x, v = motion[i], motion[3 + i]
        for row in range(2):
            motion[3 * row + i] = (
                transition[row, 0] * x
                + transition[row, 1] * v
                + transition[row, 2] * constant
                + transition[row, 3] * slope
            )
        target[i] = target_next[i]
        f_hand[i] = stiffness * (target[i] - motion[i]) + damping * (speed - motion[3 + i])


class SimulatedMaster(LeafSystem):
    """A kinesthetic device in a hand.

    Input port:
        f_master (3): commanded force of the device, each axis; positive resists motion in the
            positive direction [N]
    Output ports, all discrete state:
        motion_master (6): x_m, v_m of the device from the centre of its workspace [m, m/s]
        hand_target (3): where the hand wants to be [m]
        f_hand (3): force of the hand on the device [N]
    Update, at t = k period: the motion from t to t + period, see `move_device`.
    Initial: at rest at zero.

    Args:
        master: checked.
        period: [s].
    """

    def __init__(self, master: Master, period: float = 1e-3) -> None:
        super().__init__()
        master.validate("master")
        checks.number("period", period, 1e-4, 0.1)
        self._period = period
        self._waypoints, self._sweep = master.waypoints(), master.sweep_parameters()
        self._transition = master.transition(period)
        self._hand = np.array([master.hand_stiffness, master.hand_damping])
        self._limit = float(master.actuator_limit)
        self._force = self.DeclareVectorInputPort("f_master", 3)
        self._motion = declare_state(self, 6, "motion_master")
        self._target = declare_state(self, 3, "hand_target")
        self._f_hand = declare_state(self, 3, "f_hand")
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._move)

    def _move(self, context: Context, discrete: DiscreteValues) -> None:
        f_master = self._force.Eval(context)
        if not all_finite(f_master, f_master):
            check_finite(self, context, (self._force,))
        target_next = np.empty(3)
        hand_target(context.get_time() + self._period, self._waypoints, self._sweep, target_next)
        move_device(
            self._transition,
            self._hand,
            self._limit,
            self._period,
            f_master,
            target_next,
            discrete.get_mutable_value(self._motion),
            discrete.get_mutable_value(self._target),
            discrete.get_mutable_value(self._f_hand),
        )
