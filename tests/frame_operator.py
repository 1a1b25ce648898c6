"""A supervised arm in its Diagram, commanded by frames from outside, stepped by Drake."""

from __future__ import annotations

import numpy as np
from pydrake.systems.analysis import Simulator

from scara_drake import load_scenario, make_diagram
from scara_drake.operator.external import External
from scara_drake.safety import Reason, State
from scara_drake.vectors import COMMAND_FRAME, SUPERVISOR_STATUS, TOOL_COMMAND

DT = 1e-3
BASE = {
    "operator": "!External {port: command_frame}",
    "channel": "{}",
    "supervision": "{}",
    "duration": 100.0,
}
LAST = 1e-7  # [s] after a tick, so that its updates are made


def first_command(operator):
    """The command (8,) with which an operator from outside begins."""
    assert isinstance(operator, External)
    return np.array(operator.first_command())


class Arm:
    """A supervised arm.

    Attributes:
        first: (8,), where the arm starts.
        command: (8,) that is sent.
        operator: the state that is sent, and its count of engagements.
        rows: of every tick: state (12,), references (12,), effort (6,), status (4,), and the effort
            (6,) on the joints.
    """

    def __init__(self, base="teleoperation", **changes):
        changes = {key.replace("__", "."): value for key, value in changes.items()}
        self.scenario = load_scenario(base, {**BASE, **changes})
        self.diagram = make_diagram(self.scenario)
        self.simulator = Simulator(self.diagram)
        self.simulator.Initialize()
        self.context = self.simulator.get_context()
        self.first = first_command(self.scenario.operator)
        self.command = self.first.copy()
        self.operator, self.engagements = State.IDLE, 0
        self._inputs = {
            name: self.diagram.GetInputPort(name)
            for name in ("command_frame", "applied_generalized_force")
        }
        self._brakes = self.diagram.GetSubsystemByName("brakes")
        self._ports = [
            self.diagram.GetOutputPort(name)
            for name in ("state", "state_desired", "actuation", "robot_status")
        ]
        self.rows, self.ticks = [], 0
        self.push(np.zeros(6))

    def push(self, forces):
        """Let forces (6,) act on the joints from now on [N, N m]."""
        self._inputs["applied_generalized_force"].FixValue(self.context, np.array(forces))

    def engage(self):
        """Let the operator engage anew."""
        self.operator, self.engagements = State.ACTIVE, self.engagements + 1

    def reset(self):
        """Let the operator's side know of the fault, and reset it."""
        for state in (State.FAULT, State.IDLE):
            self.operator = state
            self.step(3)

    def step(self, ticks=1, way=(0.0, 0.0, 0.0), mast=0.0):
        """Advance, the command moving at some speeds [m/s]; return the status."""
        for _ in range(ticks):
            parts = TOOL_COMMAND.unpack(self.command)
            parts.p[:] += DT * np.add(way, [0.0, 0.0, mast])
            parts.mast[()] += DT * mast
            frame = COMMAND_FRAME.pack(
                tool_command=self.command,
                state=float(self.operator),
                engagements=float(self.engagements),
            )
            self._inputs["command_frame"].FixValue(self.context, frame)
            self.simulator.AdvanceTo(self.ticks * DT + LAST)
            self.ticks += 1
            row = [port.Eval(self.context).copy() for port in self._ports]
            own = self._brakes.GetMyContextFromRoot(self.context)
            acts = self._brakes.GetOutputPort("actuation_braked").Eval(own)
            self.rows.append([*row, acts.copy()])
        return self.status

    @property
    def status(self):
        """State, reason, engagements and faults."""
        now = SUPERVISOR_STATUS.unpack(self.rows[-1][3])
        return State(int(now.state)), Reason(int(now.reason)), int(now.engagements), int(now.faults)

    def column(self, index):
        """One of `rows`, of all ticks."""
        return np.array([row[index] for row in self.rows])
