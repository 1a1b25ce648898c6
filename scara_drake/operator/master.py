r"""A simulated kinesthetic master: a device that can be pushed, and the hand that holds it.

Each axis of the device is a mass with viscous friction; the hand is a spring and a damper towards
its target, a voluntary motion,

.. math::

    m \ddot x + b \dot x = f_{\text{hand}} - f_{\text{device}}, \quad
    f_{\text{hand}} = K\,(x_t - x) + B\,(\dot x_t - \dot x)

with f_device the commanded force within the limit of the actuators. A period is integrated exactly
for a force that is held and a target that moves at constant speed, so the device exchanges just
the energy f_device (x(t + T) - x(t)) with its port, and none appears by integration: stiff hands
need no smaller step, and a meter that sums this product is exact.
"""

import math
from dataclasses import dataclass, field, fields
from typing import Final

import numpy as np
from numpy.typing import NDArray

from scara_drake.common import checks
from scara_drake.common.block import Block, Declaration, Input, Memory
from scara_drake.common.fields import check, choice, number, rows, vector
from scara_drake.kinematics import REACH
from scara_drake.operator.device_motion import DEVICE, move_device
from scara_drake.operator.hand import HAND_PATH, WAYPOINT, Sweep
from scara_drake.operator.kinesthetic_devices import DEVICES, OWN, KinestheticDevice
from scara_drake.operator.mapping import MAST_HIGH, MAST_LOW
from scara_drake.operator.master_steps import guided_step, master_step
from scara_drake.operator.policy import Policy
from scara_drake.vectors import held_command

Array = NDArray[np.float64]


_OWN_FIELDS: Final = (
    "mass", "damping", "actuator_limit", "friction", "resolution", "workspace"
)  # fmt: skip
_PRESS = [[0.0, 0.0, 0.0], [0.0, -0.04, 0.0], [0.0, -0.04, 0.0], [0.0, 0.0, 0.0]]


@dataclass
class Master:
    """An operator who moves a kinesthetic device.

    The hand's target starts at zero, the centre of the workspace, and goes from each of `targets`
    to the next with minimum jerk, at rest at its time; the last one is kept. The default presses
    3 cm into a wall that is 1 cm away along -y.

    Attributes:
        device: one that exists, with the figures of `kinesthetic_devices`; of `own` they are the
            next six fields.
        mass: of the device, each axis.
        damping: of the device.
        actuator_limit: largest force of the device, each axis.
        friction: Coulomb's, each axis.
        resolution: count of the encoders; 0 is infinitely fine.
        workspace: how far each axis goes from the centre; 0 is without an end.
        velocity_bandwidth: w of the driver's dirty derivative w s / (s + w) of the counts.
        hand_stiffness: K of the hand.
        hand_damping: B of the hand.
        times: of the targets, rising.
        targets: rows x, y, z of the hand's target in W's axes, from the centre.
        sweep: added to the target.
        policy: an operator who reacts, and moves the hand's target in place of `times` and
            `targets`; none if empty.
        centre: tool point at the device's centre, relative to the arm's base, in W's axes.
        rpy: held orientation of the tool, Rx(roll) Ry(pitch) Rz(yaw).
        mast_height: of the robot.
    """

    device: str = choice(OWN, (OWN, *DEVICES))
    mass: float = number(0.3, "kg", 1e-2, 100.0)
    damping: float = number(2.0, "N s/m", 0.0, 1e3)
    actuator_limit: float = number(40.0, "N", 0.0, 1e6)
    friction: float = number(0.0, "N", 0.0, 100.0)
    resolution: float = number(0.0, "m", 0.0, 1e-2)
    workspace: float = number(0.0, "m", 0.0, REACH)
    velocity_bandwidth: float = number(200.0, "rad/s", 1.0, 1e5)
    hand_stiffness: float = number(150.0, "N/m", 0.0, 1e4)
    hand_damping: float = number(4.0, "N s/m", 0.0, 1e3)
    times: list[float] = vector([1.0, 2.0, 6.0, 7.0], "s", 0.0, size=None)
    targets: list[list[float]] = rows(_PRESS, "m", -REACH, REACH)
    sweep: Sweep = field(default_factory=Sweep)
    policy: Policy | None = None
    centre: list[float] = vector([0.80, -1.04, 0.0], "m", -REACH, REACH)
    rpy: list[float] = vector([math.pi / 2, 0.0, 0.0], "rad", -2 * math.pi, 2 * math.pi)
    mast_height: float = number(3.0, "m", MAST_LOW, MAST_HIGH)

    def check_together(self, name: str) -> None:
        """Check the targets against their times and the device, and that one alone moves the hand.

        Raises:
            ValueError: targets without a time, times that do not rise, targets or places of a
                policy outside the device's workspace, a field that a device of a name has of its
                own, or a sweep beside a policy.
        """
        if self.policy is not None:
            checks.number(f"{name}.sweep.amplitude (with a policy)", self.sweep.amplitude, 0.0, 0.0)
        checks.vector(f"{name}.times", self.times, len(self.targets), 0.0)
        for index, (before, after) in enumerate(zip(self.times, self.times[1:], strict=False)):
            if after <= before:
                raise ValueError(f"{name}.times[{index + 1}]: {after}, allowed above {before:g}")
        self._check_device(name)

    def _check_device(self, name: str) -> None:
        """Check that nothing is given beside a device of a name, and that the targets fit."""
        if self.device != OWN:
            for entry in fields(self):
                value = getattr(self, entry.name)
                if entry.name in _OWN_FIELDS and value != entry.default:
                    raise ValueError(
                        f"{name}.{entry.name}: {checks.shown(value)}, allowed with device: {OWN} "
                        f"only, {self.device} has its own"
                    )
        end = self.hardware().workspace or math.inf
        where, places, more = f"{name}.targets", self.targets, " with the sweep"
        if self.policy is not None:
            where, places, more = f"{name}.policy.work.places", self.policy.work.places, ""
        for index, place in enumerate(places):
            way = math.hypot(*place) + self.sweep.amplitude
            if way > end:
                raise ValueError(
                    f"{where}[{index}]: {way:g} m from the centre{more}, allowed "
                    f"up to {end:g} m, the workspace of the device"
                )

    def hardware(self) -> KinestheticDevice:
        """Return the figures of the device."""
        if self.device != OWN:
            return DEVICES[self.device]
        return KinestheticDevice(
            force=self.actuator_limit,
            stiffness=math.inf,
            damping=math.inf,
            workspace=self.workspace,
            mass=self.mass,
            friction=self.friction,
            viscous=self.damping,
            resolution=self.resolution,
        )

    def first_command(self) -> Array:
        """Tool command (8,) at the centre: p_WE [m], quaternion w, x, y, z, mast height [m]."""
        return held_command(self.centre, self.rpy, self.mast_height)

    def waypoints(self) -> Array:
        """Rows (n, 4) for `hand_target_at`; the first is the rest at the centre before t = 0."""
        places = zip([-1.0, *self.times], [[0.0] * 3, *self.targets], strict=True)
        return np.array([WAYPOINT.pack(time=time, place=place) for time, place in places])

    def parameters(self, period: float) -> Array:
        """Return the device and the hand over a period [s] as `device_of` reads them."""
        hardware = self.hardware()
        return DEVICE.pack(
            transition=self.transition(period),
            stiffness=self.hand_stiffness,
            damping=self.hand_damping,
            limit=hardware.force,
            period=period,
            mass=hardware.mass,
            viscous=hardware.viscous + self.hand_damping,
            friction=hardware.friction,
            workspace=hardware.workspace or math.inf,
        )

    def transition(self, period: float) -> Array:
        """Return `Phi` (2, 4) of the device and the hand over one period, see `move_device`."""
        hardware = self.hardware()
        m, b = hardware.mass, hardware.viscous + self.hand_damping
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


class SimulatedMaster(Block):
    """A kinesthetic device in a hand.

    Ports:
        input f_master (3) [N]: commanded force of the device, each axis; positive resists motion in
            the positive direction.
        input hand_wanted (3) [m]: hand_target a period later; with a policy only.
        output motion_master (6) [m, m/s]: x_m, v_m of the device from the centre of its workspace.
        output hand_target (3) [m]: where the hand wants to be.
        output f_hand (3) [N]: force of the hand on the device.

    Update, at t = k period: the motion from t to t + period, see `move_device`.
    Initial: at rest at zero.

    Args:
        master: the operator.
        period: [s].

    Raises:
        ValueError: a field of the master, or the period, is out of its bounds.
    """

    def __init__(self, master: Master, period: float = 1e-3) -> None:
        check(master, "master")
        checks.number("period", period, 1e-4, 0.1)
        guided = master.policy is not None
        super().__init__(
            Declaration(
                inputs={"f_master": Input(3, finite=True)}
                | ({"hand_wanted": Input(3)} if guided else {}),
                memory={
                    "motion_master": Memory(6, port=True),
                    "hand_target": Memory(3, port=True),
                    "f_hand": Memory(3, port=True),
                },
                parameters={
                    "device": master.parameters(period),
                    "hand_path": HAND_PATH.pack(
                        sweep=master.sweep.parameters(), waypoints=master.waypoints().ravel()
                    ),
                },
                period=period,
                update=guided_step if guided else master_step,
            )
        )


__all__ = ["Master", "SimulatedMaster", "move_device"]
