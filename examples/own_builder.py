"""The robot in a builder of one's own, beside a system of one's own.

What `make_diagram` returns is a Diagram like any other. Here its operator is `External`, so that it
has an input `tool_command`, and a system of ours writes a circle there; what the robot does goes to
a log of ours.

    python examples/own_builder.py
"""

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import BasicVector, Context, DiagramBuilder, LeafSystem
from pydrake.systems.primitives import LogVectorOutput

import scara_drake as sd
from scara_drake.operator.external import External
from scara_drake.vectors import TOOL_COMMAND

RADIUS, PERIOD = 0.1, 6.0  # [m], [s]
DELAY = 0.05  # [s] of the channel from the operator to the robot


class Circle(LeafSystem):
    """Leads the tool round a level circle that begins where the tool stands.

    Args:
        first: tool command (8,) at the start.
    """

    def __init__(self, first: np.ndarray) -> None:
        super().__init__()
        self._first = first
        ticket = {self.time_ticket()}
        self.DeclareVectorOutputPort("tool_command", first.size, self._command, ticket)

    def _command(self, context: Context, output: BasicVector) -> None:
        command = self._first.copy()
        TOOL_COMMAND.unpack(command).p[:] += along_circle(context.get_time())
        output.SetFromVector(command)


def along_circle(time: float) -> np.ndarray:
    """Where the command is from its start [m]."""
    angle = 2 * np.pi * time / PERIOD
    return RADIUS * np.array([np.cos(angle) - 1.0, np.sin(angle), 0.0])


settings = {
    "operator": "!External {port: tool_command}",
    "channel.up": f"!ConstantDelay {{delay: {DELAY}}}",
}
scenario = sd.load_scenario("free_motion", settings)
assert isinstance(scenario.operator, External)
first = scenario.operator.first_command()

builder = DiagramBuilder()
robot = builder.AddNamedSystem("robot", sd.make_diagram(scenario))
circle = builder.AddNamedSystem("circle", Circle(first))
builder.Connect(circle.GetOutputPort("tool_command"), robot.GetInputPort("tool_command"))
log = LogVectorOutput(robot.GetOutputPort("state"), builder, publish_period=0.01)
simulator = Simulator(builder.Build())
simulator.AdvanceTo(2 * PERIOD)

found = log.FindLog(simulator.get_context())
times, postures = found.sample_times(), found.data()[:6].T
tool = np.array([sd.kinematics.forward_kinematics(q)[:3, 3] for q in postures])
start = TOOL_COMMAND.unpack(first).p
asked = start + np.array([along_circle(max(time - DELAY, 0.0)) for time in times])
late = times > 1.0
radii = np.linalg.norm(tool - (start - [RADIUS, 0.0, 0.0]), axis=1)
off = np.linalg.norm(tool - asked, axis=1)
print(
    f"radius of the tool's way: {1e3 * radii[late].min():.2f} to {1e3 * radii[late].max():.2f} mm"
)
print(f"largest distance from the command of {DELAY} s ago: {1e3 * off[late].max():.2f} mm")
