"""The wiring of the plant: the robot, the surfaces around it, and the contact between them.

::

    (forces) -> plant -> state -> contact -> f_env_on_tool_W, generalized_force, penetration

A pipe that is cut adds its force to that of the contact.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlantConfig
from pydrake.systems.framework import DiagramBuilder

from scara_drake.environment import ImpedanceContact, PipeCutting, add_surfaces
from scara_drake.robot import add_scara
from scara_drake.wiring import Signals, outputs

if TYPE_CHECKING:
    from scara_drake.scenario import Scenario

Array = NDArray[np.float64]

# Of the plant, beside its state: for cameras, rewards and sensors of one's own.
SHOWN = (
    "body_poses",
    "body_spatial_velocities",
    "body_spatial_accelerations",
    "contact_results",
    "reaction_forces",
    "net_actuation",
)


def add_plant(
    builder: DiagramBuilder, scenario: Scenario, q_start: Array, signals: Signals
) -> Signals:
    """Add the robot at `q_start`, the surfaces, and where there are any the contact with them."""
    config = MultibodyPlantConfig(time_step=scenario.time_step)
    plant, scene_graph = AddMultibodyPlant(config, builder)
    plant.set_name("plant")
    scene_graph.set_name("scene_graph")
    add_scara(plant, scenario.robot)
    shapes = add_surfaces(plant, scene_graph, scenario.environment)
    plant.Finalize()
    plant.SetDefaultPositions(q_start)
    made: Signals = {"state": plant.get_state_output_port()}
    made |= {name: plant.GetOutputPort(name) for name in SHOWN}
    made["query_object"] = scene_graph.get_query_output_port()
    if scenario.environment.surfaces:
        contact = builder.AddNamedSystem(
            "contact", ImpedanceContact(scenario.environment, scenario.time_step, shapes)
        )
        builder.Connect(made["state"], contact.GetInputPort("state"))
        if contact.HasInputPort("contact_results"):
            results = plant.get_contact_results_output_port()
            builder.Connect(results, contact.GetInputPort("contact_results"))
        made |= dict(outputs(contact))
    if scenario.environment.cut is not None:
        made |= _add_cutting(builder, scenario, made)
    return signals | made


def _add_cutting(builder: DiagramBuilder, scenario: Scenario, made: Signals) -> Signals:
    """Add the blade and its pipe; its outputs take the place of the contact's."""
    pipe = scenario.environment.cut
    assert pipe is not None  # it is asked for where there is one
    cutting = builder.AddNamedSystem("cutting", PipeCutting(pipe, scenario.time_step))
    builder.Connect(made["state"], cutting.GetInputPort("state"))
    for port, name in (
        ("f_surfaces_W", "f_env_on_tool_W"),
        ("effort_surfaces", "generalized_force"),
    ):
        if name in made:
            builder.Connect(made[name], cutting.GetInputPort(port))
    return dict(outputs(cutting))
