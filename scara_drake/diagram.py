"""The wiring of a scenario, and nothing else: it reads like the block diagram.

::

    joystick -> mapping -> uplink -> inverse_kinematics -> governor -> controller -> drives -> plant
        ^                                                                                      |  ^
        '--- haptics <----------------- downlink <----------------- contact <-----------------'--'

With a master that can be pushed, its coupling takes the place of mapping and haptics. The parts of
the wiring are in `wiring`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import Meshcat, SceneGraph
from pydrake.multibody.plant import (
    AddMultibodyPlant,
    MultibodyPlant,
    MultibodyPlantConfig,
)
from pydrake.systems.framework import Diagram, DiagramBuilder

from scara_drake.control import contact_estimate
from scara_drake.display.scene import add_visualization
from scara_drake.environment import ContactShapes, ImpedanceContact, add_surfaces
from scara_drake.ik.system import first_posture
from scara_drake.operator.joint_motion import JointMotion, JointMotionSource
from scara_drake.operator.joystick import Joystick
from scara_drake.operator.mapping import initial_command
from scara_drake.operator.master import Master
from scara_drake.recordings.recorder import Origin, add_recorder
from scara_drake.robot import add_scara
from scara_drake.scenario import Scenario, dump_scenario
from scara_drake.wiring import Signals, outputs
from scara_drake.wiring.bilateral import add_bilateral
from scara_drake.wiring.control import add_control, add_drives, add_forces
from scara_drake.wiring.joystick import add_joystick

Array = NDArray[np.float64]


def make_diagram(scenario: Scenario, meshcat: Meshcat | None = None) -> Diagram:
    """Build the Diagram of a scenario; every system and exported port is named.

    The scenario is not changed. With a meshcat the Diagram also draws itself there; what it
    computes stays the same to the bit.

    Raises:
        ValueError: the scenario is not valid, or its first tool command cannot be reached.
    """
    scenario.validate()
    builder = DiagramBuilder()
    q_start = start_posture(scenario)
    plant, scene_graph, shapes = _add_plant(builder, scenario, q_start)
    signals: Signals = {"state": plant.get_state_output_port()}
    if scenario.environment.surfaces:
        signals |= _add_contact(builder, scenario, plant, shapes)
    operator = scenario.operator
    if isinstance(operator, JointMotion):
        signals |= _add_joint_motion(builder, operator)
    elif isinstance(operator, Master):
        signals |= add_bilateral(
            builder,
            operator,
            scenario.coupling,
            scenario.channel,
            scenario.inverse_kinematics,
            q_start,
            signals.get("f_env_on_tool_W"),
            scenario.time_step,
            (scenario.stream(0), scenario.stream(1), scenario.seed),
        )
    else:
        signals |= add_joystick(builder, scenario, operator, q_start, signals)
    signals |= add_control(builder, scenario, q_start, signals)
    signals |= add_drives(builder, scenario, plant, signals)
    add_forces(builder, scenario, plant, signals)

    add_recorder(
        builder,
        signals,
        _origin(scenario),
        _slow_signals(scenario),
        scenario.time_step,
        scenario.logging.period,
    )
    for name, port in signals.items():
        builder.ExportOutput(port, name)
    if meshcat is not None:
        annotations = add_visualization(builder, plant, scene_graph, meshcat, scenario.environment)
        for name in ("state", "X_WE_desired", "f_env_on_tool_W"):
            if name in signals:
                builder.Connect(signals[name], annotations.GetInputPort(name))
    diagram = builder.Build()
    diagram.set_name(scenario.name or "scara")
    return diagram


def start_posture(scenario: Scenario) -> Array:
    """Return q (6,) at t = 0: `q0`, or where the first reference is."""
    if scenario.q0 is not None:
        return np.array(scenario.q0, dtype=np.float64)
    if isinstance(scenario.operator, JointMotion):
        return scenario.operator.start_state()[:6]
    if isinstance(scenario.operator, Master):
        command = scenario.operator.first_command()
    else:
        command = initial_command(scenario.operator.mapping)
    return first_posture(scenario.inverse_kinematics, command, scenario.seed)


def _add_plant(
    builder: DiagramBuilder, scenario: Scenario, q_start: Array
) -> tuple[MultibodyPlant, SceneGraph, ContactShapes]:
    config = MultibodyPlantConfig(time_step=scenario.time_step)
    plant, scene_graph = AddMultibodyPlant(config, builder)
    plant.set_name("plant")
    scene_graph.set_name("scene_graph")
    add_scara(plant, scenario.robot)
    shapes = add_surfaces(plant, scene_graph, scenario.environment)
    plant.Finalize()
    plant.SetDefaultPositions(q_start)
    return plant, scene_graph, shapes


def _add_contact(
    builder: DiagramBuilder, scenario: Scenario, plant: MultibodyPlant, shapes: ContactShapes
) -> Signals:
    contact = builder.AddNamedSystem(
        "contact", ImpedanceContact(scenario.environment, scenario.time_step, shapes)
    )
    builder.Connect(plant.get_state_output_port(), contact.GetInputPort("state"))
    if contact.HasInputPort("contact_results"):
        results = plant.get_contact_results_output_port()
        builder.Connect(results, contact.GetInputPort("contact_results"))
    return dict(outputs(contact))


def _add_joint_motion(builder: DiagramBuilder, motion: JointMotion) -> Signals:
    source = builder.AddNamedSystem("joint_motion", JointMotionSource(motion))
    return dict(outputs(source))


def _origin(scenario: Scenario) -> Origin:
    surfaces = tuple(surface.name for surface in scenario.environment.surfaces)
    return Origin(scenario.name, dump_scenario(scenario), scenario.seed, surfaces)


def _slow_signals(scenario: Scenario) -> dict[str, float]:
    """Return the periods [s] of the signals that change less often than every time step."""
    slow = {"f_estimated_W": contact_estimate.PERIOD}
    if isinstance(scenario.operator, Joystick):
        slow["joystick_axes"] = scenario.operator.sample_period
        slow["rumble"] = scenario.haptics.period
    return slow
