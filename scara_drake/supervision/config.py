"""What a scenario says of its supervisors."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

from scara_drake.common import checks
from scara_drake.common.fields import ABOVE_ZERO, choice, number, vector
from scara_drake.operator.supervision import OperatorSupervision

AFTER_OUTAGE: Final = ("engage", "resume")
ENGAGE, RESUME = range(len(AFTER_OUTAGE))


@dataclass
class RobotSupervision:
    """Bounds of the robot's supervisor, which stands between the channel and the robot.

    Attributes:
        age_limit: time without a packet, beyond the channel's delay, from which on the command
            counts as lost; for an uplink of packets.
        after_outage: what follows when it comes again: "engage" waits until the operator engages
            again, "resume" goes on at once. In either case the arm goes on from where it stands:
            what was asked meanwhile is not made up.
        reach_share: of the arm's reach, up to which commands are followed.
        box_lower: corner of the workspace, in W.
        box_upper: corner of the workspace, in W.
        joint_margin: of the joints from their limits, within which they move inwards only.
        horizon: how far ahead a joint's way to its margin is looked at.
        singularity_slow: smallest singular value of the controlled rows of the Jacobian from which
            on outward motion is slowed; rotations count by the solver's length.
        singularity_stop: the same at which it ends.
        max_force: contact force from which on the tool backs off.
        retract: how far it does at a time, along the force; no more than 0.1 m altogether.
        release_share: of `max_force`, below which it has backed off far enough.
        tracking_tool: of the tool from its reference, from which on the arm counts as lost.
        tracking_angle: the same of a joint.
        tracking_time: for how long either.
        energy_bound: that the channel may give beyond what it took.
        chatter: rate at which the efforts vary, in their limits, from which on they chatter.
        warn_time: for how long a condition has to last that is only warned of.
    """

    age_limit: float = number(0.1, "s", ABOVE_ZERO, 10.0)
    after_outage: str = choice("engage", AFTER_OUTAGE)
    reach_share: float = number(0.98, "1", 0.1, 1.0)
    box_lower: list[float] = vector([-20.0] * 3, "m", -20.0, 20.0)
    box_upper: list[float] = vector([20.0] * 3, "m", -20.0, 20.0)
    joint_margin: list[float] = vector([0.02] * 6, "m | rad", 0.0, 0.5)
    horizon: float = number(0.25, "s", 0.01, 2.0)
    singularity_slow: float = number(0.05, "m/rad", 0.0, 1.0)
    singularity_stop: float = number(0.015, "m/rad", 0.0, 1.0)
    max_force: float = number(500.0, "N", ABOVE_ZERO, 1e5)
    retract: float = number(0.005, "m", 0.0, 0.1)
    release_share: float = number(0.2, "1", 0.0, 1.0)
    tracking_tool: float = number(0.05, "m", 1e-3, 1.0)
    tracking_angle: float = number(0.1, "rad", 1e-3, 1.0)
    tracking_time: float = number(0.1, "s", 0.0, 1.0)
    energy_bound: float = number(100.0, "J", 0.0, 1e6)
    chatter: float = number(50.0, "1/s", ABOVE_ZERO, 1e6)
    warn_time: float = number(0.05, "s", 0.0, 1.0)

    def check_together(self, name: str) -> None:
        """Check that the bounds leave something between them.

        Raises:
            ValueError: they do not.
        """
        for axis, (low, high) in enumerate(zip(self.box_lower, self.box_upper, strict=True)):
            checks.number(f"{name}.box_upper[{axis}]", high, low + 1e-3, 20.0)
        checks.number(
            f"{name}.singularity_slow", self.singularity_slow, self.singularity_stop + 1e-6, 1.0
        )


@dataclass
class Supervision:
    """The supervisors of a scenario: with them it stops by itself where it has to.

    Attributes:
        operator: when the operator's side stops.
        robot: bounds of the robot's side.
    """

    operator: OperatorSupervision = field(default_factory=OperatorSupervision)
    robot: RobotSupervision = field(default_factory=RobotSupervision)
