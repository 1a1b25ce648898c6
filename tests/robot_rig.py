"""The robot's supervisor before its inverse kinematics, without a plant: the arm is its references.

What the two watches find is given, or found by the watch over the arm from what is measured.
"""

from __future__ import annotations

import numpy as np

from scara_drake.ik.kernels.limiter import LIMITS
from scara_drake.ik.restart import restarting_step
from scara_drake.ik.servo import servo_state_at
from scara_drake.ik.system import InverseKinematics
from scara_drake.joints import HOME, LOWER, MAX_SPEED, UPPER
from scara_drake.safety import Reason, State
from scara_drake.supervision.config import RobotSupervision
from scara_drake.supervision.layouts import ARM_CONDITION, LINK_CONDITION, SUPERVISOR
from scara_drake.supervision.robot import RobotSupervisor, supervise
from scara_drake.vectors import (
    COMMAND_FRAME,
    SERVO_STATE,
    STATE,
    SUPERVISOR_STATUS,
    TOOL_COMMAND,
    pose_vector,
)

DT = 1e-3


def command_at(q):
    """The tool command (8,) of a posture."""
    pose = pose_vector(q)
    return TOOL_COMMAND.pack(p=pose[:3], quaternion=pose[3:], mast=q[0])


def moved(command, p=(0.0, 0.0, 0.0), mast=0.0):
    """A command shifted by p (3,) [m], with the mast and the tool on it lifted."""
    parts = TOOL_COMMAND.unpack(command.copy())
    return TOOL_COMMAND.pack(
        p=parts.p + p + [0.0, 0.0, mast], quaternion=parts.quaternion, mast=parts.mast + mast
    )


class Rig:
    """Steps supervisor and servo as a Diagram does: each reads what the other had before.

    Attributes:
        command: (8,) that the operator sends.
        operator: state of his supervisor, and its count of engagements.
        lost: whether the command is.
        arm: reason of a fault that the watch over the arm finds, and the force.
        history: references (n, 12), limiters (n, 17) and status (n, 4) of all ticks.
    """

    def __init__(self, q=HOME, config=None, **kinematics):
        self.kinematics = InverseKinematics(**kinematics)
        self.command = command_at(q)
        block = RobotSupervisor(config or RobotSupervision(), self.kinematics, self.command, DT)
        is_ = block.declaration
        self.bounds = is_.parameters["bounds"]
        self.supervisor = np.array(is_.memory["supervisor"].initial)
        self.drives = np.ones(1)
        self.settings = self.kinematics.settings(DT)
        self.limits = LIMITS.pack(lower=LOWER, upper=UPPER, rate=MAX_SPEED)
        self.desired, self.servo = np.concatenate([q, np.zeros(6)]), servo_state_at(np.array(q))
        self.operator, self.engagements = State.IDLE, 0
        self.lost, self.arm, self.force = False, Reason.NONE, np.zeros(3)
        self.link_fault, self.measured = Reason.NONE, None
        self.references, self.limiters, self.statuses = [], [], []

    def engage(self):
        """Let the operator engage anew."""
        self.operator, self.engagements = State.ACTIVE, self.engagements + 1

    def frame(self):
        """What arrives (10,)."""
        return COMMAND_FRAME.pack(
            tool_command=self.command,
            state=float(self.operator),
            engagements=float(self.engagements),
        )

    def step(self, ticks=1, frame=None):
        """Advance; return the status."""
        for _ in range(ticks):
            state = self.desired if self.measured is None else self.measured
            tool = command_at(state[:6])
            arm = ARM_CONDITION.pack(
                fault=float(self.arm), warning=0.0, f=self.force, tool=tool,
                away=0.0, force=float(np.linalg.norm(self.force)), efforts=0.0,
            )  # fmt: skip
            link = LINK_CONDITION.pack(lost=float(self.lost), fault=float(self.link_fault))
            let = SUPERVISOR.unpack(self.supervisor)
            command, restart = let.command.copy(), np.array([float(let.restart[()])])
            servo, desired = self.servo.copy(), self.desired.copy()
            arrived = self.frame() if frame is None else frame
            restarting_step(
                command, restart, state, self.desired, self.servo, self.settings, self.limits
            )
            supervise(arrived, link, arm, servo, desired, self.bounds, self.supervisor, self.drives)
            self.references.append(self.desired.copy())
            self.limiters.append(self.servo.copy())
            self.statuses.append(let.status.copy())
        return self.status

    @property
    def status(self):
        """State, reason, engagements and faults of the supervisor."""
        now = SUPERVISOR_STATUS.unpack(SUPERVISOR.unpack(self.supervisor).status)
        return State(int(now.state)), Reason(int(now.reason)), int(now.engagements), int(now.faults)

    @property
    def let_through(self):
        """The command (8,) that is let through."""
        return SUPERVISOR.unpack(self.supervisor).command

    def velocities(self):
        """Of the tool point in the limiter (n, 3), and of the mast (n,)."""
        limiters = np.array(self.limiters)
        return (
            limiters[:, SERVO_STATE.slices["v"]],
            limiters[:, SERVO_STATE.slices["mast_rate"].start],
        )

    def joint_rates(self):
        """Of the references (n, 6)."""
        return np.array(self.references)[:, STATE.slices["v"]]
