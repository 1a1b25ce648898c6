"""The full arm in a bilateral teleoperation, for tests: plant, contact, control and coupling."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from kinds import of_kind
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlantConfig
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput, VectorLogSink

from scara_drake.channel.links import Channel
from scara_drake.control.integral_sliding_mode import IntegralSlidingMode
from scara_drake.environment import Environment, ImpedanceContact, Wall, add_surfaces
from scara_drake.ik.system import InverseKinematics, first_posture
from scara_drake.operator.master import Master
from scara_drake.robot import add_scara
from scara_drake.scenario import Coupling, Scenario
from scara_drake.wiring.bilateral import add_bilateral

LOGGED = (
    "motion_master", "f_master", "f_hand", "motion_limited", "energy_master", "energy_slave",
    "tool_command_received", "status",
)  # fmt: skip


@dataclass
class Arm:
    """The standard case: a wall of 1e4 N/m and 100 N s/m, 1 cm from the tool."""

    coupling: Coupling
    channel: Channel = field(default_factory=Channel)
    master: Master = field(default_factory=Master)
    wall: Wall = field(default_factory=Wall)
    inverse_kinematics: InverseKinematics = field(
        default_factory=lambda: InverseKinematics(bandwidth=400.0, max_acceleration=10.0)
    )

    def diagram(self, log: bool = True) -> Diagram:
        """Build the Diagram, with its logs."""
        builder = DiagramBuilder()
        plant, scene_graph = AddMultibodyPlant(MultibodyPlantConfig(time_step=1e-3), builder)
        plant.set_name("plant")
        add_scara(plant)
        environment = Environment([self.wall])
        add_surfaces(plant, scene_graph, environment)
        plant.Finalize()
        command = self.master.first_command()
        q_start = first_posture(self.inverse_kinematics, command, 0)
        plant.SetDefaultPositions(q_start)
        contact = builder.AddNamedSystem("contact", ImpedanceContact(environment))
        controller = builder.AddNamedSystem("controller", IntegralSlidingMode().make_system(1e-3))
        scenario = Scenario(
            operator=self.master, coupling=self.coupling, channel=self.channel,
            inverse_kinematics=self.inverse_kinematics,
        )  # fmt: skip
        force = contact.GetOutputPort("f_env_on_tool_W")
        signals = add_bilateral(builder, scenario, q_start, {"f_env_on_tool_W": force})
        state = plant.get_state_output_port()
        builder.Connect(state, contact.GetInputPort("state"))
        builder.Connect(
            contact.GetOutputPort("generalized_force"),
            plant.get_applied_generalized_force_input_port(),
        )
        builder.Connect(state, controller.GetInputPort("state"))
        builder.Connect(signals["state_desired"], controller.GetInputPort("state_desired"))
        builder.Connect(controller.GetOutputPort("actuation"), plant.get_actuation_input_port())
        if log:
            ports = {name: signals[name] for name in LOGGED}
            ports["f_env_on_tool_W"] = contact.GetOutputPort("f_env_on_tool_W")
            for name, port in ports.items():
                LogVectorOutput(port, builder, 1e-3).set_name("log_" + name)
        return builder.Build()

    def run(self, duration: float) -> dict[str, np.ndarray]:
        """Run, and return the logged signals (n, size) and the time (n,)."""
        diagram = self.diagram()
        simulator = Simulator(diagram)
        simulator.AdvanceTo(duration)
        result = {}
        for name in (*LOGGED, "f_env_on_tool_W"):
            sink = of_kind(VectorLogSink, diagram.GetSubsystemByName("log_" + name))
            log = sink.FindLog(simulator.get_context())
            result["time"], result[name] = log.sample_times(), log.data().T
        return result
